"""`otolith rerun`: repeat a run from its file, and compare the two."""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from otolith import __version__, files
from otolith.cli.output import Force, print_json, progress_bar, screen, warn
from otolith.cli.results import Figures, write_account
from otolith.core.errors import InputError
from otolith.experiment import Experiment, differences
from otolith.metrics.against_best import NOT_COMPUTED

DIFFERENT = 1  # exit code


def rerun(
    run: Annotated[Path, typer.Argument(metavar="RUN.H5", help="A run of 'otolith run' or 'compare'.")],
    cueing: Annotated[
        str | None, typer.Option(help="Your own algorithm again: module:attribute or file.py:attribute.")
    ] = None,
    log: Annotated[Path | None, typer.Option(help="The drive, if it is no longer where it was.")] = None,
    road: Annotated[
        Path | None, typer.Option(help="The earlier drive, if it is no longer where it was.")
    ] = None,
    law: Annotated[
        Path | None, typer.Option(help="The explicit law, if it is no longer where it was.")
    ] = None,
    hint: Annotated[Path | None, typer.Option(help="The hint, if it is no longer where it was.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results (default: none are written).")] = None,
    figures: Figures = False,
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Make a run again from its file, and say whether it is equal bit for bit."""
    console = screen()
    if out is None and figures:
        raise InputError("--figures", "given without --out, the folder that they would be in", "left out")
    with files.open_run(run) as result:
        if out is not None:
            files.check_folder(out, command="rerun", force=force)
        experiment = Experiment.of(result, cueing=cueing, log=log, road=road, law=law, hint=hint)
        if result.settings["version"] != __version__:
            warn(console, f"the run was made by version {result.settings['version']}, this is {__version__}")
        with _folder(out, force) as folder, files.run_file(folder / "run.h5") as keep:
            with progress_bar(console, f"{result.cueing} on {result.scenario}") as progress:
                again = experiment.run(progress=progress, keep=keep)
            differ = differences(result, again)
            if out is not None:
                write_account(again, folder, best=NOT_COMPUTED, figures=figures)
    if out is not None:
        console.print(f"written to {out}: report.html, summary.json, run data", soft_wrap=True)
    if json:
        print_json({"run": str(run), "equal": not differ, "differ": differ})
    verdict = f"differs in {', '.join(differ)}" if differ else "equal bit for bit, times left out"
    console.print(f"{run}: {verdict}", soft_wrap=True)
    if differ:
        raise typer.Exit(DIFFERENT)


@contextlib.contextmanager
def _folder(out: Path | None, force: bool) -> Iterator[Path]:
    """Yield the folder of the results while it is made, or one that vanishes if none are to be written."""
    if out is None:
        with tempfile.TemporaryDirectory(prefix="otolith-") as folder:
            yield Path(folder)
        return
    with files.whole_folder(out, command="rerun", force=force) as made:
        yield made
