"""The figures of chapter 5 and appendix C: closed loops as the thesis draws them, and formulas."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.washout_weights import PRESETS
from otolith.platforms import load
from otolith.scenarios import TABLE_5_1, scenario
from otolith_thesis.braking import T_POSITION, T_TILT
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import FOUR_DOF, Closed, Loop, Motion
from otolith_thesis.model_tables import best_constant
from otolith_thesis.outcome import Claim, Curve, Grid, Outcome, Panel
from otolith_thesis.studies.common import PAIR

BRAKING: Final = ExplicitSettings(braking=BrakingRows.POSITION)
SAY: Final = {"surge-pitch": "longitudinal", "sway-roll": "lateral"}
BENCHMARK: Final = ExplicitSettings(block_from=None, braking=BrakingRows.POSITION, control_weight=0.1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """A figure of one closed loop."""

    name: str
    title: str
    section: str
    loop: Loop

    def outcome(self, answers: Answers) -> Outcome:
        """Draw force, tilt and travel of every cued pair."""
        closed: Closed = answers[self.loop]
        panels = [panel for pair in self.loop.dofs for panel in motion_panels(closed.motion[pair], pair)]
        cues = ", ".join(f"{count} {kind}" for kind, count in sorted(closed.cues.items())) or "none"
        errors = ", ".join(f"{SAY[pair]} {error:.4f}" for pair, error in closed.rmse.items())
        return Outcome(
            name=self.name,
            kind="figure",
            title=self.title,
            section=self.section,
            text=f"RMSE {errors} m/s²; false cues: {cues}.",
            grids=(_run_grid(closed),),
            panels=tuple(panels),
        )


def _run_grid(closed: Closed) -> Grid:
    """Return the figures of a closed loop; the effort is that of the whole controller."""
    spread = closed.spread()
    effort = (spread["mean"], spread["p99"], spread["max"], closed.unsolved)
    rows = [(SAY[pair], error, closed.travel[pair], *effort) for pair, error in closed.rmse.items()]
    header = ("direction", "RMSE [m/s²]", "travel RMS [m]", "changes, mean", "p99", "max", "unsolved")
    return Grid(title="The run in figures", header=header, rows=tuple(rows))


_EXPLICIT_4: Final = ExplicitSettings(horizon=2, period=0.25, block_from=None)
DRAWN: Final = {
    figure.name: figure
    for figure in (
        Drawn(
            name="figure-5.2",
            title="Explicit MPC, sine of 2 m/s²",
            section="5.2.1",
            loop=Loop(scenario="sine-2", cueing="explicit", explicit=ExplicitSettings(block_from=None)),
        ),
        Drawn(
            name="figure-5.3",
            title="Explicit MPC with move blocking, sine of 2 m/s²",
            section="5.2.2",
            loop=Loop(scenario="sine-2", cueing="explicit"),
        ),
        Drawn(
            name="figure-5.4",
            title="Explicit MPC with braking constraint, sine of 2 m/s²",
            section="5.2.3",
            loop=Loop(scenario="sine-2", cueing="explicit", explicit=BRAKING),
        ),
        Drawn(
            name="figure-5.6",
            title="Explicit MPC with braking constraint, sine of 0.5 m/s²",
            section="5.2.3",
            loop=Loop(scenario="sine-0.5", cueing="explicit", explicit=BRAKING),
        ),
        Drawn(
            name="figure-5.7",
            title="Braking constraints and constant washout, sine of 0.5 m/s²",
            section="5.2.4",
            loop=Loop(scenario="sine-0.5", washout=best_constant("sine-0.5", "thesis-fit")),
        ),
        Drawn(
            name="figure-5.8",
            title="Multiple event signal with adaptive weights",
            section="5.2.4",
            loop=Loop(scenario="step-sine-0.5"),
        ),
        Drawn(
            name="figure-5.9",
            title="Explicit MPC in 4 DOF, sine of 1 m/s² and 0.1 Hz",
            section="5.3.1",
            loop=Loop(scenario="sine-1", cueing="explicit", dofs=FOUR_DOF, explicit=_EXPLICIT_4),
        ),
        Drawn(
            name="figure-5.10",
            title="4 DOF without washout, sine of 0.5 m/s² and 0.1 Hz",
            section="5.3.2",
            loop=Loop(scenario="sine-0.5", dofs=FOUR_DOF, washout=PRESETS["none"], solver="structured"),
        ),
        Drawn(
            name="figure-5.11",
            title="4 DOF with adaptive washout, sine of 0.5 m/s² and 0.1 Hz",
            section="5.3.2",
            loop=Loop(scenario="sine-0.5", dofs=FOUR_DOF, cueing="hybrid-all"),
        ),
        Drawn(
            name="figure-5.12",
            title="4 DOF with adaptive washout, multiple event wave",
            section="5.3.2",
            loop=Loop(scenario="step-sine-0.5", dofs=FOUR_DOF, cueing="hybrid-all"),
        ),
        Drawn(
            name="figure-c.4",
            title="Explicit benchmark, step of 1 m/s²",
            section="C.2",
            loop=Loop(scenario="step-1", cueing="explicit", explicit=BENCHMARK, on="benchmark"),
        ),
        Drawn(
            name="figure-c.5",
            title="Explicit benchmark, sine of 1 m/s²",
            section="C.2",
            loop=Loop(scenario="sine-1", cueing="explicit", explicit=BENCHMARK, on="benchmark"),
        ),
        Drawn(
            name="figure-c.6",
            title="Step with adaptive weights",
            section="C.4.1",
            loop=Loop(scenario="step-1"),
        ),
        Drawn(
            name="figure-c.7",
            title="Sine with adaptive weights",
            section="C.4.1",
            loop=Loop(scenario="sine-1"),
        ),
    )
}


def motion_panels(motion: Motion, pair: str) -> tuple[Panel, Panel, Panel]:
    """Return panels of specific force with its two parts, tilt and its rate, displacement and velocity."""
    t = motion.time
    return (
        Panel(
            title=f"Specific force, {SAY[pair]}",
            x_label="time [s]",
            y_label="[m/s²]",
            curves=(
                Curve(label="reference", x=t, y=motion.wanted, dash=True),
                Curve(label="felt", x=t, y=motion.felt),
                Curve(label="from acceleration", x=t, y=motion.translation),
                Curve(label="from tilt", x=t, y=motion.tilt_part),
            ),
        ),
        Panel(
            title=f"Tilt, {SAY[pair]}",
            x_label="time [s]",
            y_label="tilt [deg]",
            right_label="tilt rate [deg/s]",
            curves=(
                Curve(label="tilt", x=t, y=motion.tilt_deg),
                Curve(label="tilt rate", x=t, y=motion.tilt_rate_deg, right=True),
            ),
        ),
        Panel(
            title=f"Travel, {SAY[pair]}",
            x_label="time [s]",
            y_label="displacement [m]",
            right_label="velocity [m/s]",
            curves=(
                Curve(label="displacement", x=t, y=motion.position),
                Curve(label="velocity", x=t, y=motion.velocity, right=True),
            ),
        ),
    )


def figure_4_2(answers: Answers) -> Outcome:
    """Draw figure 4.2: the adaptive weight of the displacement."""
    del answers
    weight = next(w for w in PRESETS["printed"] if w.on == "position")
    s = np.linspace(-0.5, 0.5, 201)
    values = np.array([weight.at(np.array([0.0, 0.0, 0.0, value, 0.0, 0.0])) for value in s])
    return Outcome(
        name="figure-4.2",
        kind="figure",
        title="Adaptive weight of the platform's displacement",
        section="4.1.2",
        text="Eq. 4.12 with its printed coefficients: 60.01 at the limit, 16.26 half-way.",
        panels=(
            Panel(
                title="Weight",
                x_label="displacement [m]",
                y_label="W",
                curves=(Curve(label="W of the displacement", x=s, y=values),),
            ),
        ),
    )


def figure_5_1(answers: Answers) -> Outcome:
    """Draw figure 5.1: the reference signals."""
    del answers
    groups = (TABLE_5_1[:3], TABLE_5_1[3:4], TABLE_5_1[4:6], TABLE_5_1[6:])
    return Outcome(
        name="figure-5.1",
        kind="figure",
        title="Reference signals",
        section="5.1",
        panels=tuple(
            Panel(
                title=", ".join(group),
                x_label="time [s]",
                y_label="[m/s²]",
                curves=tuple(_signal(name) for name in group),
            )
            for group in groups
        ),
    )


def _signal(name: str) -> Curve:
    one = scenario(name)
    t = np.linspace(0.0, one.duration, 1001)
    return Curve(label=name, x=t, y=one.specific_force(t)[:, 0])


_FREE, _BRAKED = DRAWN["figure-5.3"].loop, DRAWN["figure-5.4"].loop


def figure_5_5(answers: Answers) -> Outcome:
    """Draw figure 5.5: the braking constraint, and how the velocity falls near the limit."""
    panels = []
    for title, loop in (("without braking constraint", _FREE), ("with", _BRAKED)):
        motion = answers[loop].motion[PAIR]
        panels.append(
            Panel(
                title=f"Sine of 2 m/s², {title}",
                x_label="time [s]",
                y_label="[m]",
                right_label="velocity [m/s]",
                curves=(
                    Curve(label="displacement", x=motion.time, y=motion.position),
                    Curve(label="braking row", x=motion.time, y=_braking_row(motion, 2.5)),
                    Curve(label="velocity", x=motion.time, y=motion.velocity, right=True, dash=True),
                ),
            )
        )
    return Outcome(
        name="figure-5.5",
        kind="figure",
        title="Braking constraint plot",
        section="5.2.3",
        text="The row s + c_v v T + ½ c_u a T² is held within ±0.5 m.",
        panels=tuple(panels),
    )


def _braking_row(motion: Motion, T: float) -> Vec:
    law = load("thesis").braking
    row: Vec = motion.position + law.c_v * motion.velocity * T + 0.5 * law.c_u * motion.translation * T**2
    return row


def _timed(travel: float, tilt: float) -> Loop:
    return Loop(scenario="sine-2", cueing="explicit", explicit=BRAKING, braking_times=(travel, tilt))


_TRAVEL_TIMES: Final = {T: _timed(T, 0.5) for T in T_POSITION}
_TILT_TIMES: Final = {T: _timed(2.5, T) for T in T_TILT}


def timed_jobs() -> list[Loop]:
    """Return the loops of figures C.2 and C.3."""
    return [*_TRAVEL_TIMES.values(), *_TILT_TIMES.values()]


def figure_c2(answers: Answers) -> Outcome:
    """Draw figure C.2: the explicit MPC for four values of T of the travel."""
    motions = {T: answers[loop].motion[PAIR] for T, loop in _TRAVEL_TIMES.items()}
    peaks = {T: _peak(answers, loop) for T, loop in _TRAVEL_TIMES.items()}
    speeds = {T: _fastest(answers, loop) for T, loop in _TRAVEL_TIMES.items()}
    rmse = {T: answers[loop].rmse[PAIR] for T, loop in _TRAVEL_TIMES.items()}
    rows = tuple((T, peaks[T], speeds[T], rmse[T]) for T in T_POSITION)
    return Outcome(
        name="figure-c.2",
        kind="figure",
        title="Motion cueing performance with varying T of the travel",
        section="C.1",
        text="Explicit MPC with braking constraint, sine of 2 m/s².",
        claims=(
            Claim(
                text="With T = 2 s the platform leaves its limits",
                holds=peaks[2.0] > 0.5 + 1e-6,
                figures=f"{peaks[2.0]:.3f} m of 0.5 m",
            ),
            Claim(
                text="T = 2.5 s gives a lower velocity than 1.5 s",
                holds=speeds[2.5] < speeds[1.5],
                figures=f"{speeds[2.5]:.2f} against {speeds[1.5]:.2f} m/s",
            ),
        ),
        grids=(
            Grid(
                title="By T",
                header=("T [s]", "largest displacement [m]", "fastest [m/s]", "RMSE [m/s²]"),
                rows=rows,
            ),
        ),
        panels=tuple(
            _overlay(what, unit, [(f"T = {T:g} s", motion) for T, motion in motions.items()])
            for what, unit in (("position", "m"), ("velocity", "m/s"))
        ),
    )


def figure_c3(answers: Answers) -> Outcome:
    """Draw figure C.3: the explicit MPC for four values of T of the tilt."""
    motions = {T: answers[loop].motion[PAIR] for T, loop in _TILT_TIMES.items()}
    base = motions[0.5].tilt_deg
    gap = max(float(np.max(np.abs(motion.tilt_deg - base))) for motion in motions.values())
    reach = max(float(np.max(np.abs(motion.tilt_deg))) for motion in motions.values())
    return Outcome(
        name="figure-c.3",
        kind="figure",
        title="Motion cueing performance with varying T of the tilt",
        section="C.1",
        text=(
            "Explicit MPC with braking constraint, sine of 2 m/s². At 3 deg/s the tilt never comes near 30 "
            "deg, so that the tilt's braking row is never active."
        ),
        claims=(
            Claim(
                text="T of the tilt matters between 0.3 and 1 s",
                holds=gap > 1e-6,
                figures=f"tilts apart by {gap:.1e} deg; the largest is {reach:.1f} deg of 30 deg",
            ),
        ),
        panels=(_overlay("tilt_deg", "deg", [(f"T = {T:g} s", motion) for T, motion in motions.items()]),),
    )


def _peak(answers: Answers, loop: Loop) -> float:
    return float(np.max(np.abs(answers[loop].motion[PAIR].position)))


def _fastest(answers: Answers, loop: Loop) -> float:
    return float(np.max(np.abs(answers[loop].motion[PAIR].velocity)))


def _overlay(what: str, unit: str, motions: Sequence[tuple[str, Motion]]) -> Panel:
    curves = tuple(Curve(label=label, x=motion.time, y=getattr(motion, what)) for label, motion in motions)
    words = what.removesuffix("_deg")
    return Panel(title=words.capitalize(), x_label="time [s]", y_label=f"{words} [{unit}]", curves=curves)
