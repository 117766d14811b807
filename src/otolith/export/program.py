"""A program: a closed algorithm as C99 in one header, with names and units for all that goes in and out.

The header declares, for a program called NAME,

    typedef struct NAME NAME;                                          everything that it remembers
    void NAME_init(NAME *me);                                          start at rest, in the neutral pose
    int NAME_step(NAME *me, const double in[], double out[]);          one period; returns the status

and the macros NAME_PERIOD [s], NAME_INPUTS and NAME_OUTPUTS. One source file defines NAME_IMPLEMENTATION
before it includes the header, and so receives the functions; all others include it as it is. The struct holds
no pointers, so a copy of it is a snapshot, and each instance has one of its own. The status is a place in
`otolith.compiled.STATUSES`: 0 for a decision of the algorithm, others for the fallback that brakes.
"""

import re
from dataclasses import dataclass
from typing import Final

from otolith.core.errors import InputError

# Words that no C99 or C++ compiler accepts as a name, as far as a program may be called so.
_RESERVED: Final = frozenset(
    """auto break case char class const continue default delete do double else enum extern float for goto if
    inline int long namespace new operator private public register restrict return short signed sizeof static
    struct switch template this throw try typedef union unsigned using virtual void volatile while""".split()  # noqa: SIM905
)


@dataclass(frozen=True)
class Port:
    """One number that a program receives, or gives, in every period."""

    name: str  # a C identifier, unique among the inputs or the outputs of a program
    unit: str  # as in "m/s2"; empty for a pure number
    meaning: str  # one line for a reader
    start: float = 0.0  # its value at rest, before the first step


@dataclass(frozen=True, kw_only=True)
class Program:
    """An algorithm, with or without its platform, as one C header.

    Raises
    ------
    InputError : the name is not a C identifier.
    """

    name: str
    period: float  # [s] between two steps
    inputs: tuple[Port, ...]  # in the order of `in`
    outputs: tuple[Port, ...]  # in the order of `out`
    header: str  # the whole text of NAME.h

    def __post_init__(self) -> None:
        check_name(self.name)


def check_name(name: str) -> None:
    """Refuse a name that C does not take; raises `InputError`."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in _RESERVED or len(name) > 40:
        bound = "letters, digits and _ after a letter, at most 40, and no word of C"
        raise InputError("name of the program", repr(name), bound)
