"""The program `otolith`: its commands, and how it reports errors."""

import gc
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Annotated, Any, Final, NoReturn

# Matrices are small, so more BLAS threads only wait for each other. numpy reads this on its first import.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import typer  # noqa: E402
from rich.console import Console  # noqa: E402

from otolith.cli import plugins  # noqa: E402
from otolith.cli.given import refuse_lost  # noqa: E402
from otolith.core.errors import OtolithError  # noqa: E402
from otolith.core.plugins import doubtful  # noqa: E402

# Module and line of help of each command or group. A module is imported only when its command is called, so
# no command waits for what another needs.
COMMANDS: Final = {
    "list": (
        "catalog:list_",
        "List cueing algorithms, perception models, plants, platforms, roads, scenarios or solvers.",
    ),
    "example": (
        "example:example_",
        "Write files to start from: drive.csv, rig.toml, tuning.toml, and a cueing algorithm, washout.py.",
    ),
    "run": (
        "run:run",
        "Cue one scenario, or a recorded drive, and write run.h5, summary.json and report.html.",
    ),
    "compare": (
        "run:compare",
        "Cue scenarios, or a recorded drive, with several algorithms, rank them and say by which rule.",
    ),
    "optimum": (
        "optimum:optimum",
        "Find the best motion for a scenario or a drive that is known as a whole, and write it as a run.",
    ),
    "rerun": ("rerun:rerun", "Make a run again from its file, and say whether it is equal bit for bit."),
    "drive": (
        "drive:drive_",
        "Drive a road and write specific force, rates and pose, with a map; `otolith run --log` cues it.",
    ),
    "log": ("log:app", "Recorded drives: see what is understood of a file, and save how it is read."),
    "live": (
        "live:app",
        "Motion platforms in real time: drive one, play faults, record telemetry and learn its axes.",
    ),
    "commander": (
        "commander:app",
        "Build, run, watch, tune and stop a run in a browser on this machine.",
    ),
    "map": (
        "false_cue_map:map_",
        "Show false cues on the map of the drive, and where the worst of them are.",
    ),
    "export": ("export:app", "Algorithms for hosts without Python: C, an FMU, a ROS 2 package."),
    "explicit": ("explicit:app", "Explicit laws: build, verify, show, export."),
    "hint": ("hint:app", "Hints for the implicit MPC: learn offline, verify."),
    "terminal": ("terminal:app", "Sets of motions that a platform need never leave: build, verify."),
    "platform": ("platform:app", "Begin a platform file, look at a platform, and fit legs to a data sheet."),
    "omct": (
        "omct:omct_",
        "Drive one axis at a time at twelve frequencies: modulus and phase of what is felt (ICAO 9625).",
    ),
    "tune": (
        "tune:tune_",
        "Find the settings of an algorithm that serve a platform and a drive best, and what they cost.",
    ),
    "study": (
        "study:app",
        "Studies: search settings over many drives, on the cores of this machine or on a cluster.",
    ),
    "bench": (
        "bench:bench_",
        "Time one full real-time-iteration step of every QP engine on the same recorded problems.",
    ),
    "warmup": (
        "bench:warmup",
        "Compile and cache what predictive, implicit, hybrids (2, 4 DOF) and optimum need; --all: the rest.",
    ),
}


def program(called: str) -> typer.Typer:
    """Return the command line, with the called command imported and the others as names with a line of help.

    Commands of other distributions are looked up only if the called command is not one of our own.
    """
    own = called in COMMANDS
    others = {} if own else plugins.commands()
    if not own and called not in others:
        plugins.refuse_absent(called)
    app = typer.Typer(
        name="otolith",
        help="Motion cueing for driving simulators: run, compare and judge cueing algorithms. Works offline, "
        "on files: only `live run` moves a platform.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # texts are shown literally: rich would interpret [km/h] as markup
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(epilog=None if own else plugins.not_offered(COMMANDS))(_options)
    for name, (target, line) in COMMANDS.items():
        _add(app, name, imported(target) if name == called else _uncalled, line)
    for name, entry in others.items():
        if name not in COMMANDS and (name == called or name not in doubtful(plugins.GROUP)):
            _add(app, name, plugins.load(entry) if name == called else _uncalled, plugins.help_line(entry))
    return app


def _add(app: typer.Typer, name: str, command: Any, line: str) -> None:
    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name)
    else:
        app.command(name, help=line if command is _uncalled else None, short_help=line)(command)


def _options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, help="Show the version and exit.")
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="Show where an error comes from; anywhere on the line.")
    ] = False,
) -> None:
    """Declare the options of the program itself for its help; `run_program` handles both."""
    del version, debug


def imported(target: str) -> Any:
    """Import a command, or a group of commands, of this package, given as "module:attribute"."""
    module, attribute = target.split(":")
    return getattr(import_module(f"otolith.cli.{module}"), attribute)


def _uncalled() -> None:
    raise AssertionError("only the command that is called is run, and that one is imported")


def run_program(arguments: list[str] | None = None) -> None:
    """Run the program; a user's error is reported as one sentence on standard error with exit code 2.

    `--debug` anywhere on the line also shows the traceback.
    """
    line = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in line
    line = [word for word in line if word != "--debug"]
    if line == ["--version"]:
        from otolith import __version__  # no other command needs it at once

        sys.stdout.write(f"otolith {__version__}\n")
        return
    try:
        with imports_uncollected():
            command = typer.main.get_command(program(_called(line)))
        refuse_lost(command, line)
        command(line, prog_name="otolith")
    except OtolithError as error:
        _refuse(str(error), debug)
    except BrokenPipeError:  # the reader of our output, such as `head`, has closed the pipe
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(128 + signal.SIGPIPE)
    except OSError as error:
        _refuse(f"{error.filename or 'output'} could not be read or written: {error.strerror}", debug)


@contextmanager
def imports_uncollected() -> Iterator[None]:
    """Let the collector of garbage rest while a command is imported, and leave out afterwards what was made.

    What an import makes stays, so looking through it is in vain; it would take a seventh of a short command.
    """
    before = len(sys.modules)
    gc.disable()
    try:
        yield
        if len(sys.modules) > before:  # in a process that calls many commands, garbage is not left out
            gc.freeze()
    finally:
        gc.enable()


def _called(line: list[str]) -> str:
    """Return the command that is called, or that the shell wants to complete."""
    if "_OTOLITH_COMPLETE" in os.environ:
        words = os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS") or ""
        line = words.split()[1:]
    return next((word for word in line if not word.startswith("-")), "")


def _refuse(sentence: str, debug: bool) -> NoReturn:
    console = Console(stderr=True)
    if debug:
        console.print_exception()
    console.print(
        f"otolith: {_printable(sentence)}", style="red", markup=False, highlight=False, soft_wrap=True
    )
    sys.exit(2)


def _printable(sentence: str) -> str:
    """Return a sentence in one line, whatever is in the names that it quotes.

    A file's name may hold line ends, codes that steer the terminal, and bytes that are no UTF-8.
    """
    return "".join(one if one.isprintable() else one.encode("unicode_escape").decode() for one in sentence)
