"""What a page asks for to set up a rig: platform files of its own, by their names."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

from otolith.commander.machine import field_of, forms, kind_of, text_of, values_of
from otolith.commander.rig import (
    DESCRIBED,
    FILE_OF_SESSION,
    KEPT,
    Rig,
    keep_rig,
    lacking,
    read_rig,
    session_of_rig,
)
from otolith.commander.rig import field_of as rig_field
from otolith.commander.schema import TOML, checked_as, is_file, schema
from otolith.commander.security import Refused
from otolith.commander.session import CHANNELS, MAPS, MEASURING, PLATFORMS, Session, count
from otolith.core.disk import read_text, write_text
from otolith.core.errors import InputError, OtolithError
from otolith.live.wire.sources import SOURCES, source_named
from otolith.platforms import parse_platform
from otolith.report.platform_page import platform_summary, range_lines, sentences

ERRANDS: Final = ("learn", "check", "axis")
ANSWERS: Final = ("save", "move", "yes", "no", "cancel")
TRIED: Final = ("axes", "legs")  # what an axis test moves
PORTS: Final = {name: one.port for name, one in SOURCES.items()}


def rig_routes(router: APIRouter, session: Session) -> None:
    """Add all routes of this module."""
    _platforms(router, session)
    _rig(router, session)


def _rig(router: APIRouter, session: Session) -> None:
    @router.get("/api/rig")
    def rig() -> dict[str, Any]:
        kept = read_rig(session.folder)
        shown = schema(session.names(PLATFORMS, TOML), Rig)
        shown["properties"]["map"]["enum"] = ["", *session.names(MAPS, TOML)]
        shown["properties"]["channels"]["enum"] = ["", *session.names(CHANNELS)]
        return {
            "schema": shown,
            "values": kept.model_dump(),
            "ports": PORTS,
            "known": (session.folder / KEPT).is_file(),
        }

    @router.post("/api/rig")
    def keep(request: Request, values: dict[str, Any]) -> dict[str, Any]:
        """Keep a rig that is in order; say of any other what is wrong, which is no failure of the request."""
        count(request, session)
        try:
            rig = checked_as(Rig, values)
            session_of_rig(rig, session.folder)
        except InputError as error:
            return {"field": rig_field(error), "sentence": str(error)}
        keep_rig(rig, session.folder)
        return {"field": "", "sentence": ""}

    @router.get("/api/rig/lacks")
    def lacks() -> dict[str, Any]:
        where = session.folder / FILE_OF_SESSION
        here = where.relative_to(Path.cwd()) if where.is_relative_to(Path.cwd()) else where
        return {
            "checks": lacking(session.folder),
            "command": f"otolith live run --session {shlex.quote(str(here))} --commander 0",
        }

    @router.post("/api/channels")
    async def channels(request: Request, source: str, name: str) -> dict[str, Any]:
        """Keep a game's file of channels, by its name, if the source that it describes is understood."""
        count(request, session)
        place, text = session.place(CHANNELS, name), (await request.body()).decode("utf-8", "replace")
        if source not in DESCRIBED:
            raise Refused(422, f"a game's file describes one of {', '.join(DESCRIBED)}, not {source[:40]!r}")
        source_named(f"{source}:{name}", lambda _: text)
        write_text(place, text)
        return {"name": name, "sentence": f"read as a file of {source}"}

    @router.post("/api/errand", status_code=202)
    def errand(request: Request, values: dict[str, Any]) -> dict[str, Any]:
        count(request, session)
        session.control(request.scope["otolith"]["client"])
        return order(session, values)


