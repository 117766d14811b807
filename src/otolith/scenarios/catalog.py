"""Scenarios by name, and from a line of text such as ``sine:amplitude=0.7,frequency=0.2``."""

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, Final

from otolith.core.errors import InputError, one_of
from otolith.core.formula import Builder, arguments, defaults
from otolith.scenarios import signals
from otolith.scenarios.scenario import Scenario
from otolith.scenarios.signals import SECTION_6_1_WAVES, STEP_END_LITERAL

# [s] the thesis states "a larger rest period" than one second (section 6.2), without a length
EMULATOR_REST: Final = 5.0


@dataclass(frozen=True, slots=True)
class Entry:
    """A named scenario: `build(axis=…)` and, if a step has an end, `build(end=…)`."""

    build: Builder
    description: str  # one line
    source: str  # where its numbers come from


SCENARIOS: Final[Mapping[str, Entry]] = MappingProxyType(
    {
        "sine-0.5": Entry(
            partial(signals.sine, 0.5, 0.1), "sine 0.5 m/s², 0.1 Hz, 10 s", "thesis Table 5.1, section 6.1"
        ),
        "sine-1": Entry(partial(signals.sine, 1.0, 0.1), "sine 1 m/s², 0.1 Hz, 10 s", "thesis Table 5.1"),
        "sine-2": Entry(partial(signals.sine, 2.0, 0.1), "sine 2 m/s², 0.1 Hz, 10 s", "thesis Table 5.1"),
        "combined": Entry(
            signals.combined, "four sines, 0.1 to 0.5 Hz, scaled by 0.3, 10 s", "thesis Table 5.1, eq. 5.1"
        ),
        "step-0.5": Entry(
            partial(signals.step, 0.5), "step 0.5 m/s² from 1 s to 5 s, 10 s", "thesis Table C.2"
        ),
        "step-1": Entry(partial(signals.step, 1.0), "step 1 m/s² from 1 s to 5 s, 10 s", "thesis Table 5.1"),
        "step-2": Entry(partial(signals.step, 2.0), "step 2 m/s² from 1 s to 5 s, 10 s", "thesis Table 5.1"),
        "step-sine-0.5": Entry(
            partial(signals.step_sine, 0.5, 0.1),
            "step 0.5 m/s², then sine from 10 s on, 20 s",
            "thesis Table 5.1",
        ),
        "step-sine-1": Entry(
            partial(signals.step_sine, 1.0, 0.1),
            "step 1 m/s², then sine from 10 s on, 20 s",
            "thesis Table 5.1",
        ),
        "step-0.1": Entry(
            partial(signals.step, 0.1), "step 0.1 m/s² from 1 s to 5 s, 10 s", "thesis section 6.1"
        ),
        "sine-1-0.01hz": Entry(
            partial(signals.sine, 1.0, 0.01, duration=60.0),
            "sine 1 m/s², 0.01 Hz, 60 s",
            "thesis section 6.1",
        ),
        "combined-emulator": Entry(
            partial(signals.combined, SECTION_6_1_WAVES, duration=20.0, start=EMULATOR_REST),
            "as combined-fast, after a rest of 5 s, 20 s",
            "thesis section 6.2, figure 6.2",
        ),
        "combined-fast": Entry(
            partial(signals.combined, SECTION_6_1_WAVES, duration=20.0),
            "four sines, 0.1 to 1 Hz, scaled by 0.3, 20 s",
            "thesis section 6.1, eq. 6.1",
        ),
        "bend": Entry(
            partial(signals.step, 2.5, start=2.0, end=13.0, rise=1.0, fall=1.0, duration=26.0),
            "long bend, 2.5 m/s² for 10 s, 26 s",
            "the oval of SimHub issue 1883: washout through the centre",
        ),
        "stop": Entry(
            partial(signals.step, -8.5, start=2.0, end=5.0, rise=0.5, fall=0.1, duration=15.0),
            "braking from 86 km/h, -8.5 m/s² that end within 0.1 s at standstill, 15 s",
            "our choice",
        ),
    }
)

# The signals of chapter 5, in the order of its tables.
TABLE_5_1: Final = tuple(name for name, entry in SCENARIOS.items() if "Table 5.1" in entry.source)

FAMILIES: Final[Mapping[str, Entry]] = MappingProxyType(
    {
        "sine": Entry(signals.sine, "a sine", "parameters"),
        "step": Entry(signals.step, "a pulse", "parameters"),
        "step-sine": Entry(signals.step_sine, "a pulse, then a sine", "parameters"),
        "combined": Entry(signals.combined, "the four sines of Table 5.1", "parameters"),
        "multisine": Entry(signals.multisine, "a random sum of sines with a seed", "parameters"),
        "chirp": Entry(signals.chirp, "a sine of growing frequency", "parameters"),
    }
)


def scenario(name: str, *, literal: bool = False, axis: str = "longitudinal") -> Scenario:
    """Return a scenario by name, or from a text ``family:parameter=value,…``.

    Names are those of `SCENARIOS`, families those of `FAMILIES`. Parameters that the text leaves out keep
    their defaults, see `family_parameters`.

    Parameters
    ----------
    literal : whether steps end at 4 s, as the thesis prints, instead of at 5 s, which reproduces its results.
    axis : "longitudinal", "lateral", "vertical" or "yaw" (as a rate); ``axis=…`` in the text takes
        precedence.

    Raises
    ------
    InputError : unknown name, family or parameter, or a value that is not a number or out of bounds.
    """
    entry, given = _found(name)
    options: dict[str, Any] = {"axis": axis}
    printed = literal and has_literal(name)
    if printed:
        options["end"] = STEP_END_LITERAL
    origin = entry.source + (", step until 4 s as printed" if printed else "")
    built: Scenario = entry.build(**options | given)
    return replace(built, name=name.strip(), origin=origin)


def has_literal(name: str) -> bool:
    """Return whether `literal` changes this scenario: it has a step whose end is not given."""
    entry, given = _found(name)
    chosen = {*given, *getattr(entry.build, "keywords", {})}
    return "end" in inspect.signature(entry.build).parameters and "end" not in chosen


def _found(name: str) -> tuple[Entry, dict[str, Any]]:
    """Return the entry of a scenario's name or text, and the parameters in the text."""
    family, colon, text = name.strip().partition(":")
    parametric = colon or (family in FAMILIES and family not in SCENARIOS)
    entry = _entry(family, FAMILIES if parametric else SCENARIOS)
    return entry, arguments(text, family, entry.build)


def family_parameters(family: str) -> dict[str, Any]:
    """Return the parameters of a family with their defaults, for help texts.

    Raises
    ------
    InputError : unknown family.
    """
    return defaults(_entry(family, FAMILIES).build)


def _entry(name: str, table: Mapping[str, Entry]) -> Entry:
    if name in table:
        return table[name]
    if table is FAMILIES:
        raise InputError("scenario family", repr(name), one_of(table, name))
    otherwise = ", or as sine:amplitude=0.7,frequency=0.2"
    raise InputError("scenario", repr(name), one_of(table, name, otherwise=otherwise))
