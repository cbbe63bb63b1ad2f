"""Result records whose fields describe their quantities: key, unit, definition and number format.

JSON output, tables and the manual use these definitions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field
from functools import partial
from typing import Any, TypeVar, dataclass_transform, overload

Class = TypeVar("Class")
Getter = TypeVar("Getter", bound=Callable[..., object])


@dataclass(frozen=True)
class QuantityDescription:
    """Description of a quantity in the results: its key in JSON, its definition, and how it is shown in tables."""

    #: Key in JSON, whose ending gives the unit; a dot in the key separates the name of a JSON table from the name in it.
    key: str
    #: Definition of the quantity, with formula and sign where needed.
    definition: str = ""
    #: Description of the error of the value; empty for values without error.
    error: str = ""
    #: Name in tables; `solve` always shows quantities with a heading. Empty: the name is made from the key, and the
    #: quantity is shown with ``--verbose`` only.
    heading: str = ""
    #: Format of a number in tables.
    form: str = "g5"
    #: Suffix of the key for the entries of a value that is a list or table: ``[]`` for a list, ``.*`` for any keys,
    #: ``.FLANK`` for the four flanks.
    parts: str = ""
    #: Function that converts the field's value (SI units) to the value shown; None: the value is shown unchanged.
    show: Callable[[Any], object] | None = field(default=None, compare=False)
    #: Expected error of a low-order model for this quantity: name of the field of
    #: `compare.models.model_form.ExpectedError` that holds this error, and a factor on the error.
    expected: tuple[str, float] = ("", 0.0)
    #: Text after the value in the table of results; keys in braces are replaced by the values of the record, as in
    #: ``"ball {ball} {side}"``.
    note: str = ""
    #: Whether the key is left out where the field is None.
    optional: bool = False

    def shown(self, value: object) -> object:
        """Return the value shown in results, in the unit of the key, for a value of the field in SI units."""
        return value if self.show is None else self.show(value)

    def __call__(self, getter: Getter) -> Getter:
        """Attach this description to the function of a property (use as a decorator), and return the function."""
        getter.__dict__["stated"] = (self, *getter.__dict__.get("stated", ()))
        return getter


def quantity_field(
    key: str,
    definition: str = "",
    *also: QuantityDescription,
    default: Any = MISSING,
    default_factory: Any = MISSING,
    **others: Any,
) -> Any:
    """Return a dataclass field of a result record, with the description of its quantity attached.

    Parameters
    ----------
    key, definition
        Key and definition, as the fields of `QuantityDescription`.
    *also : QuantityDescription
        Descriptions of further keys that are computed from the same value.
    default, default_factory : Any, default MISSING
        Default of the field, as for ``dataclasses.field``.
    **others : Any
        Error, heading, format and other properties, as the further fields of `QuantityDescription`.

    Returns
    -------
    dataclasses.Field
        The field, for the body of a dataclass decorated by `result_record`.

    Examples
    --------
    >>> @result_record
    ... class Contact:
    ...     force: float = quantity_field("force_N", "its load F")
    >>> Contact(2.0).force, quantity_descriptions(Contact)[0][1].definition
    (2.0, 'its load F')
    """
    stated = QuantityDescription(key, definition, **others), *also
    given: dict[str, Any] = {"default": default, "default_factory": default_factory}
    return field(**given, metadata={"stated": stated})


#: `quantity_field` of a quantity that does not exist in every record: None by default.
quantity_or_none = partial(quantity_field, default=None)
#: `quantity_field` of a text, or of a number of a part, that may be empty or 0 (the default), which is null in JSON.
text_or_none = partial(quantity_field, show=lambda words: words or None, default="")


@overload
def result_record(cls: type[Class], /) -> type[Class]: ...
@overload
def result_record(*, eq: bool = True, repr: bool = True, kw_only: bool = False) -> Callable[[type[Class]], type[Class]]: ...
@dataclass_transform(frozen_default=True, field_specifiers=(field, quantity_field))
def result_record(cls: type[Class] | None = None, /, **options: bool) -> Any:
    """Make a class a frozen dataclass whose fields may be defined by `quantity_field` (a class decorator).

    Parameters
    ----------
    cls : type[Class] | None, default None
        Class to decorate; None where the decorator is called with options.
    **options : bool
        Options of ``dataclasses.dataclass``.

    Returns
    -------
    type
        The dataclass; the decorator where ``cls`` is None.
    """
    made = dataclass(frozen=True, **options)
    return made if cls is None else made(cls)


def quantity_descriptions(kind: type) -> tuple[tuple[str, QuantityDescription], ...]:
    """List the descriptions of all quantities of a result record: of its fields, properties and methods.

    Parameters
    ----------
    kind : type
        Class of the record.

    Returns
    -------
    tuple[tuple[str, QuantityDescription], ...]
        Pairs of a name and the description of its quantity, in the order of the class.
    """
    fields = [(name, x.metadata) for name, x in getattr(kind, "__dataclass_fields__", {}).items()]
    members = [(name, getattr(x, "fget", x)) for each in reversed(kind.__mro__) for name, x in vars(each).items()]
    of_members = [(name, getattr(x, "__dict__", {})) for name, x in members]
    return tuple((name, x) for name, of in (*fields, *of_members) for x in of.get("stated", ()))
