"""Which way is left: the axes of a recorded drive, proven by the course over ground or stated by the user.

Taken literally, a log is in x forward, y left, z up (ISO 8855). Most loggers of motor sport write y right, z
down (SAE J670), so that lateral force, pitch and yaw rate have the opposite sign. Gravity in the vertical
channel distinguishes up from down, and the course over ground (`witnesses`) left from right. The user's
statement can replace either.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from otolith.core.errors import InputError, one_of
from otolith.recordings.channels import Recording
from otolith.recordings.checks.kinematics import Kinematics
from otolith.recordings.checks.remedies import listed, spelled
from otolith.recordings.checks.verdict import Verdict, alive
from otolith.recordings.columns import STANDARD_GRAVITY

AXES: Final = {
    "iso": "x forward, y left, z up (ISO 8855)",
    "sae": "x forward, y right, z down (SAE J670)",
}
# quantities that differ between SAE J670 and ISO 8855; az does too, see `_upright`
TURNED: Final = ("ay", "pitch_rate", "yaw_rate")
HOLDS_GRAVITY: Final = 0.5 * STANDARD_GRAVITY  # [m/s²] a larger mean of a_z includes gravity


@dataclass(frozen=True, slots=True)
class Oriented:
    """A recording in x forward, y left, z up, and the reasons for this orientation."""

    recording: Recording
    drive: Kinematics
    proof: str  # what proves left and right, in words; empty if nothing does
    turned: tuple[str, ...]  # quantities whose sign was turned
    notes: tuple[str, ...]


def parse_axes(text: str) -> str:
    """Return the word of `--axes`, or refuse an unknown one."""
    if text not in AXES:
        raise InputError("--axes", repr(text), one_of(AXES, text))
    return text


def oriented(recording: Recording, axes: str | None) -> Oriented:
    """Turn a recording into x forward, y left, z up where that is proven or stated.

    Parameters
    ----------
    axes : the user's statement, "iso" or "sae"; None to turn only what the file proves.

    Raises
    ------
    InputError : the file contradicts the mapping or the user, or z points down and nothing shows whether y
        points right. If none of the affected quantities is cued, a note is made instead.
    """
    stated = [key for key in TURNED if key in recording.channels] if axes == "sae" else []
    notes = [f"{listed(stated)}: turned, as --axes sae states"] if stated else []
    upright, up, more = _upright(negated(recording, stated), axes)
    turned = [*stated, *(["az"] if more else [])]
    notes += more
    drive = Kinematics(upright.channels)
    verdict = Verdict(drive, recording.source)
    cued = any(recording.needed(key) for key in (*TURNED, "az") if key in recording.channels)
    if axes is not None:
        notes += _unless(cued, lambda: verdict.refuse_statement(axes))
        return Oriented(upright, drive, f"your word, --axes {axes}", tuple(turned), tuple(notes))
    if verdict.turned(up):
        also = _turned_along(upright, up)
        upright, turned = negated(upright, also), [*turned, *also]
        notes += _about_turning(also, verdict.by, upright, up)
        drive = Kinematics(upright.channels)
        verdict = Verdict(drive, recording.source)
    elif up < 0.0:
        notes += _unless(cued, lambda: _refuse_half(verdict, recording))
    notes += _unless(cued, lambda: verdict.refuse_contradiction(up))
    gyro = any(recording.needed(key) for key in ("roll_rate", "pitch_rate") if key in recording.channels)
    notes += _unless(gyro, verdict.refuse_gyro)
    if cued:
        notes += _about_proof(verdict, upright, up)
    notes += _about_the_rest(verdict, upright, up)
    return Oriented(upright, drive, verdict.proof, tuple(turned), tuple(notes))


def _turned_along(recording: Recording, up: float) -> list[str]:
    """Return what is turned if the file has left and right exchanged: all of SAE J670, unless z points up."""
    keys = {1.0: ("ay", "yaw_rate"), -1.0: TURNED, 0.0: (*TURNED, "az")}[up]
    return [key for key in keys if key in recording.channels]


def _about_turning(keys: Sequence[str], by: str, recording: Recording, up: float) -> list[str]:
    if up <= 0.0:
        same = f"the file is in {AXES['sae']}; --axes sae says the same"
        return [f"{listed(keys)}: turned, for {by} shows that {same}", *_as_a_compass(recording)]
    notes = [f"{listed(keys)}: turned, for {by} shows that right is positive there, though z points up"]
    notes += _as_a_compass(recording)
    if alive(recording.channels, ["pitch_rate"]):
        notes.append("doubtful: pitch_rate: nothing shows whether it is turned, too; it is left unchanged")
    return notes


def _as_a_compass(recording: Recording) -> list[str]:
    """Note the assumption about a heading without positions, and the remedy if it is wrong."""
    if "heading" not in recording.channels or {"lat", "lon"} <= set(recording.channels):
        return []
    name = repr(recording.channels["heading"].column.name)
    return [
        f"{name} is taken to count clockwise, as a compass does; if it counts the other way, leave it out "
        "with heading=none"
    ]


def negated(recording: Recording, keys: Iterable[str]) -> Recording:
    """Turn signs in addition to the mapping; columns keep their factors, which remedies refer to."""
    channels = dict(recording.channels)
    for key in keys:
        channels[key] = replace(channels[key], values=-channels[key].values)
    return replace(recording, channels=channels)


def _unless(cued: bool, refuse: Callable[[], None]) -> list[str]:
    """Run a check, and return its refusal as a note if the quantities it concerns are not cued."""
    try:
        refuse()
    except InputError as error:
        if cued:
            raise
        return [f"reported only, since it is not cued: {error}"]
    return []


def _about_proof(verdict: Verdict, recording: Recording, up: float) -> list[str]:
    if verdict.proof:
        notes = [f"left and right are proven by {verdict.proof}"]
        hidden = verdict.lateral == 0 or verdict.faint
        if verdict.yaw > 0 and hidden and alive(recording.channels, ["ay"]):
            notes.append(
                "the sign of ay is not proven: it goes too little with the turning, as on a bank or in a lean"
            )
        elif verdict.yaw > 0 and verdict.bank:
            notes.append(
                "the sign of ay is not proven: on a road that is banked by "
                f"{np.degrees(verdict.bank):.0f} deg the same would show with ay turned"
            )
        return notes
    if verdict.condition:
        return [f"left and right agree with {verdict.condition}; --axes iso or --axes sae states it"]
    if not alive(recording.channels, TURNED if up else (*TURNED, "az")):
        return []
    return [
        "left and right are not proven: nothing in the file knows the ground, and lateral force and yaw rate "
        "agree just as well with y right and z down (SAE J670, as most loggers of motor sport write); "
        "--axes sae or --axes iso states it"
    ]


def _about_the_rest(verdict: Verdict, recording: Recording, up: float) -> list[str]:
    """Note the quantities whose sign nothing in the file shows."""
    keys = [key for key in verdict.unproven(up) if not recording.needs or recording.needed(key)]
    if not keys:
        return []
    why = "nothing in the file can be compared with it; it is taken in the axes of the rest"
    return [f"the sign of {listed(keys)} is not proven: {why}"]


def _upright(recording: Recording, axes: str | None) -> tuple[Recording, float, list[str]]:
    """Turn over a vertical channel with negative gravity, and return how z points: +1 up, -1 down, 0 unknown.

    Gravity decides if the channel includes it. Otherwise the stated axes do.
    """
    az = recording.channels.get("az")
    if az is None:
        return recording, 0.0, []
    mean = float(np.mean(az.values))
    if mean > HOLDS_GRAVITY:
        return recording, 1.0, []
    if mean < -HOLDS_GRAVITY:
        if axes == "iso":
            way = f"--axes sae, or map az={spelled(az.column, -1.0)} if only z is turned"
            raise InputError(
                f"mean of az in {recording.source}", f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s² ({way})"
            )
        note = f"az averages {mean:.4g} m/s², so z points down: its sign was turned"
        return negated(recording, ["az"]), -1.0, [note]
    if axes == "sae":
        note = "az: turned, as --axes sae states; without gravity in it nothing proves that"
        return negated(recording, ["az"]), 0.0, [note]
    return recording, 0.0, []


def _refuse_half(verdict: Verdict, recording: Recording) -> None:
    """Refuse a drive whose z points down while nothing shows whether y points right, if that matters."""
    if verdict.yaw > 0 or verdict.lateral > 0 or not alive(recording.channels, TURNED):
        return
    az = recording.channels["az"]
    bound = (
        "about 0 or +9.81 m/s²: does z point down? Then y may point right, which nothing in the file shows: "
        f"--axes sae if it does (ay, az, pitch and yaw rate are turned), map az={spelled(az.column, -1.0)} "
        "if it points left"
    )
    raise InputError(f"mean of az in {recording.source}", f"{float(np.mean(az.values)):.4g} m/s²", bound)
