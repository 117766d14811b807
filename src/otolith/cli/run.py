"""`otolith run` and `otolith compare`: close the loop, judge it, write the results."""

import functools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from matplotlib.figure import Figure
from rich.console import Console

from otolith import __version__, files, metrics, registry
from otolith.cli.options import Choices, dofs_named, takes_choices, warn
from otolith.cli.output import print_json, progress_bar, sentence
from otolith.mpc.design import Design
from otolith.platforms.supervisor import Intervention
from otolith.report import (
    MEASURES,
    Standing,
    comparison_figure,
    cueing_figure,
    measure_named,
    overview_figure,
    render,
    render_comparison,
    render_contest,
    save_figure,
    standings,
)
from otolith.simulate import Run, simulate

BEYOND: Final = 3  # exit code of --strict
_TOLD = 5  # interventions of a supervisor that are told one by one

Out = Annotated[Path | None, typer.Option(help="Folder for the results (default: out/SCENARIO-CUEING).")]
Tuning = Annotated[
    str | None,
    typer.Option(help="Tuning of the washouts: a shipped name or a file (default: the platform's own)."),
]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]
Strict = Annotated[
    bool,
    typer.Option(
        "--strict", help=f"Exit with code {BEYOND}, after all is written, if a hard limit was passed."
    ),
]


@takes_choices
def run(
    choices: Choices,
    cueing: Annotated[str, typer.Option(help="A name of 'otolith list cueing'.")] = "hybrid-all",
    tuning: Tuning = None,
    out: Out = None,
    strict: Strict = False,
    json: Json = False,
) -> None:
    """Cue one scenario, or a recorded drive, and write run.h5, summary.json, report.html and figures."""
    console = Console(stderr=True)
    ((result,),) = _simulate_all([choices], [cueing], tuning, console)
    summary = metrics.summarise(result)
    folder = out or Path("out") / f"{_file_name(result.scenario)}-{cueing}"
    files.write_run(result, folder / "run.h5")
    page = render(result, summary, date=_today())
    _write(folder, summary, page, _figures(result.dofs, lambda dof: cueing_figure(result, dof)))
    _tell(summary if json else None, [summary], folder, console)
    _judge([summary], strict)


@takes_choices
def compare(
    choices: Choices,
    more: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENARIO]...", help="Further scenarios.")
    ] = None,
    cueing: Annotated[
        list[str] | None, typer.Option(help="An algorithm; repeat to compare (default: the thesis's four).")
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            help="What is ranked by: " + ", ".join(MEASURES) + " (default: rmse, or rate for yaw alone)."
        ),
    ] = None,
    tuning: Tuning = None,
    out: Out = None,
    strict: Strict = False,
    json: Json = False,
) -> None:
    """Cue scenarios, or a recorded drive, with several algorithms, rank them and say by which rule."""
    console = Console(stderr=True)
    pairs, singles = dofs_named(choices.dofs)
    by = by or ("rate" if singles == ("yaw",) and not pairs else "rmse")
    measure = measure_named(by, [pair.name for pair in pairs] + list(singles))
    each = [replace(choices, scenario=name) for name in dict.fromkeys([choices.scenario, *(more or [])])]
    runs = _simulate_all(each, list(dict.fromkeys(cueing or registry.FOUR_MODELS)), tuning, console)
    contest = {of_one[0].scenario: (of_one, metrics.compare(of_one)) for of_one in runs}
    summaries = {scenario: of_one for scenario, (_, of_one) in contest.items()}
    several = len(contest) > 1
    folder = out or Path("out") / f"{'-'.join(map(_file_name, contest))}-compared"
    for scenario, (of_one, _) in contest.items():
        for result in of_one:
            name = f"{_file_name(scenario)}-{result.cueing}" if several else result.cueing
            files.write_run(result, folder / f"{name}.h5")
    ranked = standings(summaries, measure)
    said: dict[str, Any] = {
        "ranked_by": by,
        "ranking": [one.as_json() for one in ranked],
        "scenarios": summaries,
    }
    if several:
        page, figures = render_contest(contest, by=measure, date=_today()), _contest_figures(contest)
    else:
        ((only, said),) = contest.values()
        page = render_comparison(only, said, by=measure, date=_today())
        figures = _figures(only[0].dofs, lambda dof: comparison_figure(only, dof))
    _write(folder, said, page, figures)
    every = [summary for of_one in summaries.values() for summary in of_one.values()]
    _tell(said if json else None, every, folder, console)
    for one in ranked:
        console.print(_place(one, ranked), highlight=False, soft_wrap=True)
    _judge(every, strict)


