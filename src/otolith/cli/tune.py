"""`otolith tune`: the best settings of an algorithm for a platform and a drive; constant washout weights."""

import functools
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer
from rich.console import Console
from rich.table import Table

from otolith import files, registry
from otolith.cli.options import RunOptions, with_run_options
from otolith.cli.output import Jobs, described_bar, print_json, screen, warn, working
from otolith.core.errors import InputError
from otolith.core.jobs import number_of_jobs
from otolith.scenarios import Scenario, scenario
from otolith.tuning import TRAVEL_PRICE, Tuned, tune

if TYPE_CHECKING:  # imported on use: a study needs an extra, and constant weights none
    from otolith.cueing.design import Design
    from otolith.studies import tune as studies
    from otolith.studies.search import Progress

WORTH: Final = 3000.0  # [s] of drives to cue that are worth the start of a process
WEIGHTS: Final = 40  # evaluations of constant weights, by default
SETTINGS: Final = 80  # trials of an algorithm's settings, by default
_CELLS: Final = {"tracking": 4, "travel": 3, "peak": 3}  # measures that are printed, with their digits
TABLE_5_3: Final = (
    "sine-0.5",
    "sine-1",
    "sine-2",
    "combined",
    "step-0.5",
    "step-1",
    "step-2",
    "step-sine-0.5",
    "step-sine-1",
)


