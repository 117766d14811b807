"""The program `otolith`: its commands, and how it fails."""

import os
import sys
from importlib import import_module
from typing import Any, Final

# Small matrices: more BLAS threads only wait for each other. Read when numpy is first imported.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import typer  # noqa: E402
from rich.console import Console  # noqa: E402

from otolith.core.errors import OtolithError  # noqa: E402

# Where a command or a group of them is, and its line of help. A module is imported when its command is
# called: none waits for what another needs.
COMMANDS: Final = {
    "list": (
        "catalog:list_",
        "List cueing algorithms, perception models, plants, platforms, roads, scenarios or solvers.",
    ),
    "run": (
        "run:run",
        "Cue one scenario, or a recorded drive, and write run.h5, summary.json, report.html and figures.",
    ),
    "compare": (
        "run:compare",
        "Cue scenarios, or a recorded drive, with several algorithms, rank them and say by which rule.",
    ),
    "drive": (
        "drive:drive_",
        "Drive a road and write specific force, rates and pose, with a map; `otolith run --log` cues it.",
    ),
    "log": ("log:app", "Recorded drives: see what is understood of a file, and save how it is read."),
    "map": ("misled:map_", "Show false cues on the map of the drive, and where the worst of them are."),
    "explicit": ("explicit:app", "Explicit laws: build, verify, show, export."),
    "hint": ("hint:app", "Hints for the implicit MPC: learn offline, verify."),
    "platform": ("platform:app", "Look at a platform's legs, and fit legs to a data sheet."),
    "omct": (
        "omct:omct_",
        "Drive one axis at a time at twelve frequencies: modulus and phase of what is felt (ICAO 9625).",
    ),
    "tune": (
        "tune:tune_",
        "Find constant washout weights of the implicit MPC that track the scenarios with little travel.",
    ),
    "reproduce": (
        "reproduce:reproduce_",
        "Compute tables and figures of the thesis again, and put the published numbers beside ours.",
    ),
    "bench": (
        "bench:bench_",
        "Time one full real-time-iteration step of every QP engine on the same recorded problems.",
    ),
    "warmup": (
        "bench:warmup",
        "Compile and cache now what the implicit MPC and the hybrids need in 2 and 4 DOF; --all: the rest.",
    ),
}


def program(called: str) -> typer.Typer:
    """The command line, of which one command is imported and the others are names with a line of help."""
    app = typer.Typer(
        name="otolith",
        help="Motion cueing for driving simulators: run, compare and judge cueing algorithms.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    for name, (target, line) in COMMANDS.items():
        command = imported(target) if name == called else _uncalled
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
        else:
            app.command(name, help=line if command is _uncalled else None)(command)
    return app


def imported(target: str) -> Any:
    """A command, or group of commands, of this package by "module:attribute"."""
    module, attribute = target.split(":")
    return getattr(import_module(f"otolith.cli.{module}"), attribute)


def _uncalled() -> None:
    raise AssertionError("only the command that is called is run, and that one is imported")


def main(arguments: list[str] | None = None) -> None:
    """Run the program; an error of the user's is one sentence on standard error and exit code 2.

    `--debug` anywhere on the line shows the traceback as well.
    """
    line = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in line
    line = [word for word in line if word != "--debug"]
    console = Console(stderr=True)
    try:
        program(line[0] if line else "")(line)
    except OtolithError as error:
        if debug:
            console.print_exception()
        console.print(f"otolith: {error}", style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(2)
    except KeyboardInterrupt:
        console.print("otolith: interrupted, nothing half-written was left")
        sys.exit(130)
