"""Section 6.3: Tables 6.4 and 6.5, the map of figure 6.3, and the laps of figures 6.4, 6.5, C.10 to C.13."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from otolith.platforms import load
from otolith_thesis.figures import motion_panels
from otolith_thesis.hint_loops import NAME
from otolith_thesis.jobs import Answers
from otolith_thesis.lap_reference import SPEEDS
from otolith_thesis.laps import (
    FASTEST,
    SAYS,
    STUDIED,
    TOGETHER,
    Drive,
    Driven,
    HintedLaps,
    Lap,
    LapOnLegs,
    OnLegs,
)
from otolith_thesis.loop import FOUR_DOF, MODELS, Closed, Motion
from otolith_thesis.outcome import Cell, Claim, Curve, Grid, Outcome, Panel
from otolith_thesis.published import published
from otolith_thesis.verdict import Number, judged_row

# On the hexapod: every model at the highest speed, the thesis's own model at every speed.
ON_LEGS: Final = (*(LapOnLegs(s, STUDIED) for s in SPEEDS[:-1]), *(LapOnLegs(FASTEST, m) for m in MODELS))
NARROW: Final = Lap(FASTEST, MODELS[0], on=TOGETHER)  # effect of the smaller workspace, on the ideal plant
EVENT: Final = 80.0  # [s] time of the thesis's example of a braking that cannot be cued
NEAR: Final = 10.0  # [s] distance from that time that counts as near
BEGINNING: Final = 8.0  # [s] initial part of the lap that the map marks
LEGS: Final = ", hexapod"
_DEGREE: Final = 180.0 / np.pi


def lap_jobs() -> list[Any]:
    """Return all cells of Tables 6.4 and 6.5."""
    ideal = [Lap(speed, model) for speed in SPEEDS for model in MODELS]
    return [*ideal, *ON_LEGS, NARROW, HintedLaps()]


def lap_table(name: str, answers: Answers) -> Outcome:
    """Build Table 6.4 or 6.5: the laps on the ideal plant, then those on the hexapod."""
    printed, counts = published(name), name == "table-6.4"
    numbers: list[Number] = []
    for place in ("", LEGS):
        for row in printed.rows:
            pair = SAYS.get(row.get("direction", ""), "")
            found = _by_model(answers, row["speed_kmh"], on_legs=place == LEGS)
            ours = {m: one.spread()["mean"] if counts else one.rmse[pair] for m, one in found.items()}
            title = " ".join(filter(None, (f"{row['speed_kmh']} km/h", row.get("direction"))))
            numbers += judged_row(title + place, row, ours)
    return Outcome(
        name=name,
        kind="table",
        title=printed.title,
        section=printed.section,
        text=(
            "The car, its driver and the track are ours, not CarMaker's; the reference is the car's "
            "acceleration through eq. 6.4, as in the thesis. Cued by the structured engine, whose changes "
            "are counted otherwise. The thesis's reference is not published. On the hexapod within what its "
            f"legs can do in every combination of the four axes (platform {TOGETHER}), the tilt rate soft."
        ),
        numbers=tuple(numbers),
        claims=_counted(answers) if counts else _tracked(answers),
        grids=(
            (_ideal_grid(answers), _legs_grid(answers))
            if counts
            else (_workspace_grid(answers), _legs_grid(answers))
        ),
        reasons=("study-lap-size",),
    )


def _by_model(answers: Answers, speed: int, *, on_legs: bool) -> dict[str, Closed]:
    """Return the laps at one speed by model; on the hexapod, only for the models that are run on it."""
    if on_legs:
        return {job.cueing: answers[job].closed for job in ON_LEGS if job.speed == speed}
    return {model: answers[Lap(speed, model)] for model in MODELS}


# --- the thesis's statements


def _counted(answers: Answers) -> tuple[Claim, ...]:
    saved = {model: float(np.mean(_saved(answers, model))) for model in MODELS[1:]}
    figures = ", ".join(f"{model} {100 * value:.1f} %" for model, value in saved.items())
    return (
        Claim(
            text="Every guess saves iterations on the laps",
            holds=min(saved.values()) > 0.0,
            figures=figures,
        ),
        Claim(
            text="The hybrid with all inputs saves the most",
            holds=max(saved, key=saved.__getitem__) == STUDIED,
            figures=figures,
        ),
    )


def _saved(answers: Answers, model: str) -> list[float]:
    """Return the share of the implicit MPC's mean changes that is saved at each speed, on the ideal plant."""
    spreads = [{m: answers[Lap(speed, m)].spread()["mean"] for m in (MODELS[0], model)} for speed in SPEEDS]
    return [1.0 - spread[model] / spread[MODELS[0]] for spread in spreads]


