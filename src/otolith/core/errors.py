"""Every error that Otolith raises on purpose derives from one base and reads as one sentence."""

import contextlib
import difflib
import struct
import zlib
from collections.abc import Iterable, Iterator
from typing import Any, Final

# The exceptions that parsers raise on bytes that they were not written for.
_UNREADABLE: Final = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)

_LONGEST: Final = 300  # longest value, in characters, that an error message quotes in full


class OtolithError(Exception):
    """Base class of all errors that Otolith raises on purpose; the text is one sentence for the user."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Let an error travel between processes as it is, whatever its constructor takes."""
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[OtolithError], args: tuple[Any, ...], state: dict[str, Any]) -> OtolithError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(state)
    return error


class InputError(OtolithError):
    """A user's value (in a file, an option, a log or a packet) is refused.

    Parameters
    ----------
    field : where the value stands, in the user's words, e.g. ``surge.position_m in rig.toml``.
    value : what was found there.
    bound : what is allowed, with its unit; it ends the sentence "…, must be <bound>".
    """

    def __init__(self, field: str, value: object, bound: str) -> None:
        super().__init__(f"{field} is {_clipped(value)}, must be {bound}")
        self.field, self.value, self.bound = field, value, bound


def _clipped(value: object) -> str:
    """Return the value's text, with the middle of a long one left out so that the error stays one
    sentence.
    """
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} … {text[-_LONGEST // 2 :]}"


class CorruptFile(OtolithError):
    """A stored file is truncated, was altered, has another format, or was written by another version."""


@contextlib.contextmanager
def damage_reported(verdict: str) -> Iterator[None]:
    """Turn any exception that a parser raises on a damaged file into a `CorruptFile` beginning with
    `verdict`.

    Put only the parsing of one file inside this context: a programming error there would also be reported as
    damage.
    """
    try:
        yield
    except _UNREADABLE as error:
        reason = f"it lacks {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
        raise CorruptFile(f"{verdict}: {reason}") from error


class MissingExtra(OtolithError):
    """An optional dependency is not installed; the message contains the pip command that installs it."""


def one_of(known: Iterable[str], name: str, *, otherwise: str = "") -> str:
    """Word the bound of an `InputError`: "one of …", then `otherwise`, then the closest known name to
    `name`.
    """
    known = list(known)
    close = difflib.get_close_matches(name, known, n=1)
    return f"one of {', '.join(known)}{otherwise}" + (f" (did you mean {close[0]}?)" if close else "")
