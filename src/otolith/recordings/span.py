"""The time span of a drive, and the channels that do not cover it, which are refused or left out."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.recordings.channels import FELT, MAX_GAP, Channel, Recording
from otolith.recordings.events.event import Event
from otolith.recordings.events.gaps import find_gaps
from otolith.recordings.units import UNITS

WIDE_GAP: Final = 5.0  # in median steps: longer gaps are reported


def settled(recording: Recording, *, events: str = "refuse") -> tuple[Recording, float]:
    """Return the recording without channels that do not cover the drive, and the drive's duration [s].

    The drive lasts as long as all needed channels run. A needed channel with a hole of more than 1 s is
    refused, unless `events` says that holes are marked or cut out. Another felt channel is left out, with a
    note, if it has a hole elsewhere in the drive, begins more than 1 s after its start or ends more than 1 s
    before its end. Channels that only serve checks never shorten the drive.

    Raises
    ------
    InputError : a needed channel has a hole, a clock restarts, or needed channels have no common time.
    """
    needed, end = recording.cued, recording.end
    if end <= 0.0:
        where = f"time that {' and '.join(needed)} of {recording.source} have in common"
        raise InputError(where, "none", "some, or leave one of them out with NAME=none")
    if events == "refuse":
        _refuse_anew(recording)
    for one in needed.values():
        _refuse_hole(one, end, recording.layout.clock_name, events)
    notes = [*_cut(needed, end)]
    gaps = find_gaps(recording)
    kept = {}
    for key, one in recording.channels.items():
        reason = "" if key in needed or key not in FELT else _short(one, end, gaps)
        if reason:
            notes.append(f"{key}: left out, taken as zero: {reason}")
        else:
            kept[key] = one
    kept = {key: replace(one, notes=(*one.notes, *_gaps(one))) for key, one in kept.items()}
    return replace(recording, channels=kept, notes=(*recording.notes, *notes)), end


def rate(channel: Channel) -> float:
    """Return the mean sampling rate, (n - 1) / duration [Hz]."""
    return float((len(channel.t) - 1) / (channel.t[-1] - channel.t[0]))


def _refuse_anew(recording: Recording) -> None:
    layout = recording.layout
    if layout.anew:
        where = f"time in {next(iter(recording.cued.values())).place} {layout.anew[0]} of {recording.source}"
        times = f", {len(layout.anew)} times in all" if len(layout.anew) > 1 else ""
        bound = (
            "on one clock (after a pause of the recorder --events cut joins what lies before and after it; "
            f"if {layout.clock_name} counts laps, map another column of time, or t=every:0.05s)"
        )
        raise InputError(where, f"as at the beginning again{times}", bound)


def _refuse_hole(one: Channel, end: float, clock: str, events: str) -> None:
    holes = [(a, b) for a, b in one.holes if b > 0.0 and a < end]
    if not holes or (events != "refuse" and one.step <= MAX_GAP):
        return
    first, last = max(holes, key=lambda hole: hole[1] - hole[0])
    after = int(np.searchsorted(one.t, last))
    where = f"gap in {one.key} before {one.where(after)}, {first:.6g} s after the first row,"
    unit = next((u for u in ("ms", "us", "ns") if 1e-4 < one.step * UNITS["time"][u] < MAX_GAP), "")
    hint = ""
    if one.step <= MAX_GAP:
        hint = " (--events cut joins what lies before and after it, --events mark bridges it)"
    elif clock and unit:
        hint = f" (is time in {unit}? then map t={clock}:{unit})"
    raise InputError(where, f"{last - first:.6g} s", f"at most {MAX_GAP:g} s{hint}")


def _short(one: Channel, end: float, gaps: Sequence[Event]) -> str:
    """Return why a channel that is not needed does not cover the drive; empty if it does."""
    if one.t[0] > MAX_GAP or one.t[-1] < end - MAX_GAP:
        return f"it runs from {one.t[0]:.4g} s to {one.t[-1]:.4g} s of {end:.4g} s"
    holes = [(a, b) for a, b in one.holes if b > 0.0 and a < end]
    own = [f"{a:.4g} s to {b:.4g} s" for a, b in holes if not any(_fills(gap, a, b) for gap in gaps)]
    return f"it has no values from {' and '.join(own[:3])}" if own else ""


def _fills(gap: Event, first: float, last: float) -> bool:
    """Return whether a gap of the whole drive leaves less than 1 s of a channel's hole."""
    return max(gap.start - first, 0.0) + max(last - gap.end, 0.0) <= MAX_GAP


def _cut(needed: Mapping[str, Channel], end: float) -> list[str]:
    """Note what is lost at both ends because not all needed channels run there."""
    first, last = min(one.t[0] for one in needed.values()), max(one.t[-1] for one in needed.values())
    if first > -MAX_GAP and last < end + MAX_GAP:
        return []
    runs = ", ".join(
        f"{key} from {one.t[0] - first:.4g} s to {one.t[-1] - first:.4g} s" for key, one in needed.items()
    )
    return [f"the drive lasts where all that is cued runs, {-first:.4g} s to {end - first:.4g} s: {runs}"]


def _gaps(one: Channel) -> list[str]:
    """Note steps that are unusually long and are still bridged by straight lines."""
    steps = np.diff(one.t)
    wide = np.flatnonzero((steps > WIDE_GAP * one.step) & (steps <= MAX_GAP))  # longer ones are events
    if not len(wide):
        return []
    longest = wide[np.argmax(steps[wide])]
    return [
        f"{len(wide)} gaps bridged by straight lines, the longest of {steps[longest]:.3g} s at "
        f"{one.t[longest]:.5g} s"
    ]
