"""All checks of a recorded drive, in their order: events, axes, contradictions, offsets, gravity."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.recordings.channels import FELT, RATE, Recording
from otolith.recordings.checks.courses import (
    lettered,
    refuse_contradicting,
    refuse_exchanged,
    refuse_sideways,
    refuse_turning_in_pitch,
)
from otolith.recordings.checks.kinematics import Kinematics
from otolith.recordings.checks.offsets import Offset, find_offsets, refuse_removal
from otolith.recordings.checks.orientation import negated, oriented
from otolith.recordings.checks.plausibility import Statements, check
from otolith.recordings.checks.relations import Relation
from otolith.recordings.columns import STANDARD_GRAVITY
from otolith.recordings.events import Event, cut, event_notes, find_events, refuse, shortened, with_holes
from otolith.recordings.events.chatter import energy_notes

MAX_ACCELERATION: Final = 50.0  # [m/s²]
MAX_RATE: Final = 20.0  # [rad/s]
HOLDS_GRAVITY: Final = 0.5 * STANDARD_GRAVITY  # [m/s²] a larger mean of a_z includes gravity


@dataclass(frozen=True, slots=True)
class Checked:
    """A drive in x forward, y left, z up without the standing 1 g, and what the checks found."""

    recording: Recording
    duration: float  # [s]
    notes: tuple[str, ...]
    events: tuple[Event, ...]
    offsets: tuple[Offset, ...]
    relations: tuple[Relation, ...]  # measured without the events
    turned: tuple[str, ...]  # quantities whose sign was turned in addition to the mapping
    proof: str  # what proves left and right; empty if nothing does


def checked(
    recording: Recording,
    duration: float,
    *,
    axes: str | None = None,
    events: str = "refuse",
    offsets: str = "keep",
    stated_units: Sequence[str] = (),
) -> Checked:
    """Check a drive, turn its axes where that is proven or stated, and remove gravity from a_z.

    Signs and units are judged without the events and then apply to the whole drive.

    Parameters
    ----------
    duration : [s] of the drive, from zero.
    axes, events, offsets : the user's statements, see `settings.LogSettings`.
    stated_units : quantities whose unit the user has given.

    Raises
    ------
    InputError : `courses`, `oriented`, `check`, `events.refuse` or `offsets.refuse_removal` refuses the
        drive.
    """
    source, found = recording.source, find_events(recording)
    gone = found if events == "cut" else tuple(event for event in found if event.sure)
    calm = cut(recording, with_holes(gone))
    if axes is None:
        refuse_exchanged(calm.channels, source)
        refuse_contradicting(calm.channels, source)
    driving = oriented(calm, axes)
    notes = [
        *driving.notes,
        *check(driving.drive, driving.recording, Statements(axes is not None, stated_units)),
    ]
    if axes is None:
        refuse_sideways(driving.drive, source)
        refuse_turning_in_pitch(driving.drive, source)
    _check_magnitudes(cut(recording, found))
    if events == "refuse":
        refuse(found, source)
    notes += event_notes(found, events)
    constants = find_offsets(driving.drive)
    if offsets == "remove":
        refuse_removal(constants, source)
    played = negated(cut(recording, found) if events == "cut" else recording, driving.turned)
    played, more = _without_offsets(played, constants, offsets)
    played, gravity = _without_gravity(played)
    felt = [one for key, one in played.channels.items() if key in FELT]
    return Checked(
        recording=played,
        duration=shortened(duration, found) if events == "cut" else duration,
        notes=(*notes, *lettered(driving.drive), *more, *gravity, *energy_notes(felt)),
        events=found,
        offsets=tuple(constants),
        relations=all_relations(driving.drive),
        turned=driving.turned,
        proof=driving.proof,
    )


def _check_magnitudes(recording: Recording) -> None:
    """Refuse forces and rates that no vehicle reaches; single outliers are events and already removed."""
    for key, one in recording.channels.items():
        if key not in FELT:
            continue
        turning = key in RATE
        bound, unit = (MAX_RATE, "rad/s") if turning else (MAX_ACCELERATION, "m/s²")
        at = int(np.argmax(np.abs(one.values)))
        if abs(one.values[at]) <= bound:
            continue
        question = f"is it really in {one.column.unit}?"
        if one.column.assumed:
            other = "deg/s" if turning else "mm/s² or counts of the sensor"
            question = f"no unit is stated: is it in {other}?"
        where = f"{key} in {one.where(at)}"
        raise InputError(where, f"{one.values[at]:.6g} {unit}", f"within ±{bound:g} {unit} ({question})")


def all_relations(drive: Kinematics) -> tuple[Relation, ...]:
    """Return all relations of a drive, including gravity's share of the forces."""
    shares = (drive.rolling, drive.pitching)
    return (*drive.relations, *(share for share in shares if share is not None))


def _without_offsets(
    recording: Recording, constants: Sequence[Offset], treatment: str
) -> tuple[Recording, list[str]]:
    if treatment == "keep":
        return recording, [str(offset) for offset in constants]
    channels, notes = dict(recording.channels), []
    for offset in constants:
        one = channels[offset.key]
        channels[offset.key] = replace(one, values=one.values - offset.value)
        notes.append(
            f"{offset.key}: a constant {offset.value:+.2f} m/s² was removed, as --offsets remove says"
        )
    return replace(recording, channels=channels), notes


def _without_gravity(recording: Recording) -> tuple[Recording, list[str]]:
    """Remove the standing 1 g from a_z if its mean shows that it is included."""
    az = recording.channels.get("az")
    if az is None:
        return recording, []
    mean = float(np.mean(az.values))
    if az.column.assumed and 0.9 < abs(mean) < 1.1:
        question = f"no unit is stated: is it in g? then map az={az.column.name}:g, and ax, ay alike"
        raise InputError(
            f"mean of az in {recording.source}", f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s² ({question})"
        )
    if mean <= HOLDS_GRAVITY:
        return recording, []
    channels = dict(recording.channels)
    channels["az"] = replace(az, values=az.values - STANDARD_GRAVITY)
    note = f"az averages {mean:.4g} m/s²: it holds gravity, 1 g was removed"
    return replace(recording, channels=channels), [note]
