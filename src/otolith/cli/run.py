"""`otolith run` and `otolith compare`: close the loop, judge it, and write the results."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from rich.console import Console

from otolith import files, registry
from otolith.cli.loop import Cued, Prepared, prepare, report_interventions, simulate_all, simulate_one
from otolith.cli.optimum import LONGEST, Yardstick
from otolith.cli.options import CUEING_HELP, RunOptions, with_run_options
from otolith.cli.output import Force, Jobs, file_name, print_json, screen, sentence
from otolith.cli.results import (
    Figures,
    Json,
    Out,
    figures_of,
    today,
    write_account,
    write_all,
    write_figures,
)
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.core.jobs import number_of_jobs
from otolith.loop import Run
from otolith.report.ranking import criteria, criterion_named, standings

if (
    TYPE_CHECKING
):  # plotting is imported only when something is drawn, so that invalid input is refused at once
    from matplotlib.figure import Figure

    from otolith.report.ranking import Criterion, Standing

    Contest = Mapping[str, tuple[Sequence[Run], Mapping[str, Any]]]

_COMPARED: Final = ", ".join(registry.COMPARED)
BEYOND: Final = 3  # exit code of --strict
WORTH: Final = 300.0  # [s] of drives, cued by one algorithm, that are worth the start of a process

Tuning = Annotated[
    str | None,
    typer.Option(help="Tuning of the washouts: a shipped name or a file (default: the platform's own)."),
]
Strict = Annotated[
    bool,
    typer.Option(
        "--strict", help=f"Exit with code {BEYOND}, after all is written, if a hard limit was passed."
    ),
]
Best = Annotated[
    bool | None,
    typer.Option(
        "--optimum/--no-optimum",
        help="Find the best that is possible, and measure by it "
        f"(default: for drives of at most {LONGEST:g} s).",
    ),
]


@with_run_options
def run(
    choices: RunOptions,
    cueing: Annotated[str, typer.Option(help=CUEING_HELP)] = "predictive",
    tuning: Tuning = None,
    optimum: Best = None,
    out: Out = None,
    figures: Figures = False,
    force: Force = False,
    strict: Strict = False,
    json: Json = False,
) -> None:
    """Cue one scenario, or a recorded drive, and write run.h5, summary.json and report.html."""
    console = screen()
    prepared = prepare([choices], [cueing], tuning, console)
    folder = out or Path("out") / f"{file_name(prepared.scenarios[0].name)}-{file_name(cueing)}"
    files.check_folder(folder, command="run", force=force)
    yardstick = Yardstick(prepared, optimum, console)
    with (
        files.whole_folder(folder, command="run", force=force) as made,
        files.run_file(made / "run.h5") as keep,
    ):
        result = simulate_one(prepared, console, cueing, keep)
        summary = write_account(result, made, best=yardstick.best(0, cueing), figures=figures)
    _print_results(summary if json else None, [summary], folder, console)
    _judge([summary], strict)


@with_run_options
def compare(
    choices: RunOptions,
    more: Annotated[list[str] | None, typer.Argument(metavar="MORE", help="Further scenarios.")] = None,
    cueing: Annotated[
        list[str] | None,
        typer.Option(help=f"{CUEING_HELP} Repeat to compare (default: {_COMPARED})."),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            help="What is ranked by: " + ", ".join(criteria()) + " (default: rmse, or rate for yaw alone)."
        ),
    ] = None,
    tuning: Tuning = None,
    optimum: Best = None,
    out: Out = None,
    figures: Figures = False,
    jobs: Jobs = None,
    force: Force = False,
    strict: Strict = False,
    json: Json = False,
) -> None:
    """Cue scenarios, or a recorded drive, with several algorithms, rank them and say by which rule."""
    console = screen()
    dofs = dofs_named(choices.dofs.split(","))
    by = by or ("rate" if all(dof.feels_rate for dof in dofs) else "rmse")
    criterion = criterion_named(by, [dof.name for dof in dofs])
    scenarios = [choices.scenario, *(more or [])]
    names = cueing or list(registry.COMPARED)
    _refuse_twice("SCENARIO", scenarios)
    _refuse_twice("--cueing", [file_name(name) for name in names])
    each = [replace(choices, scenario=name) for name in scenarios]
    prepared = prepare(each, names, tuning, console)
    compared = "-".join(file_name(scenario.name) for scenario in prepared.scenarios)
    folder = out or Path("out") / f"{compared}-compared"
    files.check_folder(folder, command="compare", force=force)
    processes = _worth(jobs, prepared)
    yardstick = Yardstick(prepared, optimum, console)
    with files.whole_folder(folder, command="compare", force=force) as made, ExitStack() as stack:
        cued = _cued(prepared, made)
        summaries_of = simulate_all(prepared, console, cued, jobs=processes)
        runs = [stack.enter_context(files.open_run(one.path)) for one in cued]
        for result in runs:
            report_interventions(result.interventions, console)
        of_each = range(0, len(cued), len(names))  # the runs of a scenario follow each other
        account, summaries, ranked = write_contest(
            made,
            [runs[i : i + len(names)] for i in of_each],
            yardstick,
            (by, criterion),
            figures=figures,
            known=[summaries_of[i : i + len(names)] for i in of_each],
        )
    every = [summary for of_one in summaries.values() for summary in of_one.values()]
    _print_results(account if json else None, every, folder, console)
    for one in ranked:
        console.print(_place(one, ranked), highlight=False, soft_wrap=True)
    _judge(every, strict)


def write_contest(
    folder: Path,
    runs: Sequence[Sequence[Run]],
    yardstick: Yardstick,
    by: tuple[str, "Criterion"],
    *,
    figures: bool = False,
    known: Sequence[Sequence[dict[str, Any]]] | None = None,
) -> tuple[dict[str, Any], Mapping[str, Mapping[str, Any]], Sequence["Standing"]]:
    """Write the account of runs of several algorithms, grouped by scenario.

    Parameters
    ----------
    known : the key figures of the runs, grouped alike, without the optimum; None if they are to be computed.

    Returns
    -------
    What summary.json holds, the key figures by scenario and algorithm, and the ranking.
    """
    from otolith import metrics

    known = known or [[metrics.summarise(run) for run in of_one] for of_one in runs]
    contest = {}
    for k, (of_one, figures_of_one) in enumerate(zip(runs, known, strict=True)):
        accounts = {
            run.cueing: metrics.with_best(summary, run, yardstick.best(k, run.cueing))
            for run, summary in zip(of_one, figures_of_one, strict=True)
        }
        contest[of_one[0].scenario] = of_one, metrics.against_baseline(accounts)
    best = {of_one[0].scenario: yardstick.drawn(k) for k, of_one in enumerate(runs)}
    summaries = {scenario: of_one for scenario, (_, of_one) in contest.items()}
    ranked = standings(summaries, by[1])
    account = _write_comparison(folder, contest, by, ranked, best)
    if figures:
        write_figures(folder, _contest_figures(contest, best))
    return account, summaries, ranked


def _cued(prepared: Prepared, folder: Path) -> list[Cued]:
    """Return the runs of a comparison and their files, by scenario."""
    several = len(prepared.scenarios) > 1
    runs = []
    for k, scenario in enumerate(prepared.scenarios):
        for own in prepared.plants:
            name = f"{file_name(scenario.name)}-{file_name(own)}" if several else file_name(own)
            runs.append(Cued(k, own, folder / f"{name}.h5"))
    return runs


def _worth(jobs: int | None, prepared: Prepared) -> int:
    """Return the number of processes: unless asked, each has work for longer than it takes to start."""
    seconds = sum(scenario.duration for scenario in prepared.scenarios) * len(prepared.plants)
    return number_of_jobs(jobs, most=int(seconds / WORTH))


def _refuse_twice(option: str, names: Sequence[str | None]) -> None:
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(option, f"{twice} twice", "given once each")


def _write_comparison(
    folder: Path,
    contest: "Contest",
    by: tuple[str, "Criterion"],
    ranked: Sequence["Standing"],
    best: Mapping[str, Run | None],
) -> dict[str, Any]:
    """Write page and key figures of a comparison; return the key figures."""
    from otolith import report

    name, criterion = by
    if len(contest) > 1:
        summaries = {scenario: of_one for scenario, (_, of_one) in contest.items()}
        ranking = [one.as_json() for one in ranked]
        summary: dict[str, Any] = {"ranked_by": name, "ranking": ranking, "scenarios": summaries}
        page = report.render_contest(contest, by=criterion, date=today(), best=best)
    else:
        ((only, account),) = contest.values()
        summary = dict(account)
        page = report.render_comparison(
            only, summary, by=criterion, date=today(), best=best[only[0].scenario]
        )
    write_all(folder, summary, page)
    return summary


def _contest_figures(contest: "Contest", best: Mapping[str, Run | None]) -> dict[str, "Figure"]:
    """Return one figure per scenario and degree of freedom, and of several scenarios the overview, by file
    name.
    """
    from otolith.report import comparison_figure, overview_figure

    if len(contest) == 1:
        ((name, (only, _)),) = contest.items()
        return figures_of(only[0].dofs, lambda dof: comparison_figure(only, dof, best=best[name]))
    figures = {"figure": overview_figure({name: of_one for name, (_, of_one) in contest.items()})}
    for scenario, (runs, _) in contest.items():
        for dof in runs[0].dofs:
            figures[f"figure-{file_name(scenario)}-{dof}"] = comparison_figure(runs, dof, best=best[scenario])
    return figures


def _print_results(
    json_value: object | None, summaries: list[dict[str, Any]], folder: Path, console: Console
) -> None:
    if json_value is not None:
        print_json(json_value)
    for summary in summaries:
        console.print(sentence(summary), highlight=False, soft_wrap=True)
    console.print(
        f"written to {folder}: report.html, summary.json, run data", highlight=False, soft_wrap=True
    )


def _judge(summaries: Sequence[dict[str, Any]], strict: bool) -> None:
    """Exit with a code of its own if --strict was given and some run passed a hard limit."""
    if strict and any(summary["violations"] for summary in summaries):
        raise typer.Exit(BEYOND)


def _place(one: "Standing", ranked: Sequence["Standing"]) -> str:
    """Return the place of one algorithm in one line, with ties."""
    tied = sum(other.mean_rank == one.mean_rank for other in ranked) > 1
    several = len(one.ranks) > 1
    where = f"mean rank {one.mean_rank:.2f}, {one.wins} wins" if several else f"rank {one.ranks[0]}"
    broken = sum(one.broken)
    return f"{one.cueing}: {where}{', tied' if tied else ''}" + (
        f"; hard limits passed at {broken:,} nodes" if broken else ""
    )
