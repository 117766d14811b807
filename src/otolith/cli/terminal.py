"""`otolith terminal`: sets in which a platform's axes can always stay are found, proved and tried."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from otolith import files
from otolith.cli.output import described_bar, group, print_json, screen
from otolith.core.errors import InputError
from otolith.cueing.mpc.rows import parse_braking_rows
from otolith.cueing.mpc.settings import check_period
from otolith.cueing.mpc.terminal import TerminalSets, digest
from otolith.safety.invariant.certificate import Judgement
from otolith.safety.invariant.trial import Trial

app = group("Sets of motions that a platform need never leave: build, verify.")
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]
Braking = Annotated[
    str, typer.Option(help="Braking rows that the sets keep: stopping, leading, position, printed or none.")
]
Period = Annotated[float, typer.Option(help="Time between two decisions [s].")]


@app.command()
def build(
    platform: Annotated[
        str, typer.Argument(metavar="PLATFORM", help="A shipped platform's name or a platform file (.toml).")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="File to write to (default: NAME-terminal.h5)."),
    ] = None,
    braking: Braking = "stopping",
    period: Period = 0.01,
    json: Json = False,
) -> None:
    """Find the set of every axis, with a command for each of its vertices that leads back inside."""
    path = out or Path(f"{Path(platform).stem}-terminal.h5")
    files.check_file(path, ".h5")
    sets = _found(platform, braking, period)
    files.write_sets(sets, path)
    judged = sets.check()
    if json:
        print_json(_account(sets, judged, {}))
    _tell(sets, judged, {})
    screen().print(f"written to {path}", soft_wrap=True)
    if not _passed(judged, {}):
        sys.exit(1)


@app.command()
def verify(
    sets: Annotated[
        str,
        typer.Argument(metavar="FILE|PLATFORM", help="A file of 'otolith terminal build', or a platform."),
    ],
    states: Annotated[int, typer.Option(min=0, help="Random states of each axis to be driven.")] = 100_000,
    steps: Annotated[int, typer.Option(min=1, help="Periods that each is driven for.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    platform: Annotated[
        str | None, typer.Option(metavar="PLATFORM", help="Platform to which a FILE has to belong.")
    ] = None,
    braking: Annotated[str | None, typer.Option(help="As of build; a FILE says it itself.")] = None,
    period: Annotated[float | None, typer.Option(help="As of build; a FILE says it itself.")] = None,
    json: Json = False,
) -> None:
    """Check every certificate anew, then let adversaries drive random states; exit code 1 if one fails."""
    if sets.endswith(".h5"):
        _refuse({"--braking": braking, "--period": period}, "left out, for the file says it itself")
        found = _read(Path(sets), platform)
    else:
        _refuse({"--platform": platform}, "left out where no file is verified")
        found = _found(sets, braking or "stopping", 0.01 if period is None else period)
    judged, tried = found.check(), {}
    if states:
        with described_bar(screen(), "compiling; the machine code is then cached") as progress:
            tried = found.tried(states=states, steps=steps, seed=seed, progress=progress)
    if json:
        print_json(_account(found, judged, tried))
    _tell(found, judged, tried)
    if not _passed(judged, tried):
        sys.exit(1)


def _refuse(options: dict[str, object], bound: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise InputError(name, value, bound)


def _read(path: Path, platform: str | None) -> TerminalSets:
    """The sets of a file, which belong to the platform of that name if one is given."""
    sets = files.read_sets(path)
    if platform is not None and digest(wanted := files.read_platform(platform)) != sets.digest:
        bound = f"{digest(wanted)[:12]}…, that of {wanted.name}"
        raise InputError(f"SHA-256 of the platform in {path}", f"{sets.digest[:12]}…", bound)
    return sets


def _found(platform: str, braking: str, period: float) -> TerminalSets:
    check_period("--period", period)
    return TerminalSets.of(files.read_platform(platform), parse_braking_rows(braking), period=period)


def _passed(judged: dict[str, Judgement], tried: dict[str, Trial]) -> bool:
    return all(one.passed for one in judged.values()) and all(one.passed for one in tried.values())


def _account(sets: TerminalSets, judged: dict[str, Judgement], tried: dict[str, Trial]) -> dict[str, Any]:
    proofs = {
        name: {**asdict(one), "ahead": sets.ahead(name), "passed": one.passed} for name, one in judged.items()
    }
    trials = {name: {**asdict(one), "passed": one.passed} for name, one in tried.items()}
    of = {"platform": sets.platform.name, "platform_sha256": sets.digest, "braking": sets.braking.value}
    model = {"lag": sets.lag, "period": sets.period}
    return {**of, **model, "passed": _passed(judged, tried), "proofs": proofs, "trials": trials}


def _tell(sets: TerminalSets, judged: dict[str, Judgement], tried: dict[str, Trial]) -> None:
    console = screen(wide=True)
    proofs = Table(box=None, pad_edge=False)
    for head in (
        "axis",
        "ahead [s]",
        "facets",
        "vertices",
        "shrinks by",
        "beyond",
        "missing",
        "strays",
        "refused",
        "",
    ):
        proofs.add_column(head, justify="left" if head in ("axis", "") else "right", no_wrap=True)
    for name, one in judged.items():
        counts = (
            one.facets,
            one.vertices,
            f"{1.0 - one.shrink:.1e}",
            one.beyond,
            one.missing,
            one.strays,
            one.refused,
        )
        cells = [name, f"{sets.ahead(name):.3f}", *map(str, counts), "proved" if one.passed else "NOT PROVED"]
        proofs.add_row(*cells)
    console.print(proofs)
    if not tried:
        return
    trials = Table(box=None, pad_edge=False)
    for head in (
        "driven",
        "states",
        "periods",
        "without command",
        "outside",
        "farthest",
        "between nodes",
        "",
    ):
        trials.add_column(head, justify="left" if head in ("driven", "") else "right", no_wrap=True)
    for name, trial in tried.items():
        cells = [str(trial.states), str(trial.steps), str(trial.infeasible), str(trial.violations)]
        cells += [f"{trial.outermost:.6f}", f"{trial.between:.6f}", "passed" if trial.passed else "FAILED"]
        trials.add_row(name, *cells)
    console.print(trials)
