"""Unwanted cues where drivers complain of them: in a long bend, in braking to a stop, in both, and on a lap.

    python benchmarks/unwanted_cues.py [--only WORDS] [--json FILE] [--figure FILE] [--jobs N]

Every algorithm cues every situation in 2, 4 and 6 DOF, on the ideal plant and on six legs; the tables are
those of docs/which-cueing.md. Of several forces, times and counts are summed, peaks are the largest, doses
and errors are root sums of squares.

An exclamation mark stands where a hard limit of the machine was broken, or, on legs, where their supervisor
had to hold them back: such a run asks for more than its machine can do, and is compared with none. On legs
the MPCs read what the same machine can do in every combination (`davsi-4dof`), except in 6 DOF, since that
file says nothing of heave and yaw. The washouts read no limits, and keep the tuning that is shipped for the
machine.
"""

import argparse
import json
import math
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt

import otolith
from otolith import files, registry
from otolith.metrics import unwanted_cues
from otolith.metrics.measure import root_sum_square
from otolith.report import palette
from otolith.vehicle import Driver, drive, load_car, road

Figures = dict[str, float]

WASHOUTS: Final = ("classical", "adaptive", "optimal", "optimal-nonlinear")
ALL: Final = (*WASHOUTS, "linear-mpc", "implicit", "predictive")
DRAWN: Final = {"classical": palette.BLUE, "implicit": palette.VERMILION, "predictive": palette.GREEN}
LAP: Final = 60.0  # [s] of the lap
FORCES: Final = (otolith.SURGE_PITCH, otolith.SWAY_ROLL)
SIX: Final = (*FORCES, otolith.HEAVE, otolith.YAW)


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What is to be felt, along which axes, and on what it is cued."""

    wanted: str  # "bend", "stop", "both" or "lap"
    dofs: tuple[otolith.Dof, ...]
    machine: str  # a platform, and "ideal" or "hexapod"

    @property
    def title(self) -> str:
        """How a table names it."""
        return f"{self.wanted}, {2 * min(len(self.dofs), 2) + max(len(self.dofs) - 2, 0)} DOF, {self.machine}"

    def platform(self, name: str) -> otolith.Platform:
        """What an algorithm reads of the machine."""
        of, plant = self.machine.split()
        all_at_once = plant == "hexapod" and len(self.dofs) <= len(FORCES) and name not in WASHOUTS
        return otolith.platform("davsi-4dof" if all_at_once else of)

    def reference(self, design: otolith.Design, lap: Path) -> otolith.Scenario:
        """What is to be felt: the bend along y, the stop along x, both of them, or the lap."""
        if self.wanted == "lap":
            whole = otolith.Wanted(log=lap, through="telban").along(design)
            return replace(whole, duration=min(whole.duration, LAP))
        bend, stop = otolith.scenario("bend", axis="lateral"), otolith.scenario("stop")
        return {"bend": bend, "stop": stop, "both": stop.combined_with(bend)}[self.wanted]


TABLES: Final = {
    "unwanted: s (of it rebound), peak m/s²": "{unwanted_s:.2f} ({rebound_s:.2f}), {unwanted_peak:.2f}",
    "RMSE m/s², dose m/s^1.5": "{rmse:.3f}, {dose:.2f}",
    "turns against, neutral crossings": "{turns:.0f}, {crossings:.0f}",
    "held by the legs' supervisor: s, yaw rate error: deg/s": "{held_s:.2f}, {yaw_degps:.1f}",
}
ONE_AXIS: Final = ("thesis ideal", "davsi ideal", "davsi hexapod")
SITUATIONS: Final = (
    *(Situation(wanted="bend", dofs=FORCES[1:], machine=machine) for machine in ONE_AXIS),
    *(Situation(wanted="stop", dofs=FORCES[:1], machine=machine) for machine in ONE_AXIS),
    *(Situation(wanted="both", dofs=FORCES, machine=machine) for machine in ONE_AXIS[::2]),
    *(Situation(wanted="lap", dofs=FORCES, machine=machine) for machine in ONE_AXIS[::2]),
    *(Situation(wanted="lap", dofs=SIX, machine=machine) for machine in ONE_AXIS[1:]),
)


def cued(situation: Situation, name: str, lap: Path) -> otolith.Run:
    """One algorithm in one situation."""
    platform = situation.platform(name)
    design = otolith.Design(platform=platform, dofs=situation.dofs)
    plant = registry.make_plant(situation.machine.split()[1], platform)
    return otolith.simulate(
        registry.make_cueing(name, design, dead_time=plant.dead_time),
        plant,
        situation.reference(design, lap),
        platform=platform,
        dofs=tuple(dof.name for dof in situation.dofs),
    )


def in_short(summary: dict[str, Any], *, legs: bool) -> Figures:
    """The numbers of a table's row, from a run's summary."""
    cues = summary["unwanted_cues"].values()
    passed = sum(
        one["nodes_beyond"] for one in summary["limits"].values() if not (one["comfort"] or one["soft"])
    )
    held = sum(one["seconds"] for one in summary["supervisor"].values())
    return {
        **{f"{kind}_s": sum(one[kind]["duration_s"] for one in cues) for kind in ("lag", "rebound")},
        **{f"{kind}_peak": max(one[kind]["peak"] for one in cues) for kind in ("lag", "rebound")},
        "unwanted_s": sum(one[kind]["duration_s"] for one in cues for kind in one),
        "unwanted": sum(one[kind]["duration_s"] * one[kind]["mean"] for one in cues for kind in one),
        "unwanted_peak": max(one[kind]["peak"] for one in cues for kind in one),
        "turns": sum(summary["turns_against"].values()),
        "crossings": sum(summary["neutral_crossings"].values()),
        "rmse": summary["rmse"],
        "yaw_degps": math.degrees(sum(summary.get("rate_rmse", {}).values())),
        "dose": root_sum_square(summary["sickness_dose"]),
        "held_s": held,
        "failed": sum(summary["status"].values()) - summary["status"].get("decided", 0),
        "broken": float(held > 0.0 if legs else passed > 0),
    }


def show(found: dict[str, dict[str, Figures]]) -> None:
    """Print the tables, a situation in a row, and how the default stands against the washouts in each."""
    for head, cell in TABLES.items():
        print(f"\n| {head} | " + " | ".join(ALL) + " |")
        print("|" + "---|" * (len(ALL) + 1))
        for title, of in found.items():
            print(
                f"| {title} | " + " | ".join(cell.format(**of[name]) + mark(of[name]) for name in ALL) + " |"
            )
    print()
    for title, of in found.items():
        print(f"{title}: {verdict(of)}")


def mark(one: Figures) -> str:
    """What stands behind a cell."""
    return (" !" if one["broken"] else "") + (f" ({one['failed']:.0f} failed)" if one["failed"] else "")


def verdict(found: dict[str, Figures]) -> str:
    """How the default stands against the best washout of each figure, among those that broke nothing."""
    kept = [name for name in WASHOUTS if not found[name]["broken"]]
    if not kept:
        return "No washout stayed within what the machine can do."
    parts = []
    for key, words in (("unwanted_s", "duration"), ("unwanted_peak", "peak"), ("unwanted", "integral")):
        best = min(kept, key=lambda name: found[name][key])
        ours, theirs = found["predictive"][key], found[best][key]
        ratio = f"{ours / theirs:.2f} of" if theirs > 0.0 else f"{ours:.2f} against none of"
        parts.append(f"{words} {ratio} {best}'s")
    return "Unwanted cues of predictive: " + ", ".join(parts) + "."


def draw(situations: tuple[Situation, ...], path: Path) -> None:
    """What is wanted and felt in some situations of one axis, and below it when cues lag and rebound."""
    figure, axes = plt.subplots(
        2, len(situations), figsize=(9.0, 4.4), height_ratios=(3, 1), sharex="col", layout="constrained"
    )
    for (force, bars), situation in zip(axes.T, situations, strict=True):
        axis = situation.dofs[0].felt
        runs = {name: cued(situation, name, Path()) for name in DRAWN}
        wanted = runs["predictive"]
        force.plot(
            wanted.time, wanted.reference_force[:, axis], color=palette.GREY, linewidth=3, label="wanted"
        )
        for row, (name, run) in enumerate(runs.items()):
            force.plot(run.time, run.felt_force[:, axis], color=DRAWN[name], label=name)
            for kind, color in (("lag", palette.ORANGE), ("rebound", "black")):
                spans = [(c.start, c.duration) for c in unwanted_cues(run) if c.kind == kind]
                bars.broken_barh(spans, (row - 0.35, 0.7), color=color, label="_" * row + kind)
        force.set_title(situation.title, fontsize=9)
        bars.set_yticks(range(len(runs)), labels=runs)
        bars.set_ylim(len(runs) - 0.5, -0.5)
        bars.set_xlabel("time [s]")
    axes[0, 0].set_ylabel("specific force [m/s²]")
    axes[0, 0].legend(fontsize=8)
    axes[1, 0].legend(fontsize=8, loc="lower left")
    figure.savefig(path, dpi=140)


def _work(job: tuple[Situation, str, Path]) -> Figures:
    situation, *_ = job
    return in_short(otolith.summarise(cued(*job)), legs="hexapod" in situation.machine)


def main() -> None:
    """Run all, print the tables, and beside them how far it is."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", help="situations whose title holds this, e.g. 'bend, 2 DOF'")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path, help="picture of the bend and the stop, as in the docs")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    situations = [one for one in SITUATIONS if chosen.only in one.title]
    found: dict[str, dict[str, Figures]] = {}
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(chosen.jobs) as pool:
        lap = Path(folder) / "lap.csv"
        files.write_lap(drive(road("hockenheim").limited(120 / 3.6), load_car(), Driver()), lap)
        for situation in situations:
            jobs = [(situation, name, lap) for name in ALL]
            found[situation.title] = dict(zip(ALL, pool.map(_work, jobs), strict=True))
            print(situation.title, file=sys.stderr)
    show(found)
    if chosen.figure:
        draw(tuple(one for one in SITUATIONS if one.title.endswith("2 DOF, davsi ideal")), chosen.figure)
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
