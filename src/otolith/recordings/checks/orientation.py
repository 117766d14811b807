"""Which way is left: the axes of a recorded drive, proven by what knows the ground, or stated by the user.

Read as it stands, a log is in x forward, y left, z up (ISO 8855). Most loggers of motor sport write y
right, z down (SAE J670): lateral force, pitch and yaw rate are turned there. Gravity in the vertical
channel decides up from down; the course over ground (`witnesses`) left from right; the user's word
stands in for either.
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
TURNED: Final = ("ay", "pitch_rate", "yaw_rate")  # by SAE J670 against ISO 8855; az, too, see `_upright`
HOLDS_GRAVITY: Final = 0.5 * STANDARD_GRAVITY  # [m/s²] a mean of a_z beyond it holds the standing 1 g


@dataclass(frozen=True, slots=True)
class Oriented:
    """A recording in x forward, y left, z up, and how that is known."""

    recording: Recording
    drive: Kinematics
    proof: str  # what proves left and right, in words; empty where nothing does
    turned: tuple[str, ...]  # quantities whose sign was turned
    notes: tuple[str, ...]


def parse_axes(text: str) -> str:
    """Check the word of `--axes`."""
    if text not in AXES:
        raise InputError("--axes", repr(text), one_of(AXES, text))
    return text


def oriented(recording: Recording, axes: str | None) -> Oriented:
    """Turn a recording into x forward, y left, z up where that is proven or stated.

    Parameters
    ----------
    axes : what the user states, "iso" or "sae"; None: only what the file proves is turned.

    Raises
    ------
    InputError : the file's witnesses contradict the mapping or the user, or z points down and nothing decides
        whether y points right, too; a note where none of that is cued.
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
    """What is turned when the ground shows that left is right: all of SAE J670, unless gravity says z up."""
    keys = {1.0: ("ay", "yaw_rate"), -1.0: TURNED, 0.0: (*TURNED, "az")}[up]
    return [key for key in keys if key in recording.channels]


def _about_turning(keys: Sequence[str], by: str, recording: Recording, up: float) -> list[str]:
    if up <= 0.0:
        same = f"the file is in {AXES['sae']}; --axes sae says the same"
        return [f"{listed(keys)}: turned, for {by} shows that {same}", *_as_a_compass(recording)]
    notes = [f"{listed(keys)}: turned, for {by} shows that right is positive there, though z points up"]
    notes += _as_a_compass(recording)
    if alive(recording.channels, ["pitch_rate"]):
        notes.append("doubtful: pitch_rate: nothing tells whether it is turned, too; it is left as it is")
    return notes


def _as_a_compass(recording: Recording) -> list[str]:
    """What is taken for granted of a heading without positions beside it, and what to do if it is wrong."""
    if "heading" not in recording.channels or {"lat", "lon"} <= set(recording.channels):
        return []
    name = repr(recording.channels["heading"].column.name)
    return [
        f"{name} is taken to count clockwise, as a compass does; if it counts the other way, leave it out "
        "with heading=none"
    ]


def negated(recording: Recording, keys: Iterable[str]) -> Recording:
    """Signs turned, behind the mapping: columns keep their factors, for remedies are written as mappings."""
    channels = dict(recording.channels)
    for key in keys:
        channels[key] = replace(channels[key], values=-channels[key].values)
    return replace(recording, channels=channels)


def _unless(cued: bool, refuse: Callable[[], None]) -> list[str]:
    """Let a refusal pass as a note where what it is about is not cued."""
    try:
        refuse()
    except InputError as error:
        if cued:
            raise
        return [f"not cued, so only said: {error}"]
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
    """A note about signs that nothing in the file shows, whatever it shows of left and right."""
    keys = [key for key in verdict.unproven(up) if not recording.needs or recording.needed(key)]
    if not keys:
        return []
    why = "nothing in the file can be compared with it; it is taken in the axes of the rest"
    return [f"the sign of {listed(keys)} is not proven: {why}"]


def _upright(recording: Recording, axes: str | None) -> tuple[Recording, float, list[str]]:
    """Turn a vertical channel over that holds gravity the wrong way; what it says: +1 up, -1 down, 0 nothing.

    Gravity decides wherever it is in the channel. Where it is not, the stated axes do.
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
        "about 0 or +9.81 m/s²: does z point down? Then y may point right, and nothing in the file tells: "
        f"--axes sae if it does (ay, az, pitch and yaw rate are turned), map az={spelled(az.column, -1.0)} "
        "if it points left"
    )
    raise InputError(f"mean of az in {recording.source}", f"{float(np.mean(az.values)):.4g} m/s²", bound)
