"""What is said about bad input: one line with file, key, value found, range allowed and advice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

_LONGEST = 120
#: The same for what this program says itself.
_WHOLE = 2000


def escaped(text: str) -> str:
    """``text`` with all that is not printable (controls, line ends, marks of direction) as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def one_line(text: str, longest: int = _LONGEST) -> str:
    """``text`` as one printable line of at most ``longest`` characters (controls escaped, the rest cut)."""
    plain = escaped(text)
    return plain if len(plain) <= longest else plain[: longest - 3] + "..."


class InputError(Exception):
    """Something that the user gave cannot be used.

    ``file``: where it was found; ``key``: dotted path of the key (``balls.radius``, ``supports[0].fix``), or
    what stands for it; ``value``: what was found, as written; ``allowed``: the range or the choices;
    ``advice``: what to do next; ``more``: how many further faults were found. ``str()`` gives one line.

    Arguments of functions stand between single backticks in ``allowed`` and ``advice``, as compute=False may: the command
    line writes them as options.
    """

    #: Exit code of a command that it ends.
    code = 2

    def __init__(self, file: str, key: str, value: str, allowed: str, advice: str, more: int = 0) -> None:
        """Keep the parts; the text is put together by ``str()``."""
        super().__init__(file, key, value, allowed, advice, more)
        self.file = file
        self.key = key
        self.value = value
        self.allowed = allowed
        self.advice = advice
        self.more = more

    def lines(self) -> list[str]:
        """What is printed: one line for every fault."""
        return [str(self)]

    def __str__(self) -> str:
        """One line: ``file: key: got value; allowed: ...; advice: ...``, and the number of further faults."""
        rest = "" if self.more == 0 else f" (and {self.more} more fault{'s' if self.more > 1 else ''})"
        place = f"{one_line(self.file)}: " if self.file else ""
        return (
            f"{place}{one_line(self.key)}: got {one_line(self.value)}; "
            f"allowed: {one_line(self.allowed, 300)}; advice: {one_line(self.advice, 300)}{rest}"
        )


class ArgumentError(InputError):
    """An argument of a function cannot be used; several have commas between their names. file: where it leads, if any."""

    def __init__(self, argument: str, value: str, allowed: str, advice: str, file: str = "") -> None:
        """Keep the parts; the text is put together by ``str()``: ``max_error: got 700; allowed: ...; advice: ...``."""
        super().__init__(file, argument, value, allowed, advice)
        self.args = (argument, value, allowed, advice, file)


class Refusal(InputError):
    """A scene that a model cannot take: where, and the model's own words, in full, because they hold cause and remedy."""

    def __init__(self, file: str, key: str, reason: str, advice: str) -> None:
        """Keep the parts; the text is put together by ``str()``."""
        super().__init__(file, key, reason, "", advice)
        self.args = (file, key, reason, advice)

    def __str__(self) -> str:
        """One line: ``file: key: reason; advice: ...``."""
        reason = one_line(" ".join(self.value.split()), _WHOLE).rstrip(".; ")
        return f"{one_line(self.file)}: {one_line(self.key)}: {reason}; advice: {one_line(self.advice, 300)}"


class ProgramError(Refusal):
    """A user's program, as a model, that did not answer a scene: it, the scene, what went wrong and its last line."""

    code = 1


@contextmanager
def named(name: str, origin: str) -> Iterator[None]:
    """Refusals of the scene ``name`` inside name its file ``origin`` instead."""
    try:
        yield
    except Refusal as error:
        if error.file != name or origin == name:
            raise
        raise Refusal(origin, error.key, error.value, error.advice) from error


#: How many faults of a file are listed.
_MANY = 30


class SceneError(InputError):
    """A scene file cannot be read, or describes something that cannot be built; ``others``: its further faults."""

    def __init__(
        self, file: str, key: str, value: str, allowed: str, advice: str, more: int = 0, others: tuple[SceneError, ...] = ()
    ) -> None:
        """Keep the parts; the text is put together by ``str()`` and ``lines()``."""
        super().__init__(file, key, value, allowed, advice, more)
        self.args = (file, key, value, allowed, advice, more, others)
        self.others = others

    def lines(self) -> list[str]:
        """Every fault as a line of its own; how many more there are beyond the first 30."""
        each = [self, *self.others][:_MANY]
        lines = [InputError.__str__(InputError(e.file, e.key, e.value, e.allowed, e.advice)) for e in each]
        left = len(self.others) + 1 - len(lines)
        return [*lines, f"{one_line(self.file)}: and {left} more faults"] if left else lines
