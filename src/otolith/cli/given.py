"""What was given on the command line and would be lost: refused in one place, before a command begins.

An option may be given twice and taken once, say nothing without another, or be overruled by another. That an
algorithm does not read an option stands in `otolith.registry`; that a value makes one pointless, where the
value is read.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from otolith.core.errors import InputError

_OF_LOGS: Final = ("lowpass", "causal", "column", "header", "units", "axes", "events", "offsets", "mapping")
_CUED: Final = dict.fromkeys(_OF_LOGS, "log")

# By command: an option, and the one without which it says nothing.
NEEDS: Final[Mapping[str, Mapping[str, str]]] = {
    "run": _CUED,
    "compare": _CUED,
    "drive": {"seed": "roughness"},
    "hint verify": {"lowpass": "log", "force": "out"},
    "platform new": {"force": "out"},
}
# By command: an option, and the one that overrules it.
OVERRULED: Final[Mapping[str, Mapping[str, str]]] = {
    "run": {"literal": "log", "washout": "weight"},
    "compare": {"literal": "log", "washout": "weight"},
    "hint build": {"washout": "weight"},
    "hint verify": {"washout": "weight"},
}


class Called(NamedTuple):
    """The command that a line calls, and the options that stand there."""

    name: str  # "run", "hint verify"
    options: Mapping[str, Any]  # parameters of the command, as click has them, by name
    counts: Mapping[str, int]  # how often each option was given, those that were

    def word(self, option: str) -> str:
        """As the user writes it."""
        return str(self.options[option].opts[0])


def called(command: Any, line: Sequence[str]) -> Called:
    """Find the command in a group of commands."""
    words, names = iter(line), []
    while hasattr(command, "commands") and (word := next(words, None)) is not None:
        if word in command.commands:
            names.append(word)
        command = command.commands.get(word, command)
    given = [word.partition("=")[0] for word in words if word.startswith("--")]
    options = {one.name: one for one in command.params}
    counts = {name: sum(map(given.count, {*one.opts, *one.secondary_opts})) for name, one in options.items()}
    return Called(" ".join(names), options, {name: count for name, count in counts.items() if count})


def refuse_lost(command: Any, line: Sequence[str]) -> None:
    """Refuse what is given and would have no effect.

    Raises
    ------
    InputError : an option is given twice and taken once, without one that it needs, or with one that
        overrules it.
    """
    found = called(command, line)
    for name, count in found.counts.items():
        option = found.options[name]
        if count > 1 and not getattr(option, "multiple", False) and not getattr(option, "is_flag", False):
            raise InputError(option.opts[0], "given twice", "given once")
    alone: dict[str, list[str]] = {}
    for name, needed in NEEDS.get(found.name, {}).items():
        if name in found.counts and needed not in found.counts:
            alone.setdefault(needed, []).append(found.word(name))
    for needed, names in alone.items():
        raise InputError(" and ".join(names), "given", f"used together with {found.word(needed)}")
    for name, other in OVERRULED.get(found.name, {}).items():
        if name in found.counts and other in found.counts:
            raise InputError(found.word(name), "given", f"left out with {found.word(other)}")