@with_run_options
def tune_(
    choices: RunOptions,
    more: Annotated[
        list[str] | None,
        typer.Argument(metavar="MORE", help="Further scenarios (default: those of Table 5.3, unless --log)."),
    ] = None,
    cueing: Annotated[
        str | None,
        typer.Option(help="Tune this algorithm: classical, optimal, predictive, implicit or hybrid-all."),
    ] = None,
    tuning: Annotated[
        str | None,
        typer.Option(help="Tuning with which a washout begins: a shipped name or a file (the platform's)."),
    ] = None,
    on: Annotated[
        str, typer.Option(metavar="STATE,...", help="Without --cueing: states to weigh.")
    ] = "velocity,position",
    evaluations: Annotated[
        int | None, typer.Option(help="How many settings are tried (80), or weights without --cueing (40).")
    ] = None,
    price: Annotated[float, typer.Option(help="Price of travel in reaches.")] = TRAVEL_PRICE,
    out: Annotated[
        Path | None, typer.Option(help="File of the tuning that is found (default: out/tuned-CUEING.toml).")
    ] = None,
    also: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE", help="A further drive to tune on and to judge on, as --log; repeatable."
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(help="Draw before and after to this file, on what was held out (.png, .pdf)."),
    ] = None,
    jobs: Jobs = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Find the settings of an algorithm that serve a platform and a drive best, and what they cost.

    With --cueing: the end of each drive (--log, --also) is held out; only what is better there is taken.
    Without: constant washout weights of the implicit MPC for scenarios.
    """
    names = [name for name in (choices.scenario, *(more or [])) if name is not None]
    if cueing is None:
        _refuse_what_weights_ignore(choices, tuning=tuning, out=out, figure=figure, also=also)
        _weights(choices.platform, names or list(TABLE_5_3), on, evaluations or WEIGHTS, price, jobs, json)
        return
    design = _design(choices, cueing, tuning)
    references = _references(choices, names, also or [], design)
    found = _settings(choices, cueing, design, references, evaluations or SETTINGS, price, jobs)
    _tell(found, choices, names, out or Path("out") / f"tuned-{cueing}.toml", figure, json)


def _design(choices: RunOptions, cueing: str, tuning: str | None) -> "Design":
    """Return the design with the settings to begin with."""
    from otolith.studies.spaces import started

    registry.check_options([cueing], choices.given | ({"tuning"} if tuning is not None else frozenset()))
    design = choices.design()
    if tuning is not None:
        design = replace(design, washout=files.read_tuning(tuning))
    return started(cueing, design)


def _settings(
    choices: RunOptions,
    cueing: str,
    design: "Design",
    references: Mapping[str, list[Scenario]],
    evaluations: int,
    price: float,
    jobs: int | None,
) -> "studies.Tuned":
    """Tune the settings of an algorithm."""
    from otolith.studies import tune as studies
    from otolith.studies.executors import Processes
    from otolith.studies.jobs import TRAINING

    study = studies.study_for(cueing, design, evaluations, references[TRAINING])
    with described_bar(screen(), "preparing; kernels are compiled on first use") as progress:

        def tell(now: "Progress") -> None:
            progress(f"{now.text}; {now.per_hour:,.0f} loops/h", now.share)

        return studies.tuned(
            study,
            design,
            choices.plant or registry.cueing_named(cueing).plant,
            references,
            lambda problems: Processes(number_of_jobs(jobs), problems),
            price=price,
            progress=tell,
        )


def _references(
    choices: RunOptions, names: list[str], also: list[Path], design: "Design"
) -> dict[str, list[Scenario]]:
    """Return what is trained on, and what is held out, which is a part of every drive or nothing."""
    from otolith.studies.jobs import JUDGING, TRAINING
    from otolith.studies.tune import pieces

    note = functools.partial(warn, screen())
    if choices.log is None:
        if also:
            raise InputError("--also", also[0], "given with --log FILE, a first drive")
        chosen = [replace(choices, scenario=name) for name in names or TABLE_5_3]
        return {TRAINING: [one.wanted().along(design, note=note) for one in chosen], JUDGING: []}
    if names:
        raise InputError("the reference", "given twice", "either scenarios or --log FILE")
    drives = [replace(choices, log=path) for path in (choices.log, *also)]
    parts = [pieces(one.wanted().along(design, note=note), design.dofs) for one in drives]
    return {
        TRAINING: [piece for trained, _ in parts for piece in trained],
        JUDGING: [piece for _, held_out in parts for piece in held_out],
    }


def _tell(
    found: "studies.Tuned", choices: RunOptions, names: list[str], out: Path, figure: Path | None, json: bool
) -> None:
    """Print and write what was found."""
    from otolith.studies.export import tuning_text

    console = screen()
    about = f"{'as it was before' if found.kept else 'tuned by'} otolith tune for {choices.platform}"
    text = tuning_text(found.design, found.after.settings, about)
    if text:
        files.write_text(out, text)
    if figure is not None:
        _draw(found, figure, console)
    if json:
        print_json(found.as_json())
    else:
        screen(stderr=False, wide=True).print(_settings_grid(found))
        screen(stderr=False, wide=True).print(_cost_grid(found))
    for words in _verdict(found):
        console.print(words, highlight=False, soft_wrap=True)
    console.print(_command(found, choices, names, out if text else None), highlight=False, soft_wrap=True)


def _verdict(found: "studies.Tuned") -> Iterator[str]:
    """Say whether the settings were taken, why, and how far that can be trusted."""
    from otolith.studies.jobs import JUDGING, TRAINING

    held_out = [found.measured(one, JUDGING) for one in (found.before, found.best)]
    if found.kept:
        then, now = ("-" if one is None else f"{one['tracking']:.4f}" for one in held_out)
        tried = f"of {len(found.trials)} settings tried"
        better = f"the best {tried} have an error of {now} on what was held out, these of {then}"
        if found.best.number == found.before.number:
            better = f"none {tried} are better within the limits"
        yield f"the settings to begin with stay: {better}"
    elif held_out[1] is None:
        yield "nothing was held out, so this holds for what they were tuned on; --log FILE holds out a part"
    if found.limited:
        return
    used = [found.measured(found.after, kind) for kind in (TRAINING, JUDGING)]
    most = max(one["peak"] for one in used if one is not None)
    if most > 0.0:
        strong = f"a drive with {1.0 / most:.2g} times the forces may pass one"
        yield f"{found.study.cueing} does not know the limits: {strong}; --also FILE tunes on more drives"


def _command(found: "studies.Tuned", choices: RunOptions, names: list[str], tuning: Path | None) -> str:
    """Return the command that uses the settings."""
    from otolith.studies.settings import options

    tuned = options(found.after.settings) if tuning is None else [f"--tuning {shlex.quote(str(tuning))}"]
    replaced = {"--cueing", *(words.split()[0] for words in tuned)}
    replaced |= {"--horizon", "--blocks"} if replaced & {"--horizon", "--blocks"} else set()
    words = ["otolith run", *([] if choices.log else [(names or TABLE_5_3)[0]])]
    words += [f"--cueing {found.study.cueing}"]
    words += [shlex.join(option) for option in choices.as_typed() if option[0] not in replaced]
    words += tuned
    return " ".join(words)


def _draw(found: "studies.Tuned", path: Path, console: Console) -> None:
    """Draw the motion before and after on what was held out, or else on the first reference."""
    from otolith.report import comparison_figure, save_figure
    from otolith.studies.jobs import Job, closed

    files.check_file(path, *files.PICTURES)
    with working(console, "drawing before and after"):
        problem = found.shown
        runs = [
            replace(closed(problem, Job(tuple(one.settings.items()), 0)), cueing=f"{problem.cueing}, {name}")
            for name, one in (("before", found.before), ("tuned", found.after))
        ]
        drawn = comparison_figure(runs, runs[0].dofs[0])
        files.write_figure(path, lambda temporary: save_figure(drawn, temporary))
    console.print(f"drawn to {path}", highlight=False, soft_wrap=True)


def _settings_grid(found: "studies.Tuned") -> Table:
    grid = Table("setting", "before", _name_of_best(found))
    for name, value in found.best.settings.items():
        grid.add_row(name, f"{found.before.settings[name]:.4g}", f"{value:.4g}")
    return grid


def _cost_grid(found: "studies.Tuned") -> Table:
    """Return error, travel and limits before and after, on what was trained on and held out."""
    from otolith.studies.jobs import JUDGING, TRAINING

    grid = Table(
        "",
        "RMSE / RMS wanted",
        "share of the reach, p99",
        "share of a limit, largest",
        "decisions beyond limits",
        "tilt noticed",
    )
    for kind, words in ((TRAINING, "trained on"), (JUDGING, "held out")):
        for name, trial in (("before", found.before), (_name_of_best(found), found.best)):
            measured = found.measured(trial, kind)
            if measured is not None:
                shares = (f"{100.0 * measured[name]:.1f} %" for name in ("violations", "noticed"))
                cells = (f"{measured[name]:.{digits}f}" for name, digits in _CELLS.items())
                grid.add_row(f"{words}, {name}", *cells, *shares)
    return grid


def _name_of_best(found: "studies.Tuned") -> str:
    return "best tried" if found.kept else "tuned"


def _refuse_what_weights_ignore(choices: RunOptions, **others: object) -> None:
    """Refuse options that are read with --cueing only."""
    given = [name for name, value in others.items() if value is not None]
    shared = {one.name for one in fields(RunOptions)} - {"scenario", "platform"}
    for name in (*sorted(choices.given & shared), *given):
        raise InputError(f"--{name.replace('_', '-')}", "given", "used together with --cueing")


def _weights(
    platform: str, names: list[str], on: str, evaluations: int, price: float, jobs: int | None, json: bool
) -> None:
    """Find constant washout weights of the implicit MPC."""
    console = screen()
    described = files.read_platform(platform)
    chosen = [scenario(name) for name in names]
    seconds = evaluations * sum(one.duration for one in chosen)
    processes = number_of_jobs(jobs, most=int(seconds / WORTH))
    with described_bar(console, "preparing") as progress:
        found = tune(
            described,
            [state.strip() for state in on.split(",")],
            chosen,
            evaluations=evaluations,
            price=price,
            jobs=processes,
            progress=lambda count, J: progress(
                f"{count} of at most {evaluations}: J = {J:.4f}", min(count / evaluations, 1.0)
            ),
        )
    if json:
        print_json(found.as_json())
    else:
        screen(stderr=False, wide=True).print(_grid(found))
    options = " ".join(f"--weight {state}={value:.4g}" for state, value in found.weights.items())
    console.print(f"J = {found.objective:.4f}; otolith run … {options}", highlight=False, soft_wrap=True)


def _grid(found: Tuned) -> Table:
    grid = Table("scenario", "RMSE [m/s²]", "travel RMS [m]", title_justify="left")
    for name, (rmse, travel) in found.by_scenario.items():
        grid.add_row(name, f"{rmse:.4f}", f"{travel:.4f}")
    return grid
