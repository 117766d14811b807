"""`otolith live replay` and `live export`: what can be done with the log of a session."""

from collections.abc import Iterator
from contextlib import contextmanager
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from otolith import files
from otolith.cli.output import print_json, progress_bar, screen, warn, working
from otolith.core.disk import mapped
from otolith.core.errors import CorruptFile, InputError, one_of

if TYPE_CHECKING:
    from otolith.live.log import Opened
    from otolith.live.replay import Replay

LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="A log of 'live run --log' (.otl).")]


def replay(
    log: LogFile,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Tell new cores what is in a log, and compare what they say bit for bit; exit code 1 if it differs."""
    from otolith.live.log import PIECES
    from otolith.live.replay import Replay
    from otolith.live.session import session_from_record, versions

    with opened(log) as found:
        session = session_from_record(found.session, log.name)
        others = _others(found.head.get("versions", versions()), versions())
        for sentence in session.changed():
            warn(screen(), sentence)
        if others:
            warn(screen(), f"bits may differ, for {others}")
        with working(screen(), "compiling what is not cached, up to a minute"):
            play = Replay(session.controller(), session.output(), log.name)
        damage = None
        with progress_bar(screen(), "replaying") as bar:
            try:
                for piece in found.pieces(PIECES):
                    play.take(piece)
                    bar(found.share)
            except CorruptFile as error:
                damage = error
    _tell(play, json, damage)
    if damage is not None:
        raise damage
    if found.records.cut:
        warn(screen(), f"{log.name} ends within a record, as if its recorder had been killed")
    if any(seen.different or not seen.compared for seen in play.seen):
        raise typer.Exit(1)


def export(
    log: LogFile,
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="What to write: .h5 or .mf4 with all tables, .csv with one.")
    ],
    table: Annotated[
        str, typer.Option(help="Of a .csv: reference, set-points, measured, decisions or events.")
    ] = "reference",
) -> None:
    """Write a log as tables with units; the reference as .csv is a drive that 'otolith run --log' reads."""
    from otolith.live.export import CODES, TABLES, Tables
    from otolith.live.log import PIECES
    from otolith.live.session import session_from_record

    files.check_file(out, ".h5", ".mf4", ".csv")
    if table not in TABLES:
        raise InputError("--table", repr(table), one_of(TABLES, table))
    with opened(log) as found:
        session = session_from_record(found.session, log.name)
        tables = Tables(log.name, parse=session.source.parse, wanted=session.wanted, health=session.health())
        with progress_bar(screen(), "reading") as bar:
            try:
                for piece in found.pieces(PIECES):
                    tables.take(piece)
                    bar(found.share)
            except CorruptFile as damage:
                warn(screen(), f"{damage}; what came before is written")
        if found.records.cut:
            warn(screen(), f"{log.name} ends within a record, as if its recorder had been killed")
    said = {"log": log.name, "session": dumps(found.head), **CODES}
    made = tables.signals()
    files.write_tables(out, made, said, table=table)
    rows = ", ".join(f"{name} {len(signals[0].t)}" for name, signals in made.items())
    screen().print(f"rows: {rows}; written to {out}", soft_wrap=True)


@contextmanager
def opened(path: Path) -> "Iterator[Opened]":
    """Yield a log that is read as far as it is written now."""
    from otolith.live.log import Opened

    with mapped(path, "log") as data:
        yield Opened(data, path.name)


def _others(then: dict[str, Any], now: dict[str, str]) -> str:
    """Return what has another version than when the log was written, in words."""
    names = sorted(then.keys() | now.keys())
    return ", ".join(
        f"{name} was {then.get(name, 'absent')} and is {now.get(name, 'absent')}"
        for name in names
        if then.get(name) != now.get(name)
    )


def _tell(play: "Replay", json: bool, damage: CorruptFile | None) -> None:
    if json:
        print_json(
            {
                seen.what: {
                    "compared": seen.compared,
                    "different": seen.different,
                    "first_difference": seen.first,
                    "missing_in_log": seen.lost,
                    "not_compared": seen.after,
                }
                for seen in play.seen
            }
            | {"damage": "" if damage is None else str(damage)}
        )
        return
    out = screen(stderr=False)
    for seen in play.seen:
        verdict = (
            f"{seen.different} differ, the first: {seen.first}" if seen.different else "equal bit for bit"
        )
        out.print(f"{seen.compared} {seen.what} of {seen.seconds:.1f} s compared: {verdict}", soft_wrap=True)
        if seen.lost:
            out.print(
                f"{seen.lost} ticks are missing in the log; the {seen.after} after them are not compared",
                soft_wrap=True,
            )