def _tracked(answers: Answers) -> tuple[Claim, ...]:
    ideal = {way: [answers[Lap(s, MODELS[0])].rmse[pair] for s in SPEEDS] for way, pair in SAYS.items()}
    legs = {
        way: [answers[LapOnLegs(s, STUDIED)].closed.rmse[pair] for s in SPEEDS] for way, pair in SAYS.items()
    }
    return tuple(
        Claim(
            text=f"The error grows with the speed in both directions, {place}",
            holds=all(errors == sorted(errors) for errors in by_way.values()),
            figures="; ".join(
                f"{way} {', '.join(f'{error:.4f}' for error in errors)}" for way, errors in by_way.items()
            ),
        )
        for place, by_way in (("ideal plant", ideal), ("hexapod", legs))
    )


# --- figures that the tables do not show


def _ideal_grid(answers: Answers) -> Grid:
    rows: list[tuple[Cell, ...]] = []
    for speed in SPEEDS:
        found = _by_model(answers, speed, on_legs=False) | {NAME: answers[HintedLaps()][speed]}
        rows += [(f"{speed} km/h", model, *_effort(one, found[MODELS[0]])) for model, one in found.items()]
    header = ("mean", "p99", "max", "step, p99 [µs]", "decisions of a lap [s]", "RMSE moved by", "unsolved")
    return Grid(
        title="Ideal plant: changes of the structured engine and time; the certified guess has the minimiser "
        "of the implicit MPC",
        header=("lap", "model", *header),
        rows=tuple(rows),
    )


def _effort(one: Closed, base: Closed) -> tuple[Cell, ...]:
    """Return changes, time, and the change of the RMSE against the model without a guess."""
    spread = one.spread()
    moved = max(abs(one.rmse[pair] / base.rmse[pair] - 1.0) for pair in FOUR_DOF)
    changes = (spread["mean"], spread["p99"], spread["max"])
    return (*changes, one.step_us["p99"], _seconds(one), f"{100.0 * moved:.2g} %", one.unsolved)


def _seconds(one: Closed) -> float:
    """Return the CPU time [s] of all decisions of a lap."""
    return 1e-6 * one.step_us["mean"] * len(one.changes)


def _legs_grid(answers: Answers) -> Grid:
    header = ("RMSE x [m/s²]", "y", "changes, mean", "p99", "max", "decisions of a lap [s]", "whole lap [s]")
    verdicts = ("unsolved", "supervisor acted", "nodes beyond another limit", "tilt rate beyond [deg/s]")
    rows = tuple((f"{job.speed} km/h", job.cueing, *_on_legs(answers[job])) for job in ON_LEGS)
    return Grid(
        title="Hexapod: errors, effort, and whether limits of platform and legs held (the tilt rate is soft)",
        header=("lap", "model", *header, *verdicts),
        rows=rows,
    )


def _on_legs(one: OnLegs) -> tuple[Cell, ...]:
    of, spread = one.closed, one.closed.spread()
    hard = sum(nodes for quantity, nodes in one.broken.items() if not quantity.endswith("tilt_rate"))
    beyond = max(excess for quantity, excess in of.excess.items() if quantity.endswith("tilt_rate"))
    errors, changes = (of.rmse[pair] for pair in FOUR_DOF), (spread["mean"], spread["p99"], spread["max"])
    return (
        *(*errors, *changes, _seconds(of), one.seconds),
        *(of.unsolved, one.interventions, hard, _DEGREE * beyond),
    )


def _workspace_grid(answers: Answers) -> Grid:
    """Compare the implicit MPC at the highest speed: the thesis's limits, the legs' limits, the hexapod."""
    laps = {
        "thesis's limits, ideal plant": answers[Lap(FASTEST, MODELS[0])],
        "legs' limits, ideal plant": answers[NARROW],
        "legs' limits, hexapod": answers[LapOnLegs(FASTEST, MODELS[0])].closed,
    }
    rows = tuple((name, *_use(one)) for name, one in laps.items())
    return Grid(
        title=f"What the smaller workspace costs: the implicit MPC at {FASTEST} km/h",
        header=("", "RMSE x [m/s²]", "y", "farthest from neutral [m]", "largest tilt [deg]"),
        rows=rows,
    )


def _use(one: Closed) -> tuple[Cell, ...]:
    along = [one.motion[pair] for pair in FOUR_DOF]
    far = float(np.max(np.hypot(*(motion.position for motion in along))))
    tilt = max(float(np.max(np.abs(motion.tilt_deg))) for motion in along)
    return (*(one.rmse[pair] for pair in FOUR_DOF), far, tilt)


# --- figures

LAP_FIGURES: Final = {  # figure -> speed [km/h], axis pair
    "figure-6.4": (120, "surge-pitch"),
    "figure-6.5": (120, "sway-roll"),
    "figure-c.10": (80, "surge-pitch"),
    "figure-c.11": (80, "sway-roll"),
    "figure-c.12": (100, "surge-pitch"),
    "figure-c.13": (100, "sway-roll"),
}
CUED: Final = "standing start"  # start of the laps here; the thesis does not state it
DRIVES: Final = {CUED: Drive(FASTEST, True), "flying start": Drive(FASTEST, False)}


def lap_figure_jobs(figure: str) -> list[Any]:
    """Return the run of one lap figure; for figure 6.4 also the drives."""
    job = Lap(LAP_FIGURES[figure][0], STUDIED)
    return [job, *DRIVES.values()] if figure == "figure-6.4" else [job]


