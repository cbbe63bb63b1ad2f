"""Records whose fields state what they hold; JSON, tables and the manual read it there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field
from typing import Any, TypeVar, dataclass_transform, overload

Class = TypeVar("Class")
Getter = TypeVar("Getter", bound=Callable[..., object])


@dataclass(frozen=True)
class Stated:
    """What is stated of a quantity. As a decorator, below ``@property``, it is stated of a property; of a method it is only
    a definition.

    key: in JSON, whose ending says the unit, with a dot where it is in a table there; definition: formula and sign where it
    needs them; error: of the value, empty where it has none; heading: in tables, else the words of the key; form: of a
    number in tables; parts: what follows the key in the paths of its parts, ``[]`` of a list, ``.*`` of any keys,
    ``.FLANK`` of the four flanks; show: what is shown of the field's value, in SI units.
    """

    key: str
    definition: str = ""
    error: str = ""
    heading: str = ""
    form: str = "g5"
    parts: str = ""
    show: Callable[[Any], object] | None = field(default=None, compare=False)

    def shown(self, value: object) -> object:
        """What is shown of the field's value."""
        return value if self.show is None else self.show(value)

    def __call__(self, getter: Getter) -> Getter:
        """The function of a property of which this is stated."""
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
    default: Any = MISSING,
    default_factory: Any = MISSING,
) -> Any:
    """A field of a `record`, with what is stated of it: arguments as of `Stated`; also: further keys with what they show.

    >>> @record
    ... class Contact:
    ...     force: float = quantity("force_N", "its load F")
    >>> Contact(2.0).force, stated_in(Contact)[0][1].definition
    (2.0, 'its load F')
    """
    stated = Stated(key, definition, error, heading, form, parts, show), *also
    given: dict[str, Any] = {"default": default, "default_factory": default_factory}
    return field(**given, metadata={"stated": stated})


@overload
def record(cls: type[Class], /) -> type[Class]: ...
@overload
def record(*, eq: bool = True, repr: bool = True, kw_only: bool = False) -> Callable[[type[Class]], type[Class]]: ...
@dataclass_transform(frozen_default=True, field_specifiers=(field, quantity))
def record(cls: type[Class] | None = None, /, **options: bool) -> Any:
    """A frozen dataclass, some fields of which are a `quantity`; options: as of `dataclasses.dataclass`."""
    made = dataclass(frozen=True, **options)
    return made if cls is None else made(cls)


def stated_in(kind: type) -> tuple[tuple[str, Stated], ...]:
    """Names of the fields, properties and methods of a record, in their order, with what is stated of each."""
    fields = [(name, x.metadata) for name, x in getattr(kind, "__dataclass_fields__", {}).items()]
    members = [(name, getattr(x, "fget", x)) for each in reversed(kind.__mro__) for name, x in vars(each).items()]
    of_members = [(name, getattr(x, "__dict__", {})) for name, x in members]
    return tuple((name, x) for name, of in (*fields, *of_members) for x in of.get("stated", ()))
