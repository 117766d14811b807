"""Commands of other distributions: whoever declares an entry point `otolith.commands` adds one to `otolith`.

The entry point names a function, which becomes a command as typer makes one of its parameters, or a
`typer.Typer`, which becomes a group of commands. Its line of help is the summary of the distribution, so that
`otolith --help` imports nothing.
"""

from collections.abc import Collection
from importlib.metadata import EntryPoint
from typing import Any, Final

import typer

from otolith.core import plugins
from otolith.core.errors import MissingExtra

GROUP: Final = "otolith.commands"
KNOWN: Final = {"reproduce": "otolith-thesis"}  # commands of our own other distributions, and where they are


def commands() -> dict[str, EntryPoint]:
    """All commands that installed distributions declare, by name; see `otolith.core.plugins.declared`."""
    return plugins.declared(GROUP)


def help_line(entry: EntryPoint) -> str:
    """The line of help for a command: what its distribution says of itself."""
    summary = entry.dist.metadata["Summary"] if entry.dist else None
    return summary or f"A command of {plugins.distribution(entry)}."


def load(entry: EntryPoint) -> Any:
    """Import the function, or the `typer.Typer`, that an entry point names.

    Raises
    ------
    BrokenPlugin : it cannot be imported, or no command can be made of it.
    """
    target = plugins.load_entry_point(entry)
    try:
        _as_command(target)
    except Exception as error:  # whatever typer makes of the code of others
        who = f"{GROUP} {entry.name!r} of {plugins.distribution(entry)}"
        raise plugins.BrokenPlugin(who, "cannot be made a command", error) from error
    return target


def _as_command(target: Any) -> None:
    """Make a command, as a trial: typer reads the parameters only then."""
    if isinstance(target, typer.Typer):
        typer.main.get_command(target)
        return
    if not callable(target):
        raise TypeError(f"{target!r} is neither a function nor a typer.Typer")
    alone = typer.Typer()
    alone.command()(target)
    typer.main.get_command(alone)


def not_offered(own: Collection[str]) -> str:
    """Say which commands are not offered, and why; empty where all are."""
    names = [f"{name} of {plugins.distribution(one)}" for name, one in commands().items() if name in own]
    lines = [f"Not offered, since Otolith has commands of that name: {', '.join(names)}."] if names else []
    lines += [f"Not offered: {why}." for name, why in plugins.doubtful(GROUP).items() if name not in own]
    return " ".join(lines)


def refuse_absent(name: str) -> None:
    """Refuse a command of our own other distributions, which is not installed.

    Raises
    ------
    MissingExtra : it is one; the sentence says how to install it.
    """
    if name in KNOWN:
        raise MissingExtra(
            f"{name} is in a distribution of its own, which is not installed: "
            f"pip install {KNOWN[name]} (in the repository: make demo)"
        )
