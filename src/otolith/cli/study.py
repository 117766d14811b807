"""`otolith study`: search settings at scale, go on with a search, look at it, and use what it found."""

import json as json_text
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from otolith import files
from otolith.cli.output import Jobs, described_bar, file_name, group, print_json, screen, working
from otolith.cli.stop import Stopped
from otolith.core.errors import InputError
from otolith.core.jobs import number_of_jobs
from otolith.experiment import Experiment
from otolith.studies.definition import Objective, Study, load_study, parse_study
from otolith.studies.export import command, from_here, reference_of, settings_text, table, tuning_text
from otolith.studies.jobs import TRAINING, work
from otolith.studies.measures import MEASURES
from otolith.studies.problem import Prepared, problem_of
from otolith.studies.results import State, Trial, allowed, best_of, front, preset_of, values

if TYPE_CHECKING:  # imported on use: it needs an extra
    from otolith.studies.executors import Executor
    from otolith.studies.search import Progress
    from otolith.studies.store import Store

app = group("Studies: search settings over many drives, on the cores of this machine or on a cluster.")

LOCAL: Final = "local"
Where = Annotated[str, typer.Argument(metavar="STORE", help="A file of 'study run', or a database's URL.")]
Name = Annotated[str | None, typer.Option(help="Which study, if a database holds several.")]
Trials = Annotated[
    int | None, typer.Option(help="How many settings are tried, in place of the study's number.")
]
Address = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="ADDRESS",
        help="A Dask scheduler, as in tcp://host:8786, or local: processes of Dask on this machine.",
    ),
]
Preset = Annotated[str | None, typer.Option(help="A preset of the study; default: all objectives alike.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]


@app.command()
def run(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="A shipped study's name, or a file (.toml).")],
    store: Annotated[
        str | None, typer.Option(help="Where results go: a new file, or a database's URL (out/NAME.journal).")
    ] = None,
    trials: Trials = None,
    seed: Annotated[int | None, typer.Option(help="Of what is random, in place of the study's.")] = None,
    jobs: Jobs = None,
    cluster: Address = None,
) -> None:
    """Begin a study and run it to its end; it can be interrupted at any time."""
    from otolith.studies.store import Store

    known, folder = _read(study)
    known = _with_budget(known, trials=trials, seed=seed)
    console = screen()
    prepared = _prepare(known, folder, console)
    where = store or str(Path("out") / f"{file_name(known.name)}.journal")
    definition = {
        "study": known.model_dump(mode="json"),
        "folder": str(folder.resolve()),
        "digest": prepared.digest,
    }
    with (
        _executor(prepared, jobs, cluster) as executor,
        Store.create(where, known.name, len(known.objectives), definition) as opened,
    ):
        _search(prepared, opened, executor, console)


@app.command()
def resume(
    store: Where, name: Name = None, trials: Trials = None, jobs: Jobs = None, cluster: Address = None
) -> None:
    """Go on with a study that was interrupted, or give it more trials."""
    from otolith.studies.store import Store

    console = screen()
    with Store.open(store, name, write=True) as opened:
        known = _with_budget(_study(opened), trials=_tried(opened) if trials is None else trials)
        if trials is not None and trials < (tried := len(opened.frozen())):
            raise InputError("--trials", trials, f"at least {tried}, which have been begun")
        prepared = _prepare(known, Path(opened.definition["folder"]), console)
        if prepared.digest != opened.definition["digest"]:
            bound = "as when the study began: results on other ones cannot be compared"
            raise InputError("platform, drives or version", "changed", bound)
        if trials is not None:
            opened.note("trials", trials)
        with _executor(prepared, jobs, cluster) as executor:
            _search(prepared, opened, executor, console)


