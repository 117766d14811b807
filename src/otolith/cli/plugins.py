"""Commands of other distributions, which the entry point group `otolith.commands` adds to `otolith`.

An entry point names a function, which becomes a command with its parameters as options, or a `typer.Typer`,
which becomes a group of commands. The line of help is the summary of the distribution, so that `otolith
--help` imports nothing.
"""

from collections.abc import Collection
from importlib.metadata import EntryPoint
from typing import Any, Final

import typer

from otolith.core import plugins
from otolith.core.errors import MissingExtra

GROUP: Final = "otolith.commands"
# Commands of distributions of this project, and the distribution
KNOWN: Final = {"reproduce": "otolith-thesis"}


def commands() -> dict[str, EntryPoint]:
    """Return all commands that installed distributions declare, by name; see `core.plugins.declared`."""
    return plugins.declared(GROUP)


def help_line(entry: EntryPoint) -> str:
    """Return the line of help for a command: the summary of its distribution."""
    # Not by key: once something has imported the backport importlib_metadata, one that is absent is an error.
    stated = entry.dist.metadata.get_all("Summary") if entry.dist else None
    return stated[0] if stated else f"A command of {plugins.distribution(entry)}."


def load(entry: EntryPoint) -> Any:
    """Import the function, or the `typer.Typer`, that an entry point names.

    Raises
    ------
    BrokenPlugin : it cannot be imported or made a command.
    """
    target = plugins.load_entry_point(entry)
    try:
        _as_command(target)
    except Exception as error:  # typer may raise anything on code from outside
        who = f"{GROUP} {entry.name!r} of {plugins.distribution(entry)}"
        raise plugins.BrokenPlugin(who, "cannot be made a command", error) from error
    return target


def _as_command(target: Any) -> None:
    """Make a trial command, because typer reads the parameters only then."""
    if isinstance(target, typer.Typer):
        typer.main.get_command(target)
        return
    if not callable(target):
        raise TypeError(f"{target!r} is neither a function nor a typer.Typer")
    alone = typer.Typer()
    alone.command()(target)
    typer.main.get_command(alone)


def not_offered(own: Collection[str]) -> str:
    """Return which commands are not offered, and why; empty if all are."""
    names = [f"{name} of {plugins.distribution(one)}" for name, one in commands().items() if name in own]
    lines = [f"Not offered, since Otolith has commands of that name: {', '.join(names)}."] if names else []
    lines += [f"Not offered: {why}." for name, why in plugins.doubtful(GROUP).items() if name not in own]
    return " ".join(lines)


def refuse_absent(name: str) -> None:
    """Refuse a command of another distribution of this project that is not installed.

    Raises
    ------
    MissingExtra : the message says how to install it.
    """
    if name in KNOWN:
        raise MissingExtra(
            f"{name} is in a distribution of its own, which is not installed: "
            f"pip install {KNOWN[name]} (in the repository: make demo)"
        )