def _simulate_all(
    each: Sequence[Choices], names: Sequence[str], tuning: str | None, console: Console
) -> list[list[Run]]:
    """Check everything the user said, then close the loop once per scenario and algorithm."""
    first, makers = each[0], [registry.lookup(registry.CUEING, "--cueing", name) for name in names]
    plants = [first.plant or maker.plant for maker in makers]
    plant_makers = [registry.lookup(registry.PLANTS, "--plant", plant) for plant in plants]
    status = console.status("preparing")
    design = first.design(status.update)
    for name in names:
        registry.check_cueing(name, design.singles)
    if tuning is not None:
        design = replace(design, washout=files.read_tuning(tuning))
    wanted = [(choices, choices.reference(design, console)) for choices in each]
    runs: list[list[Run]] = [[] for _ in each]
    for name, plant, plant_maker in zip(names, plants, plant_makers, strict=True):
        status.update(f"preparing {name}; kernels are compiled on first use (10 to 30 s), then cached")
        with status:
            dead_time = plant_maker.load()(design.platform).dead_time
            cueing = registry.make_cueing(name, design, dead_time=dead_time)
        for done, (choices, scenario) in zip(runs, wanted, strict=True):
            moved = plant_maker.load()(design.platform)
            with progress_bar(console, f"{name} on {scenario.name}") as progress:
                run = simulate(
                    cueing,
                    moved,
                    scenario,
                    platform=design.platform,
                    pairs=tuple(pair.name for pair in design.pairs),
                    singles=design.singles,
                    names=(name, plant),
                    settings=_settings(choices, design, tuning),
                    preview=design.implicit.horizon if choices.preview else 0,
                    progress=progress,
                )
            _tell_interventions(getattr(moved, "interventions", ()), console)
            done.append(run)
    return runs


def _tell_interventions(found: Sequence[Intervention], console: Console) -> None:
    """The longest ones, in their order, and how many there were besides."""
    longest = sorted(found, key=lambda one: one.start - one.end)[:_TOLD]
    for intervention in sorted(longest, key=lambda one: one.start):
        warn(console, f"supervisor, {intervention}")
    if len(found) > _TOLD:
        warn(console, f"supervisor, {len(found) - _TOLD} shorter interventions besides")


def _settings(choices: Choices, design: Design, tuning: str | None) -> dict[str, Any]:
    """What was chosen, so that it can be run again."""
    chosen = {"version": __version__, **choices.as_settings(design)}
    return chosen if tuning is None else {**chosen, "tuning": tuning}


def _figures(dofs: Sequence[str], draw: Callable[[str], Figure]) -> dict[str, Figure]:
    """One figure per axis pair and per axis on its own, by file name."""
    return {"figure" if len(dofs) == 1 else f"figure-{dof}": draw(dof) for dof in dofs}


def _contest_figures(contest: Mapping[str, tuple[Sequence[Run], Mapping[str, Any]]]) -> dict[str, Figure]:
    """The overview, and one figure per scenario and degree of freedom, by file name."""
    figures = {"figure": overview_figure({name: of_one for name, (_, of_one) in contest.items()})}
    for scenario, (runs, _) in contest.items():
        for dof in runs[0].dofs:
            figures[f"figure-{_file_name(scenario)}-{dof}"] = comparison_figure(runs, dof)
    return figures


def _write(folder: Path, summary: dict[str, Any], page: str, figures: dict[str, Figure]) -> None:
    """Summary, page, and figures by file name."""
    files.write_json(folder / "summary.json", summary)
    files.write_text(folder / "report.html", page)
    for name, figure in figures.items():
        for ending in ("pdf", "png"):
            files.write_figure(folder / f"{name}.{ending}", functools.partial(save_figure, figure))


def _tell(json_value: object | None, summaries: list[dict[str, Any]], folder: Path, console: Console) -> None:
    if json_value is not None:
        print_json(json_value)
    for summary in summaries:
        console.print(sentence(summary), highlight=False, soft_wrap=True)
    console.print(
        f"written to {folder}: report.html, figures, summary.json, run data", highlight=False, soft_wrap=True
    )


def _judge(summaries: Sequence[dict[str, Any]], strict: bool) -> None:
    """End with an exit code of its own where --strict was given and some run passed a hard limit."""
    if strict and any(summary["violations"] for summary in summaries):
        raise typer.Exit(BEYOND)


def _place(one: Standing, ranked: Sequence[Standing]) -> str:
    """One algorithm's place in one line, ties said."""
    tied = sum(other.mean_rank == one.mean_rank for other in ranked) > 1
    several = len(one.ranks) > 1
    where = f"mean rank {one.mean_rank:.2f}, {one.wins} wins" if several else f"rank {one.ranks[0]}"
    broken = sum(one.broken)
    return f"{one.cueing}: {where}{', tied' if tied else ''}" + (
        f"; hard limits passed at {broken:,} nodes" if broken else ""
    )


def _today() -> str:
    return datetime.now().astimezone().date().isoformat()


def _file_name(text: str) -> str:
    """A scenario's name as part of a path: nothing but letters, digits, dot, dash and underscore."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "scenario"