@app.command()
def show(
    store: Where,
    name: Name = None,
    page: Annotated[
        Path | None, typer.Option(help="Write a page (.html): what costs what, presets, their commands.")
    ] = None,
    json: Json = False,
) -> None:
    """Say how far a study is, and what it found: the settings that no others beat."""
    from otolith.studies.store import Store

    with Store.open(store, name) as opened:
        study, trials, agreed = _study(opened), opened.trials(), opened.noted("agreement")
        of = _tried(opened) or study.budget.trials
    found = front(study, trials)
    counts = {state.value: sum(trial.state is state for trial in trials) for state in State}
    early = f", {counts['pruned']} ended early" if counts["pruned"] else ""
    said = f"{study.name}: {counts['done']} of {of} trials done{early}, {counts['rejected']} rejected"
    if page is not None:
        checked = "" if agreed is None else f"; {_agreed(agreed)}"
        _write_page(page, store, study, trials, f"{said}{checked}")
    if json:
        print_json(
            {
                "study": study.name,
                "trials": {"of": of, **counts},
                "agreement": agreed,
                "front": [_as_json(study, trial) for trial in found],
            }
        )
        return
    screen(stderr=False, wide=True).print(_grid(study, found))
    console = screen()
    _say(console, said)
    _say(console, f"{len(found)} trials that no other beats within the constraints")
    if agreed is not None:
        _say(console, _agreed(agreed))


@app.command()
def best(store: Where, name: Name = None, preset: Preset = None, json: Json = False) -> None:
    """Print the best settings, how they were judged, and the command that uses them."""
    from otolith.studies.store import Store

    with Store.open(store, name) as opened:
        study, trials = from_here(_study(opened), opened.definition["folder"]), opened.trials()
    chosen = preset_of(study, trials, preset) if preset else best_of(study, trials)
    if json:
        print_json(_as_json(study, chosen))
        return
    grid = Table("setting", "value")
    for setting, value in chosen.settings.items():
        grid.add_row(setting, f"{value:.6g}" if isinstance(value, float) else str(value))
    out = screen(stderr=False, wide=True)
    out.print(grid)
    out.print(_grid(study, [chosen]))
    _use(study, chosen, screen())


@app.command()
def export(
    store: Where,
    out: Annotated[Path, typer.Option(help="A tuning or settings (.toml), or a table of all trials (.csv).")],
    name: Name = None,
    preset: Preset = None,
    trial: Annotated[int | None, typer.Option(help="This trial, in place of the best.")] = None,
) -> None:
    """Write the best settings as a file: of a washout a tuning for --tuning; or all trials as a table."""
    from otolith.studies.store import Store

    with Store.open(store, name) as opened:
        study, trials = _study(opened), opened.trials()
        folder = Path(opened.definition["folder"])
    files.check_file(out, ".toml", ".csv")
    console = screen()
    if out.suffix == ".csv":
        files.write_text(out, table(study, trials))
        _say(console, f"{len(trials)} trials written to {out}")
        return
    chosen = _chosen(study, trials, preset, trial)
    about = f"trial {chosen.number} of study {study.name}" + (f", {preset}" if preset else "")
    design = problem_of(study.model_copy(update={"training": (), "judging": ()}), folder).training.design
    text = tuning_text(design, {**study.fixed, **chosen.settings}, about)
    shown = from_here(study, str(folder))
    files.write_text(out, text or settings_text(shown, chosen.settings, about, reference_of(shown)))
    _say(console, f"written to {out}: {about}")
    _use(shown, chosen, console, tuning=str(out) if text else "")


