"""Machines that nobody would build, and what `six-axis` does on them when what is wanted jumps at random.

A part of `six_axis.py`.
"""

import tomllib
from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from otolith import registry
from otolith.core.frames import DOFS
from otolith.core.jit import kernel
from otolith.cueing.design import Design
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.six_axis import body_of
from otolith.interfaces import Cueing
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import Platform, load
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import Actuators, leg_motion
from otolith.platforms.template import template
from otolith.scenarios import Scenario

DAVSI: Final = load("davsi")
SIX: Final = tuple(DOFS.values())
AXES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")
HOLD: Final = 8  # periods between two jumps
Vec = NDArray[np.float64]


@kernel
def leave(of: Actuators, middle: Vec, reach: Vec, pose: Vec, twist: Vec, acceleration: Vec, out: Vec) -> None:
    """Write how far each sample (n, 3) leaves ±reach about the middle; negative where there is room."""
    motion = np.empty((3, 6))
    for k in range(len(pose)):
        leg_motion(pose[k], twist[k], acceleration[k], of, motion)
        for order in range(3):
            out[k, order] = np.abs(motion[order] - middle[order]).max() - reach[order]


def of_legs(legs: Hexapod, run: Run) -> Vec:
    """How far each sample (n, 3) leaves stroke, speed and acceleration of the legs."""
    low, high = legs.stroke
    middle = np.array([0.5 * (low + high), 0.0, 0.0])
    reach = np.array([0.5 * (high - low), legs.speed, legs.acceleration])
    beyond = np.empty((len(run.pose), 3))
    leave(legs.actuators, middle, reach, run.pose, run.twist, run.acceleration, beyond)
    return beyond


def machines() -> Iterator[tuple[str, Platform]]:
    """Eight machines with the limits per axis of `davsi` and legs or cranks that nobody would build."""
    legs = DAVSI.six_legs()
    rng, foot = np.random.default_rng(3), legs.anchors.copy()
    height = -float(foot[0, 2] - legs.joints[0, 2])
    crossed, upright, narrow = foot.copy(), foot.copy(), foot.copy()
    crossed[:, :2] = legs.joints[[1, 0, 3, 2, 5, 4], :2] * 1.2
    upright[:, :2] = 0.35 * foot[:, :2] + 0.65 * legs.joints[:, :2]
    narrow[:, :2] *= 0.55
    lopsided = foot + rng.uniform(-0.25, 0.25, foot.shape)
    bent = legs.joints + rng.uniform(-0.2, 0.2, foot.shape)
    yield "as it is", _machine(legs.joints, foot, height)
    yield "asymmetric feet", _machine(legs.joints, lopsided, height)
    yield "asymmetric joints", _machine(bent, foot, height)
    yield "crossed", _machine(legs.joints, crossed, height)
    yield "nearly vertical", _machine(legs.joints, upright, height)
    yield "narrow base", _machine(legs.joints, narrow, height)
    yield "cranks", _cranks(None)
    yield "asymmetric cranks", _cranks(np.random.default_rng(4))


def _machine(joints: Vec, anchors: Vec, height: float) -> Platform:
    """A platform of these joints and anchors, with strokes about its own neutral lengths."""
    table = DAVSI.model_dump(exclude_none=True)
    hexapod = table["hexapod"]
    hexapod.pop("circles")
    hexapod["reference_point_m"] = (0.0, 0.0, 0.0)
    shift = np.array([0.0, 0.0, height])
    hexapod["joints"] = {
        "base_m": tuple(map(tuple, (anchors + shift).tolist())),
        "platform_m": tuple(map(tuple, joints.tolist())),
    }
    hexapod["neutral_height_m"] = height
    lengths = np.linalg.norm(joints - anchors, axis=1)
    hexapod["legs"]["length_m"] = (float(lengths.min() - 0.2), float(lengths.max() + 0.2))
    return Platform.model_validate(table)


