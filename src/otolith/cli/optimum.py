"""`otolith optimum`: the best that a platform can do for a drive, to measure algorithms by."""

import functools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from otolith import files, registry
from otolith.cli.options import RunOptions, with_run_options
from otolith.cli.output import Force, file_name, print_json, screen, sentence, warn, working
from otolith.cli.run import Json, Out, write_results
from otolith.core.errors import InputError
from otolith.loop import Run

if TYPE_CHECKING:
    from otolith.cueing.optimum import Optimum

_WITHIN_REACH = 0.02  # of the RMS of what is wanted: less is a perfect answer, but for jumps


@with_run_options
def optimum(choices: RunOptions, out: Out = None, force: Force = False, json: Json = False) -> None:
    """Find the best motion for a scenario or a drive that is known as a whole, and write it as a run.

    No algorithm that has to decide without knowing the future can do better within the same limits.
    """
    console = screen()
    _refuse_what_it_ignores(choices)
    design = choices.design()
    scenario = choices.wanted().along(design, note=functools.partial(warn, console))
    folder = out or Path("out") / f"{file_name(scenario.name)}-optimum"
    files.check_folder(folder, command="optimum", force=force)
    from otolith.cueing.optimum import optimum as solve

    with working(console, "solving; the solver is compiled on first use (some 10 s), then cached"):
        found = solve(design.platform, design.dofs, scenario)
    summary = write_results(found.run, folder, command="optimum", force=force)
    if json:
        print_json(summary)
    console.print(sentence(summary), highlight=False, soft_wrap=True)
    certified = f"certified to {found.certificate.worst:.1e} after {found.iterations} steps"
    console.print(f"{certified}; written to {folder}", highlight=False, soft_wrap=True)


def _refuse_what_it_ignores(choices: RunOptions) -> None:
    """Refuse options of algorithms and plants, which would have no effect."""
    read = frozenset().union(*(entry.reads for entry in registry.CUEING.own.values())) | {"plant"}
    for option in sorted(choices.given & read):
        word = f"--{option.replace('_', '-')}"
        raise InputError(word, "given, but the optimum would ignore it", "left out")


def report_distances(found: "Optimum", runs: Sequence[Run], console: Console) -> None:
    """Print how far every run is from the best that is possible."""
    from otolith import metrics

    best = metrics.summarise(found.run)
    for run in runs:
        console.print(
            f"{run.cueing} on {run.scenario}: {distance(metrics.summarise(run), best)}",
            highlight=False,
            soft_wrap=True,
        )


def distance(summary: dict[str, Any], best: dict[str, Any]) -> str:
    """How far a run is from the optimum, in words, for every axis that is cued."""
    figures = [("rmse_per_pair", 1.0, ".4f", "m/s²"), ("rate_rmse", math.degrees(1.0), ".3f", "deg/s")]
    parts = []
    for key, scale, digits, unit in figures:
        for dof, least in best.get(key, {}).items():
            error, wanted = (scale * one[name][dof] for one, name in ((summary, key), (best, "wanted_rms")))
            if scale * least <= _WITHIN_REACH * wanted:
                parts.append(f"{dof} {error:{digits}} {unit}, where a perfect answer is within reach")
            else:
                ratio = f"{error / (scale * least):.2f} times the best that is possible"
                parts.append(f"{dof} {ratio} ({scale * least:{digits}} {unit})")
    return "; ".join(parts)
