"""`otolith hint`: learn offline which limits will be active, and judge the result on unseen problems."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from otolith import files
from otolith.cli.figures import write_figure
from otolith.cli.options import (
    Blocks,
    Dofs,
    Horizon,
    PlatformName,
    Washout,
    Weights,
    implicit_settings,
    pairs_named,
    washout_weights,
)
from otolith.cli.output import Force, Jobs, group, print_json, screen, warn, working
from otolith.core.frames import Dof
from otolith.core.jobs import number_of_jobs
from otolith.cueing.hints.stored import Kind, StoredHint, digest
from otolith.cueing.hints.training.build import build
from otolith.cueing.hints.training.compare import COLD, OnProgress, Tally, account, compare
from otolith.cueing.hints.training.fit import QUICK
from otolith.cueing.hints.training.manoeuvres import along, training, unseen
from otolith.cueing.hints.training.recording import record
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.rows import parse_braking_rows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform
from otolith.recordings import log_scenario
from otolith.scenarios import Scenario

app = group("Hints for the implicit MPC: learn offline, verify.")
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]
Braking = Annotated[str, typer.Option(help="Braking rows: stopping, position, printed or none.")]
SAME: float = 1e-6  # largest difference between first inputs that counts as the same answer
_HELD_OUT_SEED = 99  # seed that combines manoeuvres along the two axis pairs
_COLUMNS = ("changes", "", "", "saved %", "", "", "hits", "solves", "guess us", "step us", "", "worst 1 %")
_HEADS = ("mean", "p99", "max", "mean", "p99", "max", "share", "mean", "mean", "median", "p99", "mean")


@app.command("build")
def build_(
    out: Annotated[Path, typer.Option(help="File to write the hint to (.h5).")],
    platform: PlatformName = "thesis",
    dofs: Dofs = "surge-pitch",
    horizon: Horizon = None,
    blocks: Blocks = None,
    washout: Washout = "thesis-fit",
    weight: Weights = None,
    braking: Braking = "stopping",
    quick: Annotated[bool, typer.Option("--quick", help="Little training: to try things out.")] = False,
    jobs: Jobs = None,
    json: Json = False,
) -> None:
    """Simulate training manoeuvres on this platform with these settings, and learn from them."""
    console, processes = screen(), number_of_jobs(jobs, most=1 if quick else None)
    described, pairs = files.read_platform(platform), pairs_named(dofs)
    settings = _settings(horizon, blocks, washout_weights(washout, weight or []), braking)
    files.check_file(out, ".h5")
    with working(
        console, "preparing; kernels are compiled on first use (10 to 30 s), then cached"
    ) as progress:
        hint = build(
            described,
            pairs,
            settings,
            manoeuvres=training()[::24] if quick else None,
            effort=QUICK if quick else None,
            jobs=processes,
            progress=progress,
        )
    files.write_hint(hint, out)
    if json:
        print_json(_about(hint))
    made = hint.training
    console.print(
        f"{made['steps']} steps in {sum(made['seconds'].values()):.0f} s: a network of "
        f"{made['network_bytes'] / 1e3:.0f} kB, {made['regions']} regions, {made['entries']} entries; "
        f"model {digest(hint.model)[:12]}, written to {out}",
        highlight=False,
        soft_wrap=True,
    )


@app.command()
def verify(
    hint: Annotated[Path, typer.Argument(metavar="HINT", help="A file of 'otolith hint build'.")],
    platform: PlatformName = "thesis",
    dofs: Dofs = "surge-pitch",
    horizon: Horizon = None,
    blocks: Blocks = None,
    washout: Washout = "thesis-fit",
    weight: Weights = None,
    braking: Braking = "stopping",
    log: Annotated[
        list[Path] | None, typer.Option(help="Also judge on a recorded drive; repeatable.")
    ] = None,
    lowpass: Annotated[
        float | None, typer.Option(metavar="HZ", help="Low-pass logs at this frequency.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="One of the held-out references only.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder for hint.json and figures of the changes.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Compare every start of the solver on identical, unseen problems; exit code 1 if an answer differs."""
    console = screen()
    described, pairs = files.read_platform(platform), pairs_named(dofs)
    settings = _settings(horizon, blocks, washout_weights(washout, weight or []), braking)
    stored = files.read_hint(hint)
    stored.check(described, pairs, settings)
    if out is not None:
        files.check_folder(out, command="hint verify", force=force)
    references = {"unseen": along(unseen()[4:5] if quick else unseen(), pairs, seed=_HELD_OUT_SEED)}
    for path in log or []:
        drive = files.read_log(path, {})
        for note in drive.notes:
            warn(console, note)
        references[path.name] = [log_scenario(drive, period=settings.period, lowpass_hz=lowpass)]
    with working(console, "preparing") as progress:
        judged = {
            name: _judge(stored, (described, pairs, settings), scenarios, progress)
            for name, scenarios in references.items()
        }
    found = {name: figures for name, (figures, _) in judged.items()}
    passed = all(one["same_answer"] for one in found.values())
    document = {**_about(stored), "passed": passed, "references": found}
    if out is not None:
        with files.whole_folder(out, command="hint verify", force=force) as made:
            files.write_json(made / "hint.json", document)
            for name, (_, tallies) in judged.items():
                _draw(made / Path(name).stem, tallies)
    if json:
        print_json(document)
    for name, one in found.items():
        _print_figures(name, one)
    if not passed:
        sys.exit(1)