@app.command()
def inverse(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run.h5 of an MPC with constant weights.")],
    on: Annotated[
        str, typer.Option(metavar="STATE,...", help="States that are weighed.")
    ] = "velocity,position",
    json: Json = False,
) -> None:
    """Recover the constant washout weights of an MPC from its motion: those whose motion is the same."""
    from otolith.studies.inverse import START, TOLD, recover

    console = screen()
    recorded = files.read_run(run)
    made = Experiment.of(recorded)
    start = {state.strip(): START for state in on.split(",")}
    with working(console, "closing the loop with candidate weights"):
        found = recover(
            recorded.pose, made.design, made.wanted.along(made.design), start, plant=made.plant_name
        )
    if json:
        print_json({**asdict(found), "intervals": found.intervals, "untold": found.untold})
        return
    grid = Table("state", "weight", "95 % interval", "relative standard error")
    for state, weight in found.weights.items():
        low, high = found.intervals[state]
        grid.add_row(state, f"{weight:.5g}", f"{low:.5g} to {high:.5g}", f"{found.spread[state]:.1g}")
    screen(stderr=False, wide=True).print(grid)
    _say(console, f"{100.0 * found.difference:.2g} % of the motion is left unexplained; {found.loops} loops")
    for state, times in found.untold.items():
        known = f"the motion does not tell the weight on {state} within {100.0 * TOLD:.0f} %"
        would = f"a record {times:.2g} times as long would, or {times**0.5:.2g} times less noise"
        _say(console, f"{known}; {would}")


def _search(prepared: Prepared, store: "Store", executor: "Executor", console: Console) -> None:
    """Do what is left, check the loop, and say what was found."""
    from otolith.studies.agreement import agreement
    from otolith.studies.search import Search

    study = prepared.study
    items = {kind: len(one.items) for kind, one in prepared.problems.items()}
    with described_bar(console, study.name) as progress:

        def tell(now: "Progress") -> None:
            progress(f"{now.text}; {now.per_hour:,.0f} loops/h", now.share)

        try:
            trials = Search(study, store, items, executor, progress=tell).run()
        except (KeyboardInterrupt, Stopped):
            _say(console, f"interrupted; otolith study resume {store.where} goes on where it is")
            raise
    rejected = [done.refused for one in trials for done in one.training.values() if done.refused]
    if rejected and not any(one.state is State.DONE for one in trials):
        found = f"0 of {len(trials)}; the first was refused ({rejected[0]})"
        raise InputError(f"trials of {study.name} that could be done", found, "at least 1")
    with working(console, "comparing a sample with the loop in Python"):
        agreed = agreement(study, prepared.training, trials)
    noted = {"loops": agreed.loops, "different": list(agreed.different)}
    store.note("agreement", noted)
    _say(console, _agreed(noted))
    _say(console, f"written to {store.where}; otolith study best {store.where}")


def _executor(prepared: Prepared, jobs: int | None, cluster: str | None) -> "Executor":
    from otolith.studies.executors import Processes

    if cluster is None:
        return Processes(number_of_jobs(jobs), prepared.problems)
    if jobs is not None and cluster != LOCAL:
        raise InputError("--jobs", jobs, f"left out with --cluster {cluster}, whose workers are its own")
    from otolith.studies.cluster import Cluster

    return Cluster(cluster, prepared.problems, workers=number_of_jobs(jobs))


def _read(name: str) -> tuple[Study, Path]:
    """Return a study by name or path, and the folder to which its paths are relative."""
    path = Path(name)
    if path.suffix != ".toml":
        return load_study(name), Path.cwd()
    return parse_study(files.read_text(path, "study"), path.name), path.parent


def _with_budget(study: Study, **changed: int | None) -> Study:
    given = {name: value for name, value in changed.items() if value is not None}
    for name, value in given.items():
        if value < (0 if name == "seed" else 1):
            raise InputError(f"--{name}", value, "at least 0" if name == "seed" else "at least 1")
    return study.model_copy(update={"budget": study.budget.model_copy(update=given)})


def _prepare(study: Study, folder: Path, console: Console) -> Prepared:
    """Read what the study names, and compile what is missing, once for all processes."""
    with working(console, "preparing; kernels are compiled on first use (10 to 30 s), then cached"):
        prepared = problem_of(study, folder)
        for number, start in enumerate(study.start):
            from otolith.studies.jobs import Job

            timeless = replace(prepared.training, timeout_s=None)  # compiling takes long, once
            done = work({TRAINING: timeless}, (TRAINING, Job(tuple(start.items()), 0)))
            if done.refused:
                found = f"refused ({done.refused})"
                raise InputError(f"start.{number} of {study.name}", found, "settings that can be tried")
    return prepared


