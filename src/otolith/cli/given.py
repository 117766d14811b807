"""Options that would be lost: these are refused in one place before a command begins.

An option may be given twice but used once, given without its value, have no effect without another option, or
be overruled by another.
Options that an algorithm does not read are declared in `otolith.registry`; options that a value makes
pointless are checked where the value is read.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from otolith.core.errors import InputError

_OF_LOGS: Final = ("lowpass", "causal", "column", "header", "units", "axes", "events", "offsets", "mapping")
_CUED: Final = dict.fromkeys(_OF_LOGS, "log")

# By command: an option, and another without which it has no effect.
NEEDS: Final[Mapping[str, Mapping[str, str]]] = {
    "run": _CUED,
    "compare": _CUED,
    "tune": _CUED,
    "drive": {"seed": "roughness"},
    "hint verify": {"lowpass": "log", "force": "out"},
    "platform new": {"force": "out"},
}
# By command: an option, and another that overrules it.
OVERRULED: Final[Mapping[str, Mapping[str, str]]] = {
    "run": {"literal": "log", "washout": "weight"},
    "compare": {"literal": "log", "washout": "weight"},
    "hint build": {"washout": "weight"},
    "hint verify": {"washout": "weight"},
}


class Called(NamedTuple):
    """The command that a line calls, and its options."""

    name: str  # "run", "hint verify"
    options: Mapping[str, Any]  # click's parameters of the command, by name
    counts: Mapping[str, int]  # how often each option was given, without those that were not
    empty: frozenset[str]  # names of the options whose value is an empty text

    def word(self, option: str) -> str:
        """Return the option as the user writes it."""
        return str(self.options[option].opts[0])


def called(command: Any, line: Sequence[str]) -> Called:
    """Find the command that a line calls in a group of commands."""
    words, names = list(line), []
    own: list[str] = []  # of a group itself, if no command of it is called
    while hasattr(command, "commands") and words:
        if (word := words.pop(0)) in command.commands:
            names.append(word)
            own = []
        else:
            own.append(word)
        command = command.commands.get(word, command)
    words = own + words
    given = [word.partition("=")[0] for word in words if word.startswith("--")]
    without = {word.removesuffix("=") for word in words if word.startswith("--") and word.endswith("=")}
    without |= {word for word, value in itertools.pairwise(words) if word.startswith("--") and not value}
    options = {one.name: one for one in command.params}
    counts = {name: sum(map(given.count, {*one.opts, *one.secondary_opts})) for name, one in options.items()}
    empty = frozenset(name for name, one in options.items() if without & {*one.opts} and not one.is_flag)
    return Called(" ".join(names), options, {name: count for name, count in counts.items() if count}, empty)


def refuse_lost(command: Any, line: Sequence[str]) -> None:
    """Refuse options that would have no effect.

    Raises
    ------
    InputError : an option is given twice but used once, is given an empty text, which would count as not
        given or as the folder one is in, is given without one that it needs, or is overruled by another.
    """
    found = called(command, line)
    for name, count in found.counts.items():
        option = found.options[name]
        if count > 1 and not getattr(option, "multiple", False) and not getattr(option, "is_flag", False):
            raise InputError(option.opts[0], "given twice", "given once")
    for name in sorted(found.empty):
        raise InputError(found.word(name), "empty", "given a value, or left out")
    alone: dict[str, list[str]] = {}
    for name, needed in NEEDS.get(found.name, {}).items():
        if name in found.counts and needed not in found.counts:
            alone.setdefault(needed, []).append(found.word(name))
    for needed, names in alone.items():
        raise InputError(" and ".join(names), "given", f"used together with {found.word(needed)}")
    for name, other in OVERRULED.get(found.name, {}).items():
        if name in found.counts and other in found.counts:
            raise InputError(found.word(name), "given", f"left out with {found.word(other)}")
