"""`otolith bench` and `otolith warmup`: measure step times on this machine, and compile in advance."""

import functools
import platform as machine
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from otolith import __version__, files, registry
from otolith.bench import SCENARIOS, bench, installed_peers
from otolith.cli.figures import write_figure
from otolith.cli.output import Force, print_json, screen, working
from otolith.core.frames import HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.cueing.design import Design
from otolith.cueing.optimum import optimum
from otolith.platforms import load
from otolith.scenarios import scenario

_SETS = ((SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL))
_USUAL: list[tuple[tuple[str, ...], tuple[Dof, ...]]] = [
    (("predictive", "hybrid-all"), pairs) for pairs in _SETS
]
_SENSED = ("linear-mpc", "implicit-sensed")
_ALONE = (HEAVE, YAW)
_OTHERS = [(("implicit",), _ALONE), (_SENSED, _SETS[0]), (_SENSED, (*_SETS[1], *_ALONE))]
_COLUMNS = (
    "dofs",
    "form",
    "engine",
    "steps",
    "median_us",
    "p99_us",
    "max_us",
    "certified",
    "times_faster_than_dense",
)


def bench_(
    out: Annotated[Path, typer.Option(help="Folder for bench.json and the figure.")] = Path("out/bench"),
    passes: Annotated[
        int, typer.Option(min=1, help="Passes over every recording; the least time counts.")
    ] = 3,
    quick: Annotated[bool, typer.Option("--quick", help="Two scenarios only.")] = False,
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Time one full real-time-iteration step of every QP engine on the same recorded problems."""
    files.check_folder(out, command="bench", force=force)
    console = screen()
    names = SCENARIOS[:2] if quick else SCENARIOS
    peers = installed_peers(console.print)
    with working(console, "preparing") as progress:
        found = bench(load("thesis"), _SETS, names=names, passes=passes, peers=peers, progress=progress)
    account = {
        "version": __version__,
        "machine": f"{machine.machine()}, Python {machine.python_version()}",
        "scenarios": list(names),
        "results": [figures for _, figures in found],
    }
    from otolith.report.timing import StepTimes, step_time_figure

    figure = step_time_figure(
        [StepTimes(f"{2 + 2 * t.dofs.count(',')} DOF", t.engine, t.form, t.times) for t, _ in found]
    )
    with files.whole_folder(out, command="bench", force=force) as made:
        files.write_json(made / "bench.json", account)
        write_figure(made, "bench", figure)
    if json:
        print_json(account)
    table = Table(box=None, pad_edge=False)
    for column in _COLUMNS:
        table.add_column(
            column.replace("_", " "), justify="left" if column in {"dofs", "form", "engine"} else "right"
        )
    for _, figures in found:
        cells = (figures[column] for column in _COLUMNS)
        table.add_row(*(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in cells))
    screen(wide=True).print(table)
    console.print(f"written to {out}: bench.json, bench.pdf", highlight=False, soft_wrap=True)


def warmup(
    every: Annotated[
        bool,
        typer.Option(
            "--all", help="Also heave and yaw, and the MPCs of what is sensed: linear-mpc, implicit-sensed."
        ),
    ] = False,
) -> None:
    """Compile and cache what predictive, implicit, hybrids (2, 4 DOF) and optimum need; --all: the rest."""
    console = screen()
    for names, dofs in [*_USUAL, *(_OTHERS if every else [])]:
        what = f"{', '.join(names)} in {sum(len(dof.axes) for dof in dofs)} DOF"
        design = Design(platform=load("davsi" if set(dofs) & set(_ALONE) else "thesis"), dofs=dofs)
        _prepare(what, functools.partial(_make, names, design), console)
    still = scenario("step:amplitude=0,duration=2,end=2")
    _prepare("optimum", lambda: optimum(load("thesis"), (SURGE_PITCH,), still), console)


def _make(names: Iterable[str], design: Design) -> None:
    for name in names:
        registry.make_cueing(name, design)


def _prepare(what: str, make: Callable[[], object], console: Console) -> None:
    """Do what compiles, and print how long it took."""
    started = time.perf_counter()
    with working(console, f"{what}: compiling what is not cached, up to half a minute each"):
        make()
    console.print(f"{what}: ready after {time.perf_counter() - started:.1f} s", highlight=False)
