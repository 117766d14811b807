"""Finds events in a recorded drive that are not driving, such as gaps, pauses, jumps and replays.

Telemetry of games, and of loggers that were interrupted, holds stretches that no vehicle drove: the world
stands still while time runs, packets of zeros arrive in between, the car is put back on the road. They are
found by the rules that they break: speed changes as a_x states, positions change as the speed states, and
sensors never stand still to the last digit.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError, one_of
from otolith.recordings.channels import FELT, FORCE, Channel, Recording
from otolith.recordings.events.chatter import find_chatter, without_chatter
from otolith.recordings.events.event import Event, apart, without
from otolith.recordings.events.gaps import find_gaps
from otolith.recordings.events.halts import find_halts, find_replays
from otolith.recordings.events.jumps import find_jumps
from otolith.recordings.events.strays import find_strays

TREATMENTS: Final = {
    "refuse": "stop, and name them",
    "mark": "play them as they are, and name them",
    "cut": "cut them out or bridge them, and name them",
}
HOLE: Final = 1.5  # [s] longer than `channels.MAX_GAP`, so that no check compares across it
_WEIGHTS: Final = {"gap": 2, "jump": 1}  # where events overlap, the larger weight determines name and bridge
NAMED: Final = 3  # number of events of one kind that are reported individually


def parse_events(text: str) -> str:
    """Return the word of `--events`, or refuse an unknown one."""
    if text not in TREATMENTS:
        raise InputError("--events", repr(text), one_of(TREATMENTS, text))
    return text


def find_events(recording: Recording) -> tuple[Event, ...]:
    """Return all events of a drive in order of time; overlapping events are merged."""
    channels = recording.channels
    felt = [channels[key] for key in FELT if key in channels]
    if not felt:
        return ()
    strays = find_strays(felt)
    halts = find_halts(channels, strays)
    found = _merged([*find_gaps(recording), *find_jumps(channels, strays), *halts], strays)
    found += apart(find_replays(felt), halts)
    found += apart(find_chatter(felt), found)
    return tuple(sorted(found, key=lambda event: event.start))


def cut(recording: Recording, events: Sequence[Event]) -> Recording:
    """Return the drive without its sure events: samples inside are replaced by a short bridge.

    Chatter is not cut: there the part above 10 Hz is removed.
    """
    shaken = [event for event in events if event.kind == "chatter"]
    gone = [event for event in events if event.sure]
    channels = {
        key: _cut_channel(without_chatter(one, shaken) if key in FORCE else one, gone)
        for key, one in recording.channels.items()
    }
    return replace(recording, channels=channels)


def with_holes(events: Sequence[Event]) -> list[Event]:
    """Return the events with longer bridges where a cut leaves a jump; no check compares across them."""
    return [replace(event, bridge=HOLE) if event.kind in ("gap", "jump") else event for event in events]


def before_cut(t: Vec, events: Sequence[Event]) -> Vec:
    """Convert times (n,) [s] of the cut drive to times of the whole drive."""
    sure = sorted((event for event in events if event.sure), key=lambda event: event.start)
    gone = _removed(sure)
    starts = np.array([event.start for event in sure]) - gone[:-1]
    return np.asarray(t + gone[np.searchsorted(starts, t)], dtype=np.float64)


def after_cut(t: Vec, events: Sequence[Event]) -> Vec:
    """Convert times (n,) [s] of the whole drive to times of the cut drive."""
    sure = sorted((event for event in events if event.sure), key=lambda event: event.end)
    over = np.searchsorted([event.end for event in sure], t, side="right")
    return np.asarray(t - _removed(sure)[over], dtype=np.float64)


def _removed(events: Sequence[Event]) -> Vec:
    """Return the time [s] that the first k of n events remove (n + 1,), for k = 0 to n."""
    lengths = [event.end - event.start - event.bridge for event in events]
    return np.asarray(np.r_[0.0, np.cumsum(lengths)], dtype=np.float64)


def shortened(duration: float, events: Sequence[Event]) -> float:
    """Return the duration [s] of a drive after `cut`."""
    gone = [event for event in events if event.sure]
    return duration - sum(event.end - event.start - event.bridge for event in gone)


def event_notes(events: Sequence[Event], treatment: str) -> list[str]:
    """Report what happened to each event that is not refused; many events of one kind are summarised."""
    notes = []
    for kind in dict.fromkeys(event.kind for event in events):
        alike = [event for event in events if event.kind == kind]
        named = sorted(sorted(alike, key=lambda e: e.start - e.end)[:NAMED], key=lambda e: e.start)
        notes += [f"{event}: {_fate(event, treatment)}" for event in named]
        if len(alike) > NAMED:
            whole = sum(event.end - event.start for event in alike)
            notes.append(f"{kind}: {len(alike)} in all, {whole:.4g} s together; the longest are named")
    return notes


def refuse(events: Sequence[Event], source: str) -> None:
    """Refuse a drive that holds events which are certainly not driving."""
    sure = [event for event in events if event.sure]
    if not sure:
        return
    named = "; ".join(map(str, sure[:NAMED]))
    named += f"; and {len(sure) - NAMED} more" if len(sure) > NAMED else ""
    places = "1 place" if len(sure) == 1 else f"{len(sure)} places"
    bound = "driving throughout (--events cut takes them out, --events mark plays them as they are)"
    raise InputError(f"drive in {source}", f"not driving in {places}: {named}", bound)


def _fate(event: Event, treatment: str) -> str:
    if event.kind == "chatter" and treatment == "cut":
        return "low-passed at 10 Hz there"
    if event.kind == "chatter":
        return "played as it is; --lowpass 5 smooths the whole drive, --events cut this stretch"
    if not event.sure:
        return "it may be driving and is played as it is"
    if treatment == "cut":
        return "cut out"
    return "played as a straight line" if event.kind == "gap" else "played as it is"


def _cut_channel(channel: Channel, events: Sequence[Event]) -> Channel:
    left = without(channel, events)
    return replace(left, t=after_cut(left.t, events))


def _merged(events: Sequence[Event], strays: Sequence[Event]) -> list[Event]:
    """Merge overlapping events in order of time; the surer, then the longer one gives kind and bridge."""
    merged: list[Event] = []
    for event in sorted(events, key=lambda e: (e.start, -e.end)):
        if not merged or event.start >= merged[-1].end:
            merged.append(event)
            continue
        last = merged[-1]
        main = max(last, event, key=lambda e: (e.sure, _WEIGHTS.get(e.kind, 0), e.end - e.start))
        size = last.size if event.size == last.size else f"{last.size}; {event.size}"
        merged[-1] = replace(main, start=last.start, end=max(last.end, event.end), size=size)
    return [*merged, *apart(strays, merged)]
