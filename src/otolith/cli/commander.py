"""`otolith commander`: the server of the page, and what it costs."""

import contextlib
import functools
import importlib
import os
import socket
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from rich.table import Table
from rich.text import Text

from otolith.cli.durations import lasting
from otolith.cli.options import is_given
from otolith.cli.output import print_json, screen
from otolith.core.errors import InputError, MissingExtra

if TYPE_CHECKING:
    from otolith.commander.watched import Pages
    from otolith.live.session import Session
    from otolith.live.shell.supervise import Live

app = typer.Typer(
    help="Build, run, watch, tune and stop a run in a browser on this machine.",
    rich_markup_mode=None,
    invoke_without_command=True,
)
LOCAL: Final = "127.0.0.1"
PORT: Final = 8765
OLDEST: Final = 15  # of websockets
_NEEDED: Final = ("fastapi", "uvicorn", "websockets")
_INSTALL: Final = "pip install 'otolith[commander]'"
Folder = Annotated[
    Path | None,
    typer.Option(help="Folder for drives, presets and results (default: out/commander)."),
]
MOST = 1200.0  # [s] of each of three measurements, in one run of an hour
Port = Annotated[int, typer.Option(help="Port to listen on; 0 for any that is free.", min=0, max=65_535)]


@app.callback()
def commander(
    context: typer.Context,
    host: Annotated[str, typer.Option(help="Address to listen on; any other needs --token.")] = LOCAL,
    port: Port = PORT,
    token: Annotated[
        bool, typer.Option("--token", help="Answer only who opens the address that is printed, once.")
    ] = False,
    folder: Folder = None,
    browser: Annotated[bool, typer.Option("--browser", help="Open the page in a browser.")] = False,
) -> None:
    """Serve the page on this machine until Ctrl-C. A run goes on if the page, or the server, goes away."""
    if context.invoked_subcommand is not None:
        for name in ("host", "port", "token", "folder", "browser"):
            if is_given(context, name):
                raise InputError(
                    f"--{name}", f"given, but {context.invoked_subcommand} would ignore it", "left out"
                )
        return
    if host not in (LOCAL, "localhost") and not token:
        raise InputError("--host", host, f"{LOCAL}, or given with --token: others could reach this server")
    check_extra()
    from otolith.commander.keeper import keep
    from otolith.commander.security import Secrets, new_token

    console = screen(stderr=False)
    secrets = Secrets(token=new_token() if token else None)
    with listening(host, port) as socket_:
        setup = setup_for(socket_, host, folder or Path("out") / "commander", secrets)
        console.print(f"open {setup.address}", highlight=False, soft_wrap=True)
        console.print("Ctrl-C ends the Commander, and a run with it", highlight=False)
        if browser:
            webbrowser.open(setup.address)
        keep(setup, lambda text: console.print(text, highlight=False, soft_wrap=True))


def setup_for(listening: socket.socket, host: str, folder: Path, secrets: Any) -> Any:
    """Return what the keeper needs, with the functions of the command line."""
    from otolith.cli.commander_job import CommanderDesk, make_runs
    from otolith.commander.keeper import Setup

    own = folder.resolve()
    return Setup(
        prefix=f"otolith-{os.getpid()}-{listening.fileno()}",
        folder=own,
        listening=listening,
        host=host,
        secrets=secrets,
        make=functools.partial(make_runs, own),
        desk=functools.partial(CommanderDesk, own),
    )


