"""Errors for bad input, whose message is one line with file, key, value, allowed range and advice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

#: Largest number of characters of a user's text that a message shows.
_LONGEST = 120
#: Largest number of characters of a text of this program that a message shows.
_WHOLE = 2000


def escape_unprintable(text: str) -> str:
    """Return a text with unprintable characters (controls, line ends, direction marks) replaced by escape sequences.

    Parameters
    ----------
    text
        Any text, such as the name of a file.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def one_line(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one printable line, in which unprintable characters are escaped, of limited length.

    Parameters
    ----------
    text
        Any text.
    longest
        Largest number of characters; the rest is replaced by ``...``.
    """
    plain = escape_unprintable(text)
    return plain if len(plain) <= longest else plain[: longest - 3] + "..."


class InputError(Exception):
    """Error for input that cannot be used; ``str()`` returns its message as one line.

    In ``allowed`` and ``advice``, names of function arguments stand in single backticks, such as `compute=False`. The
    command line shows them as options instead.

    Parameters
    ----------
    file
        File or scene with the fault; may be empty.
    key
        Keys of the faulty value joined by dots (``balls.radius``, ``supports[0].fix``), or name of the argument.
    value
        Value as the user wrote it.
    allowed
        Allowed range or choices.
    advice
        Advice on how to correct the input.
    more
        Number of further faults in the same file.

    Examples
    --------
    >>> import rollbench
    >>> try:
    ...     rollbench.check("lin-case1", max_error=700)
    ... except rollbench.InputError as error:
    ...     print(error)
    max_error: got 700; allowed: above 0 to 100 per cent of a contact load; advice: leave `max_error` out for 7 per cent
    """

    #: Exit code of a command that ends with this error.
    code = 2

    def __init__(self, file: str, key: str, value: str, allowed: str, advice: str, more: int = 0) -> None:
        """Store the parts of the message as attributes."""
        super().__init__(file, key, value, allowed, advice, more)
        self.file = file
        self.key = key
        self.value = value
        self.allowed = allowed
        self.advice = advice
        self.more = more

    def lines(self) -> list[str]:
        """Return the message of every fault as one line.

        Returns
        -------
        list of str
            The messages.
        """
        return [str(self)]

    def __str__(self) -> str:
        """Return one line: ``file: key: got value; allowed: ...; advice: ...``, and the number of further faults."""
        rest = "" if self.more == 0 else f" (and {self.more} more fault{'s' if self.more > 1 else ''})"
        place = f"{one_line(self.file)}: " if self.file else ""
        return (
            f"{place}{one_line(self.key)}: got {one_line(self.value)}; "
            f"allowed: {one_line(self.allowed, 300)}; advice: {one_line(self.advice, 300)}{rest}"
        )


class ArgumentError(InputError):
    """Error for an argument of a function that cannot be used.

    Parameters
    ----------
    argument
        Name of the argument, or names of several arguments joined by commas.
    value
        Value as the user wrote it.
    allowed
        Allowed range or choices.
    advice
        Advice on how to correct the input.
    file
        File that the argument names, if any.
    """

    def __init__(self, argument: str, value: str, allowed: str, advice: str, file: str = "") -> None:
        """Store the parts of the message; ``str()`` gives ``max_error: got 700; allowed: ...; advice: ...``."""
        super().__init__(file, argument, value, allowed, advice)
        self.args = (argument, value, allowed, advice, file)


class SceneNotCoveredError(InputError):
    """Error for a scene that a model does not cover.

    Parameters
    ----------
    file
        File or name of the scene.
    key
        Key of the scene, or the model.
    reason
        Reason why the model does not cover the scene; it is shown in full length.
    advice
        Advice on how to change the scene or the model.
    """

    def __init__(self, file: str, key: str, reason: str, advice: str) -> None:
        """Store the parts of the message."""
        super().__init__(file, key, reason, "", advice)
        self.args = (file, key, reason, advice)

    def __str__(self) -> str:
        """Return one line: ``file: key: reason; advice: ...``."""
        reason = one_line(" ".join(self.value.split()), _WHOLE).rstrip(".; ")
        return f"{one_line(self.file)}: {one_line(self.key)}: {reason}; advice: {one_line(self.advice, 300)}"


class ProgramError(SceneNotCoveredError):
    """Error for a failed external program used as the model; the message has the reason and the program's last output."""

    code = 1


@contextmanager
def show_file_in_scene_errors(name: str, origin: str) -> Iterator[None]:
    """Replace the scene's name by its file in the message of every `SceneNotCoveredError` raised in the ``with`` block.

    Parameters
    ----------
    name
        Name of the scene.
    origin
        File or other name that messages show instead of this name.
    """
    try:
        yield
    except SceneNotCoveredError as error:
        if error.file != name or origin == name:
            raise
        raise SceneNotCoveredError(origin, error.key, error.value, error.advice) from error


#: Largest number of faults that are listed for a file.
_MANY = 30


class SceneError(InputError):
    """Error for a scene file that cannot be read, or describes parts that cannot be built.

    Parameters
    ----------
    file, key, value, allowed, advice, more
        As for `InputError`.
    others
        Errors for the other faults of the file; empty if there is only one fault.
    """

    def __init__(
        self, file: str, key: str, value: str, allowed: str, advice: str, more: int = 0, others: tuple[SceneError, ...] = ()
    ) -> None:
        """Store the parts of the message; ``lines()`` gives a line for every fault."""
        super().__init__(file, key, value, allowed, advice, more)
        self.args = (file, key, value, allowed, advice, more, others)
        self.others = others

    def lines(self) -> list[str]:
        """Return the messages of the file's faults, one line each, at most 30.

        Returns
        -------
        list of str
            The messages of the first 30 faults, then a line with the number of further faults.
        """
        each = [self, *self.others][:_MANY]
        lines = [InputError.__str__(InputError(e.file, e.key, e.value, e.allowed, e.advice)) for e in each]
        left = len(self.others) + 1 - len(lines)
        return [*lines, f"{one_line(self.file)}: and {left} more faults"] if left else lines
