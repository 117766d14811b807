"""Every error that Otolith raises on purpose derives from one base and reads as one sentence."""

import contextlib
import difflib
import struct
import zlib
from collections.abc import Iterable, Iterator
from typing import Final

# What parsers raise on bytes that they were not written for.
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

_LONGEST: Final = 300  # characters of a value that a sentence quotes


class OtolithError(Exception):
    """Base of all errors of this package; its text is one sentence for the user."""


class InputError(OtolithError):
    """A user's value (file, option, log, packet) is refused.

    Parameters
    ----------
    field : where the value stands, in the user's words, e.g. ``surge.position_m in rig.toml``.
    value : what was found there.
    bound : what is allowed, as the end of the sentence "…, must be <bound>", with its unit.
    """

    def __init__(self, field: str, value: object, bound: str) -> None:
        super().__init__(f"{field} is {_clipped(value)}, must be {bound}")
        self.field, self.value, self.bound = field, value, bound


def _clipped(value: object) -> str:
    """The value's text; the middle of a long one is left out, since an error is one sentence."""
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} … {text[-_LONGEST // 2 :]}"


class CorruptFile(OtolithError):
    """A stored file is truncated, altered, foreign or of another version."""


@contextlib.contextmanager
def damage_told(verdict: str) -> Iterator[None]:
    """Turn whatever a parser raises on a damaged file into a `CorruptFile` that begins with `verdict`.

    Only the parsing of one file belongs inside: a mistake of ours there would be told as damage, too.
    """
    try:
        yield
    except _UNREADABLE as error:
        reason = f"it lacks {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
        raise CorruptFile(f"{verdict}: {reason}") from error


class MissingExtra(OtolithError):
    """An optional dependency is absent; the sentence carries the pip command."""


def one_of(known: Iterable[str], name: str, *, otherwise: str = "") -> str:
    """The end of a refusal: "one of …", then `otherwise`, then the known name that `name` resembles."""
    known = list(known)
    close = difflib.get_close_matches(name, known, n=1)
    return f"one of {', '.join(known)}{otherwise}" + (f" (did you mean {close[0]}?)" if close else "")
