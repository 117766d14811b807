"""The program `otolith`: its commands, and how it fails."""

import os
import sys

# Small matrices: more BLAS threads only wait for each other. Read when numpy is first imported.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import typer  # noqa: E402
from rich.console import Console  # noqa: E402

from otolith.cli import (  # noqa: E402
    bench,
    catalog,
    drive,
    explicit,
    hint,
    misled,
    omct,
    platform,
    reproduce,
    run,
    tune,
)
from otolith.core.errors import OtolithError  # noqa: E402

app = typer.Typer(
    name="otolith",
    help="Motion cueing for driving simulators: run, compare and judge cueing algorithms.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("list")(catalog.list_)
app.command("run")(run.run)
app.command("compare")(run.compare)
app.command("drive")(drive.drive_)
app.command("map")(misled.map_)
app.command("reproduce")(reproduce.reproduce_)
app.command("tune")(tune.tune_)
app.command("omct")(omct.omct_)
app.command("bench")(bench.bench_)
app.command("warmup")(bench.warmup)
app.add_typer(explicit.app, name="explicit")
app.add_typer(hint.app, name="hint")
app.add_typer(platform.app, name="platform")


def main(arguments: list[str] | None = None) -> None:
    """Run the program; an error of the user's is one sentence on standard error and exit code 2.

    `--debug` anywhere on the line shows the traceback as well.
    """
    line = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in line
    line = [word for word in line if word != "--debug"]
    console = Console(stderr=True)
    try:
        app(line)
    except OtolithError as error:
        if debug:
            console.print_exception()
        console.print(f"otolith: {error}", style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(2)
    except KeyboardInterrupt:
        console.print("otolith: interrupted, nothing half-written was left")
        sys.exit(130)
