"""What a page asks for to set up a rig: platform files of its own, by their names."""

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

from otolith.commander.machine import field_of, forms, kind_of, text_of, values_of
from otolith.commander.schema import TOML, is_file
from otolith.commander.security import Refused
from otolith.commander.session import PLATFORMS, Session
from otolith.core.disk import read_text, write_text
from otolith.core.errors import InputError, OtolithError
from otolith.platforms import parse_platform
from otolith.report.platform_page import platform_summary, range_lines, sentences


def rig_routes(router: APIRouter, session: Session) -> None:
    """Add all routes of this module."""
    _platforms(router, session)


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


def count(request: Request, session: Session) -> None:
    """Refuse a client that asks too often."""
    if not session.rate.allows(request.scope["otolith"]["client"]):
        raise Refused(429, "too many requests within a second")


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