def order(session: Session, values: Mapping[str, Any]) -> dict[str, Any]:
    """Order an errand, or answer one that goes on; return its word.

    Raises
    ------
    Refused : the word is none, another errand or a run goes on, or what it needs is missing.
    """
    word = str(values.get("word", ""))
    if session.errands is None or session.rig is None:
        raise Refused(409, "a live session is watched here: a rig is set up before, in `otolith commander`")
    if word not in (*ERRANDS, *ANSWERS):
        raise Refused(
            422, f"there is no errand {word[:40]!r}, must be one of {', '.join((*ERRANDS, *ANSWERS))}"
        )
    if word in ERRANDS:
        if session.errand():
            raise Refused(409, "another part of the rig is being set up; stop it first")
        if word in MEASURING and session.running():
            raise Refused(409, "a run is going on, which would disturb the test; stop it first")
    session.errands.give(word, _needed(session, word, values))
    return {"word": word}


def _needed(session: Session, word: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return what goes with a word: names that are checked, and what the rig says."""
    if word == "save":
        name = f"{values.get('name', '')}{TOML}"
        session.place(MAPS, name)  # refuses what is no name
        return {"name": name}
    if word == "learn":
        rig = read_rig(session.folder)
        return {"source": rig.sender, "listen": rig.listen}
    if word == "axis":
        if values.get("what") not in TRIED:
            raise Refused(422, f"what is to be moved must be one of {', '.join(TRIED)}")
        return {"what": values["what"]}
    return {}


def _platforms(router: APIRouter, session: Session) -> None:
    @router.get("/api/platforms")
    def platforms() -> dict[str, Any]:
        return {"own": own_platforms(session), "kinds": forms()}

    @router.get("/api/platforms/{name}")
    def platform(name: str) -> dict[str, Any]:
        text = _text(session, name)
        if text is None:
            raise Refused(404, "there is no such platform file")
        parse_platform(text, name)
        kind = kind_of(text, name)
        return {"kind": kind, "values": values_of(text, kind)}

    @router.post("/api/platforms/{name}/check")
    def check(request: Request, name: str, values: dict[str, Any]) -> Any:
        try:
            return _judged(request, session, name, values, keep=False)
        except InputError as error:  # what is asked for: no failure of this request
            return {"field": field_of(error), "sentence": str(error)}

    @router.put("/api/platforms/{name}")
    def save(request: Request, name: str, values: dict[str, Any]) -> Any:
        try:
            return _judged(request, session, name, values, keep=True)
        except InputError as error:
            return JSONResponse({"field": field_of(error), "sentence": str(error)}, 422)

    @router.delete("/api/platforms/{name}", status_code=204)
    def delete(request: Request, name: str) -> None:
        count(request, session)
        place = session.place(PLATFORMS, name)
        if not is_file(name) or not place.is_file():
            raise Refused(404, "there is no such platform file")
        place.unlink()


def own_platforms(session: Session) -> list[dict[str, str]]:
    """Return the names of the user's platform files, each with its description, or with what is wrong."""
    return [
        {"name": name, "text": _described(session, name)}
        for name in session.names(PLATFORMS, TOML)
        if is_file(name)
    ]


def _described(session: Session, name: str) -> str:
    try:
        return parse_platform(_text(session, name) or "", name).description
    except OtolithError as error:
        return str(error)


def _text(session: Session, name: str) -> str | None:
    """Return the text of a platform file by its name; None if there is none."""
    if not is_file(name):
        raise Refused(
            422, f"the name of a platform file must be one of letters and digits, and end in {TOML}"
        )
    place = session.place(PLATFORMS, name)
    return read_text(place, "platform") if place.is_file() else None


def _judged(
    request: Request, session: Session, name: str, given: dict[str, Any], *, keep: bool
) -> dict[str, Any]:
    """Judge a form, keep its file if that is wanted, and say what the machine reaches."""
    count(request, session)
    before, kind, values = _text(session, name), str(given.get("kind", "")), given.get("values")
    if before is not None and kind_of(before, name) != kind:
        before = None  # another machine under the same name begins anew
    text = text_of(values if isinstance(values, dict) else {}, kind, name, before)
    if not keep:
        return {"field": "", "sentence": ""}
    write_text(session.place(PLATFORMS, name), text)
    summary = platform_summary(parse_platform(text, name))
    return {"name": name, "sentences": [*range_lines(summary), *sentences(summary)]}
