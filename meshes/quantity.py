"""Records whose fields state the quantity they hold; JSON, tables and the manual take it from there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field
from typing import Any, TypeVar, dataclass_transform, overload

Class = TypeVar("Class")
Getter = TypeVar("Getter", bound=Callable[..., object])


@dataclass(frozen=True)
class Stated:
    """What is stated of a quantity: its key, definition and format.

    As a decorator below ``@property`` it is stated of a property; of a method it is only a definition.
    """

    #: Key in JSON, whose ending gives the unit; with a dot where it is in a table there.
    key: str
    #: What the quantity is, with its formula and sign where needed.
    definition: str = ""
    #: Error of the value; empty where it has none.
    error: str = ""
    #: Name in tables, and the mark of an answer that `solve` always shows; empty: made of the key, shown by ``--verbose``.
    heading: str = ""
    #: Format of a number in tables.
    form: str = "g5"
    #: What follows the key in the paths of its parts: ``[]`` of a list, ``.*`` of any keys, ``.FLANK`` of the four
    #: flanks.
    parts: str = ""
    #: Function of the field's value (SI units) that gives what is shown; None: the value.
    show: Callable[[Any], object] | None = field(default=None, compare=False)
    #: Error to expect of a model: field of `compare.models.model_form.ModelForm`, and how many times of it.
    expected: tuple[str, float] = ("", 0.0)
    #: What stands behind it in the table of answers, with values of its record by their keys: ``"ball {ball} {side}"``.
    note: str = ""

    def shown(self, value: object) -> object:
        """Value as it is shown, from that of the field."""
        return value if self.show is None else self.show(value)

    def __call__(self, getter: Getter) -> Getter:
        """Attach the statement to the getter of a property, and return the getter."""
        getter.__dict__["stated"] = (self, *getter.__dict__.get("stated", ()))
        return getter


def quantity(
    key: str,
    definition: str = "",
    *also: Stated,
    error: str = "",
    heading: str = "",
    form: str = "g5",
    parts: str = "",
    show: Callable[[Any], object] | None = None,
    expected: tuple[str, float] = ("", 0.0),
    note: str = "",
    default: Any = MISSING,
    default_factory: Any = MISSING,
) -> Any:
    """Field of a `record` with what is stated of its quantity.

    Parameters
    ----------
    key, definition
        As the fields of `Stated`.
    *also : Stated
        Further keys, with what they show of the same value.
    error, heading, form, parts, show, expected, note
        As the fields of `Stated`.
    default, default_factory : Any, default MISSING
        As of ``dataclasses.field``.

    Returns
    -------
    dataclasses.Field
        The field.

    Examples
    --------
    >>> @record
    ... class Contact:
    ...     force: float = quantity("force_N", "its load F")
    >>> Contact(2.0).force, stated_in(Contact)[0][1].definition
    (2.0, 'its load F')
    """
    stated = Stated(key, definition, error, heading, form, parts, show, expected, note), *also
    given: dict[str, Any] = {"default": default, "default_factory": default_factory}
    return field(**given, metadata={"stated": stated})


@overload
def record(cls: type[Class], /) -> type[Class]: ...
@overload
def record(*, eq: bool = True, repr: bool = True, kw_only: bool = False) -> Callable[[type[Class]], type[Class]]: ...
@dataclass_transform(frozen_default=True, field_specifiers=(field, quantity))
def record(cls: type[Class] | None = None, /, **options: bool) -> Any:
    """Make a frozen dataclass, some fields of which are a `quantity`.

    Parameters
    ----------
    cls : type[Class] | None, default None
        Class to decorate; None where options are given.
    **options : bool
        As of ``dataclasses.dataclass``.

    Returns
    -------
    type
        The dataclass, or the decorator.
    """
    made = dataclass(frozen=True, **options)
    return made if cls is None else made(cls)


def stated_in(kind: type) -> tuple[tuple[str, Stated], ...]:
    """List what is stated of the fields, properties and methods of a record.

    Parameters
    ----------
    kind : type
        Record class.

    Returns
    -------
    tuple[tuple[str, Stated], ...]
        Pairs of a name and its statement, in the order of the class.
    """
    fields = [(name, x.metadata) for name, x in getattr(kind, "__dataclass_fields__", {}).items()]
    members = [(name, getattr(x, "fget", x)) for each in reversed(kind.__mro__) for name, x in vars(each).items()]
    of_members = [(name, getattr(x, "__dict__", {})) for name, x in members]
    return tuple((name, x) for name, of in (*fields, *of_members) for x in of.get("stated", ()))