def map_jobs() -> list[Drive]:
    """Return the drives of figure 6.3."""
    return list(DRIVES.values())


def map_figure(answers: Answers) -> Outcome:
    """Draw figure 6.3: the driven path, and the position of the car at 80 s."""
    drives: dict[str, Driven] = {start: answers[job] for start, job in DRIVES.items()}
    path = drives[CUED]
    panel = Panel(
        title=f"Hockenheim, driven at {FASTEST} km/h",
        x_label="x [m]",
        y_label="y [m]",
        curves=(
            Curve(label="path of the car", x=path.place[:, 0], y=path.place[:, 1]),
            _stretch("hardest braking", path, path.braking.start, path.braking.end),
            _stretch(f"the first {BEGINNING:g} s", path, 0.0, BEGINNING),
        ),
        equal=True,
    )
    return Outcome(
        name="figure-6.3",
        kind="figure",
        title="Hockenheim race track",
        section="6.3",
        text=_where(drives),
        panels=(panel,),
    )


def _stretch(label: str, one: Driven, start: float, end: float) -> Curve:
    """Return the part of the path between two times [s]."""
    on = (one.time >= start) & (one.time <= end)
    return Curve(label=label, x=one.place[on, 0], y=one.place[on, 1])


def _where(drives: Mapping[str, Driven]) -> str:
    places = {start: one.at(EVENT) for start, one in drives.items()}
    positions = "; ".join(f"{start} ({place[0]:.0f}, {place[1]:.0f}) m" for start, place in places.items())
    return f"At {EVENT:g} s the car is here: {positions}."


def lap_figure(figure: str, answers: Answers) -> Outcome:
    """Draw one direction of one lap; for figure 6.4 also examine the braking at 80 s."""
    speed, pair = LAP_FIGURES[figure]
    motion = answers[Lap(speed, STUDIED)].motion[pair]
    direction = {name: word for word, name in SAYS.items()}[pair]
    tells = figure == "figure-6.4"
    return Outcome(
        name=figure,
        kind="figure",
        title=f"A lap of Hockenheim at {speed} km/h, {direction}",
        section="6.3, C.4.2",
        claims=_at_80_s(answers, motion) if tells else (),
        grids=(_brakings(answers),) if tells else (),
        panels=motion_panels(motion, pair),
    )


def _at_80_s(answers: Answers, motion: Motion) -> tuple[Claim, ...]:
    """Test the text on figure 6.4 at the hardest braking; the laps start from standstill."""
    drives: dict[str, Driven] = {start: answers[job] for start, job in DRIVES.items()}
    begins = {start: one.braking.start for start, one in drives.items()}
    nearest = min(begins, key=lambda start: abs(begins[start] - EVENT))
    braking = drives[CUED].braking
    there = (motion.time >= braking.start) & (motion.time <= braking.end)
    rate, limit = float(np.max(np.abs(motion.tilt_rate_deg[there]))), _tilt_rate()
    far, radius = float(np.max(np.abs(motion.position[there]))), load("thesis").circle or np.nan
    error, whole = (float(np.sqrt(np.mean((motion.felt - motion.wanted)[on] ** 2))) for on in (there, ...))
    return (
        Claim(
            text="At around 80 s the car brakes hard from high speed",
            holds=abs(begins[nearest] - EVENT) <= NEAR,
            figures="the braking that takes most speed away begins at "
            + ", ".join(f"{t:.1f} s ({start})" for start, t in begins.items()),
        ),
        Claim(
            text="There the tilt rate reaches its limit",
            holds=rate >= 0.999 * limit,
            figures=f"up to {rate:.2f} of {limit:g} deg/s",
        ),
        Claim(
            text="There the displacement extends to its threshold and stays inside the limit circle",
            holds=0.95 * radius <= far <= radius,
            figures=f"up to {far:.3f} of {radius:g} m",
        ),
        Claim(
            text="There the reference is tracked worse than over the lap",
            holds=error > whole,
            figures=f"RMSE {error:.2f} there, {whole:.2f} m/s² over the lap",
        ),
    )


def _tilt_rate() -> float:
    """Return the thesis's limit of the pitch rate [deg/s]."""
    return load("thesis").tilt_coordination.pitch_degps


def _brakings(answers: Answers) -> Grid:
    rows: list[tuple[Cell, ...]] = []
    for start, job in DRIVES.items():
        one: Driven = answers[job]
        stretch, speeds = one.braking, (3.6 * one.braking.fast, 3.6 * one.braking.slow)
        rows.append((start, float(one.time[-1]), stretch.start, stretch.end, *speeds, one.harshest))
    header = ("lap [s]", "braking begins [s]", "ends [s]", "from [km/h]", "to [km/h]")
    return Grid(
        title="The braking that takes most speed away, and the instant of the lowest acceleration",
        header=("lap", *header, "lowest at [s]"),
        rows=tuple(rows),
    )