def _study(store: "Store") -> Study:
    return Study.model_validate_json(json_text.dumps(store.definition["study"]))


def _tried(store: "Store") -> int | None:
    """Return the number of trials that the last `resume` was given."""
    given = store.noted("trials")
    return None if given is None else int(given)


def _chosen(study: Study, trials: list[Trial], preset: str | None, number: int | None) -> Trial:
    if number is None:
        return preset_of(study, trials, preset) if preset else best_of(study, trials)
    if preset is not None:
        raise InputError("--preset", preset, "left out with --trial")
    if not 0 <= number < len(trials):
        raise InputError("--trial", number, f"between 0 and {len(trials) - 1}")
    return trials[number]


def _use(study: Study, trial: Trial, console: Console, tuning: str = "") -> None:
    needs = any(name.startswith("tuning.") for name in (*study.fixed, *study.parameters))
    text = command(study, trial.settings, reference_of(study), tuning or ("tuned.toml" if needs else ""))
    if needs and not tuning:
        _say(console, "otolith study export … --out tuned.toml writes the tuning")
    _say(console, text)


def _grid(study: Study, trials: list[Trial]) -> Table:
    names = [one.measure for one in study.objectives]
    grid = Table("trial", *names, *(f"{name}, judged" for name in names if study.judging))
    for trial in trials:
        row = [f"{value:.4f}" for value in values(study, trial.training)]
        if study.judging:
            sound = trial.judging and not any(done.refused for done in trial.judging.values())
            row += [f"{value:.4f}" for value in values(study, trial.judging)] if sound else ["-"] * len(names)
        grid.add_row(str(trial.number), *row)
    return grid


def _write_page(path: Path, store: str, study: Study, trials: list[Trial], said: str) -> None:
    """Write the page of a study."""
    from otolith.report.study import Best, Found, render_study

    files.check_file(path, ".html")
    sound = [values(study, one.training) for one in trials if allowed(study, one)]
    best = [
        Best(
            number=one["trial"],
            values=tuple(one["training"].values()),
            judged=tuple(one["judging"].values()) if one["judging"] else None,
            settings={k: f"{v:.6g}" if isinstance(v, float) else str(v) for k, v in one["settings"].items()},
        )
        for one in (_as_json(study, trial) for trial in front(study, trials))
    ]
    presets = {name: preset_of(study, trials, name).number for name in study.presets if best}
    found = Found(
        name=study.name,
        description=study.description,
        objectives={one.measure: _in_words(one) for one in study.objectives},
        tried=np.array(sound).reshape(-1, len(study.objectives)),
        best=tuple(best),
        presets=presets,
        commands={
            name: f"otolith study export {store} --preset {name} --out {name}.toml" for name in presets
        },
        said=said,
    )
    files.write_text(path, render_study(found))


def _in_words(objective: Objective) -> str:
    measure = MEASURES[objective.measure]
    unit = f" [{measure.unit}]" if measure.unit else ""
    return f"{measure.words}{unit}, {objective.over} of all references"


def _as_json(study: Study, trial: Trial) -> dict[str, Any]:
    names = [one.measure for one in study.objectives]
    judged = trial.judging and not any(done.refused for done in trial.judging.values())
    return {
        "trial": trial.number,
        "settings": dict(trial.settings),
        "training": dict(zip(names, values(study, trial.training), strict=True)),
        "judging": dict(zip(names, values(study, trial.judging), strict=True)) if judged else None,
    }


def _agreed(found: dict[str, Any]) -> str:
    different = found["different"]
    if different:
        return f"NOT equal to the loop in Python: {'; '.join(different)}"
    return f"{found['loops']} loops of a sample are equal, bit for bit, to those of the loop in Python"


def _say(console: Console, text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)