def _settings(horizon: int | None, blocks: str | None, weights: Any, braking: str) -> MpcSettings:
    return replace(implicit_settings(horizon, blocks, weights), braking=parse_braking_rows(braking))


def _about(hint: StoredHint) -> dict[str, Any]:
    return {"model": digest(hint.model), "training": hint.training}


def _judge(
    hint: StoredHint,
    of: tuple[Platform, tuple[Dof, ...], MpcSettings],
    scenarios: list[Scenario],
    progress: OnProgress,
) -> tuple[dict[str, Any], dict[str, Tally]]:
    platform, pairs, settings = of
    progress("recording")
    recording = record(platform, pairs, settings, scenarios, plans=True)
    hints = {kind.value: hint.at_work(kind, platform, pairs, settings) for kind in Kind}
    tallies = compare(Problem(platform, pairs, settings), recording, hints, progress)
    schemes = account(tallies, recording)
    figures = {
        "steps": len(recording),
        "unsolved": int((~recording.solved).sum()),
        "same_answer": all(one["first_input_gap"] <= SAME for one in schemes.values()),
        "schemes": schemes,
    }
    return figures, tallies


def _draw(path: Path, tallies: dict[str, Tally]) -> None:
    """Draw every initial guess but the cold one, which would need its own scale."""
    from otolith.report.changes import changes_figure

    figure = changes_figure([(name, one.changes) for name, one in tallies.items() if name != COLD])
    write_figure(path.parent, path.stem, figure)


def _print_figures(name: str, found: dict[str, Any]) -> None:
    table = Table(box=None, pad_edge=False, title=f"{name}: {found['steps']} steps", title_justify="left")
    table.add_column("scheme")
    for above, head in zip(_COLUMNS, _HEADS, strict=True):
        table.add_column(f"{above}\n{head}", justify="right", no_wrap=True)
    for scheme, one in found["schemes"].items():
        saved = one["changes_saved_percent"]
        cells = [f"{one['changes'][key]:.2f}" for key in ("mean", "p99", "max")]
        cells += [f"{saved[key]:.0f}" if key in saved else "" for key in ("mean", "p99", "max")]
        cells += [f"{one['hit_rate']:.3f}", f"{one['equality_solves']['mean']:.2f}"]
        cells += [f"{one['guess_us']['mean']:.1f}", f"{one['step_us']['median']:.1f}"]
        cells += [f"{one['step_us']['p99']:.1f}", f"{one['step_us']['worst_percent_mean']:.1f}"]
        table.add_row(scheme, *cells)
    console = screen(wide=True)
    console.print(table)
    gap = max(one["first_input_gap"] for one in found["schemes"].values())
    console.print(f"first inputs differ by at most {gap:.1e}", highlight=False)
