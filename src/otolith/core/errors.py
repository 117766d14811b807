"""Every error that Otolith raises on purpose derives from one base and reads as one sentence."""

import difflib
from collections.abc import Iterable


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
        super().__init__(f"{field} is {value}, must be {bound}")
        self.field, self.value, self.bound = field, value, bound


class CorruptFile(OtolithError):
    """A stored file is truncated, altered, foreign or of another version."""


class MissingExtra(OtolithError):
    """An optional dependency is absent; the sentence carries the pip command."""


def one_of(known: Iterable[str], name: str, *, otherwise: str = "") -> str:
    """The end of a refusal: "one of …", then `otherwise`, then the known name that `name` resembles."""
    known = list(known)
    close = difflib.get_close_matches(name, known, n=1)
    return f"one of {', '.join(known)}{otherwise}" + (f" (did you mean {close[0]}?)" if close else "")