@contextlib.contextmanager
def pages_of(live: "Live", session: "Session", port: int, tell: Callable[[str], None]) -> Iterator["Pages"]:
    """Serve the Commander beside a live session, to whoever has the address that is told.

    Its token is for a machine that others log in to: whoever has it may arm.
    """
    check_extra()
    from otolith.commander.feed import parameters_of
    from otolith.commander.keeper import Setup
    from otolith.commander.security import Secrets, new_token
    from otolith.commander.watched import own_folder, watched

    with own_folder() as folder, listening(LOCAL, port) as socket_:
        prefix = f"otolith-{os.getpid()}-page"
        secrets = Secrets(token=new_token())
        setup = Setup(
            prefix=prefix,
            folder=folder,
            listening=socket_,
            host=LOCAL,
            secrets=secrets,
            parameters=parameters_of(session),
        )
        with watched(setup, session, live.names, live.change) as pages:
            tell(f"open {setup.address}")
            yield pages


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens.

    Raises
    ------
    InputError : the address is none of this machine, or the port is taken.
    """
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host, port))
    except OSError as error:
        made.close()
        raise InputError(
            f"address {host}:{port}", f"not free ({error.strerror})", "free, or --port 0"
        ) from error
    made.listen(64)
    return made


def check_extra() -> None:
    """Refuse to start without what the server needs.

    Raises
    ------
    MissingExtra : a library is absent or too old; an old websockets breaks uvicorn while it is imported.
    """
    for name in _NEEDED:
        try:
            importlib.import_module(name)
        except ModuleNotFoundError as error:
            raise MissingExtra(f"the Commander needs {name}, which is not installed: {_INSTALL}") from error
    found = importlib.import_module("websockets.version").version
    if int(found.partition(".")[0]) < OLDEST:
        raise MissingExtra(f"websockets is {found}, must be at least {OLDEST}: {_INSTALL}")


@app.command()
def bench(
    seconds: Annotated[float, lasting("How long each measurement takes", least=2.0, most=MOST)] = 10.0,
    rounds: Annotated[int, typer.Option(help="Runs with and without clients, in turns.", min=1)] = 3,
    cueing: Annotated[str, typer.Option(help="Algorithm of the run that is watched.")] = "predictive",
    stops: Annotated[int, typer.Option(help="STOPs in a live session with a base in software.", min=2)] = 40,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Measure what the server costs, how long a STOP takes, and that pages do not disturb a run."""
    check_extra()
    from otolith.commander.bench import measure, table
    from otolith.commander.bench_live import live_table
    from otolith.commander.schema import checked
    from otolith.commander.security import Secrets

    scenario = f"sine:amplitude=0.5,frequency=0.2,duration={max(61.0, 3.0 * seconds):g}"
    values = checked({"scenario": scenario, "cueing": cueing}).model_dump()
    with tempfile.TemporaryDirectory(prefix="otolith-") as folder, listening(LOCAL, 0) as socket_:
        setup = setup_for(socket_, LOCAL, Path(folder), Secrets())
        measured = measure(setup, values, seconds=seconds, rounds=rounds)
        measured["live"] = _live_stops(Path(folder), stops)
    if json:
        print_json(measured)
        return
    console = screen(stderr=False, wide=True)
    shown = Table(box=None, pad_edge=False)
    for name in ("", "measured", "goal"):
        shown.add_column(name)
    for line in (*table(measured), *live_table(measured["live"])):
        shown.add_row(*map(Text, line))
    console.print(shown)
    console.print(f"load of this machine: {measured['load']:.1f}", highlight=False)


def _live_stops(folder: Path, count: int) -> dict[str, Any]:
    """Return how long a STOP takes in a live session like that of `otolith live demo`."""
    from otolith.cli.live_run import Choices
    from otolith.commander.bench_live import live_stops
    from otolith.commander.keeper import Setup
    from otolith.commander.security import Secrets, new_token

    choices = Choices(cueing="classical", platform="davsi-4dof", dofs="surge-pitch,sway-roll", tuning="davsi")
    with choices.rehearsed() as session, listening(LOCAL, 0) as socket_:
        setup = functools.partial(
            Setup,
            prefix=f"otolith-{os.getpid()}-bench",
            folder=folder,
            listening=socket_,
            host=LOCAL,
            secrets=Secrets(token=new_token()),
        )
        return live_stops(session, setup, count)