def _cranks(rng: np.random.Generator | None) -> Platform:
    """The cranks of the template, or displaced ones, with limits per axis far beyond what they reach."""
    table = tomllib.loads(template("cranks"))
    legs = Platform.model_validate(table).six_legs()
    of_axes = DAVSI.model_dump(exclude_none=True)
    table |= {name: of_axes[name] for name in (*AXES, "tilt_coordination")}
    table.pop("workspace")
    if rng is not None:
        hexapod = table["hexapod"]
        hexapod.pop("circles")
        shift = np.array([0.0, 0.0, hexapod["neutral_height_m"]])
        shafts = legs.anchors + shift + rng.uniform(-0.04, 0.04, (6, 3))
        joints = legs.joints + rng.uniform(-0.04, 0.04, (6, 3))
        hexapod["joints"] = {"base_m": shafts.tolist(), "platform_m": joints.tolist()}
        heading = hexapod["cranks"]["heading_deg"] + rng.uniform(-15.0, 15.0, 6)
        hexapod["cranks"]["heading_deg"] = heading.tolist()
    return Platform.model_validate(table)


def hostile(jumps: int, seed: int) -> None:
    """Print what random jumps do on every machine."""
    for name, platform in machines():
        cueing = registry.make_cueing("six-axis", Design(platform=platform, dofs=SIX))
        counts = attacked(cueing, platform, jumps, seed)
        print(f"{name:18} {counts}", flush=True)


def held(values: Vec, t: Vec) -> Vec:
    """What is wanted at times t, each row of `values` for as many periods."""
    return np.asarray(values[np.minimum((t * 100.0 + 1e-6).astype(int) // HOLD, len(values) - 1)])


def attacked(cueing: Cueing, platform: Platform, jumps: int, seed: int) -> str:
    """Let what is wanted jump every few periods, and say what came of it."""
    rng, steps = np.random.default_rng(seed), jumps * HOLD
    size = np.exp(rng.uniform(np.log(0.1), np.log(50.0), jumps))[:, None]
    jumped = size * rng.standard_normal((jumps, 6)) * [1.0, 1.0, 1.0, 0.02, 0.02, 0.1]
    nodes, between, found = np.full(3, -np.inf), np.full(3, -np.inf), {"decided": 0, "relaxed": 0}
    body = body_of(platform, SIX, 0.5, period=0.01, lag=MpcSettings().lag_on(platform))
    allowed = body.margins.max(axis=1)  # between rows and limits
    part = 1000 * HOLD
    for first in range(0, steps, part):
        chosen = jumped[first // HOLD : (first + part) // HOLD]

        wanted = Scenario(
            name="jumps",
            duration=len(chosen) * HOLD * 0.01,
            specific_force=partial(held, chosen[:, :3]),
            angular_rate=partial(held, chosen[:, 3:]),
        )
        run = simulate(
            cueing,
            Ideal(head=(0.0, 0.0, 0.0)),
            wanted,
            platform=platform,
            dofs=tuple(DOFS),
            plant_period=0.005,
        )
        beyond = of_legs(platform.six_legs(), run)
        nodes = np.maximum(nodes, beyond[1::2].max(axis=0))
        between = np.maximum(between, beyond.max(axis=0))
        found["decided"] += sum(status == "decided" for status in run.status)
        found["relaxed"] += sum(solver == "infeasible" for solver in run.solver)
    return (
        f"{steps} decisions after {jumps} jumps: {steps - found['decided']} without an answer, "
        f"{found['relaxed']} relaxed; {in_units('legs beyond limits', np.maximum(between, 0.0))}; "
        f"beyond rows {in_units('at nodes', nodes + allowed)}, {in_units('between', between + allowed)}, "
        f"{in_units('computed bound', np.array(body.between))}"
    )


def in_units(what: str, values: Vec) -> str:
    """Length, speed and acceleration in words."""
    return f"{what} {values[0]:.1e} m, {values[1]:.1e} m/s, {values[2]:.1e} m/s2"
