"""What a page can ask for beside the stream, all of it JSON, and all from the Commander's own folder."""

import json
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse, PlainTextResponse

from otolith import __version__, registry
from otolith.commander.runs_routes import file_of, files_of, runs_routes, saved
from otolith.commander.schema import CUEING, TOML, Form, checked, live_schema, schema
from otolith.commander.security import CLIENT, Refused
from otolith.commander.session import (
    CHANGE,
    MEASURING,
    PLATFORMS,
    PRESETS,
    RESULTS,
    UPLOADS,
    Session,
    count,
    new_client,
)
from otolith.core.disk import write_text
from otolith.platforms.library import descriptions
from otolith.scenarios.catalog import SCENARIOS

DRIVES: Final = (".csv", ".tsv", ".txt", ".json")  # endings: a format that runs code has none here
SAMPLES: Final = "samples.csv"
_YEAR: Final = 31_536_000  # [s] that a browser keeps its name


def routes(session: Session) -> APIRouter:
    """Return all routes of a session."""
    router = APIRouter()
    _watching(router, session)
    _doing(router, session)
    _files(router, session)
    if session.errands is not None:  # not beside a live session, whose server stays small
        from otolith.commander.rig_routes import rig_routes

        rig_routes(router, session)
    runs_routes(router, session)
    return router


def _watching(router: APIRouter, session: Session) -> None:
    @router.get("/health")
    def health() -> dict[str, Any]:
        return {"ok": True, "version": __version__}

    @router.get("/api/start")
    def start(request: Request, response: Response) -> dict[str, Any]:
        name = request.scope["otolith"]["client"] or new_client()
        response.set_cookie(CLIENT, name, max_age=_YEAR, httponly=True, samesite="strict")
        watches = session.desk is None
        return {
            "csrf": session.secrets.csrf,
            "version": __version__,
            "mode": session.mode,
            "words": session.words,
            "schema": live_schema(session.parameters) if watches else schema(session.names(PLATFORMS, TOML)),
            "choices": _choices(session),
            "presets": _presets(session),
            "values": dict(session.parameters) if watches else Form().model_dump(),
        }

    @router.get("/api/hexapod")
    def hexapod() -> Any:
        return session.card.look().get("hexapod")

    @router.get("/api/map")
    def map_() -> Any:
        return session.card.look().get("map")

    @router.get("/api/presets")
    def presets() -> Any:
        return _presets(session)


def _doing(router: APIRouter, session: Session) -> None:
    @router.post("/api/check")
    def check(request: Request, values: dict[str, Any]) -> dict[str, Any]:
        count(request, session)
        return session.desk_of_runs().check(checked(values).model_dump())

    @router.post("/api/run", status_code=202)
    def run(request: Request, values: dict[str, Any]) -> dict[str, Any]:
        count(request, session)
        session.control(request.scope["otolith"]["client"])
        desk, state = session.desk_of_runs(), session.state.look()
        if not state:
            raise Refused(409, "the simulation is still starting")
        if state["busy"]:
            raise Refused(409, "a run is going on; stop it first")
        if session.errand() in MEASURING:
            raise Refused(409, "the rig is being tested; a run would disturb it: wait, or stop it first")
        form = checked(values).model_dump()
        desk.check(form)
        session.give("run", form)
        return {"generation": state["generation"] + 1}

    @router.post("/api/word", status_code=204)
    async def word(request: Request, values: dict[str, Any]) -> None:
        """Pass on a word within the server's loop: a STOP never waits for a thread that others keep busy."""
        session.speak(request.scope["otolith"]["client"], str(values.get("word", "")))

    @router.post("/api/parameters")
    def parameters(request: Request, values: dict[str, Any]) -> dict[str, Any]:
        count(request, session)
        session.control(request.scope["otolith"]["client"])
        applied = session.changed(values)
        session.give(CHANGE, applied)
        return {"at": session.state.look().get("time", 0.0), "applied": applied}


def _files(router: APIRouter, session: Session) -> None:
    @router.put("/api/presets/{name}", status_code=204)
    def save(request: Request, name: str, values: dict[str, Any]) -> None:
        count(request, session)
        kept = json.dumps(checked(values).model_dump(), indent=2)
        write_text(session.place(PRESETS, name, ".json"), kept + "\n")

    @router.delete("/api/presets/{name}", status_code=204)
    def delete(request: Request, name: str) -> None:
        count(request, session)
        place = session.place(PRESETS, name, ".json")
        if not place.is_file():
            raise Refused(404, "there is no such preset")
        place.unlink()

    @router.post("/api/upload")
    async def upload(request: Request, name: str) -> dict[str, Any]:
        count(request, session)
        place = session.place(UPLOADS, name)
        if place.suffix.lower() not in DRIVES:
            raise Refused(422, f"a drive must be a text whose name ends in {', '.join(DRIVES)}")
        return await _uploaded(session, place, await request.body())

    @router.get("/api/result")
    def result() -> Any:
        card = session.card.look()
        files = files_of(_results(session))
        shown = {name: card.get(name) for name in ("generation", "summary", "second", "command")}
        more = {"false_cues": card.get("false_cues", []), "files": [*files, *([SAMPLES] if files else [])]}
        return shown | more

    @router.get("/api/result/{name}")
    def result_file(name: str) -> Response:
        folder = _results(session)
        files = files_of(folder)
        if name == SAMPLES and files:
            first = session.card.look()["summary"]["cueing"]
            run = folder / ("run.h5" if "run.h5" in files else f"{first}.h5")
            return PlainTextResponse(
                session.desk_of_runs().samples(run), media_type="text/csv", headers=saved(name)
            )
        return file_of(folder, name)


def _results(session: Session) -> Path:
    """Return the folder of the results of the run that is shown."""
    return session.folder / RESULTS / str(session.card.look().get("folder", "none"))


def _choices(session: Session) -> dict[str, Any]:
    def entries(table: Any, names: Any) -> list[dict[str, str]]:
        return [{"name": name, "text": table[name].description} for name in names]

    return {
        "scenarios": entries(SCENARIOS, SCENARIOS),
        "platforms": [*_shipped(), *_own(session)],
        "cueing": entries(registry.CUEING.own, CUEING),
        "plants": entries(registry.PLANTS.own, registry.PLANTS.own),
        "logs": session.uploads(),
    }


def _shipped() -> list[dict[str, str]]:
    return [{"name": name, "text": text} for name, text in descriptions().items()]


def _own(session: Session) -> list[dict[str, str]]:
    if not session.names(PLATFORMS, TOML):
        return []
    from otolith.commander.rig_routes import own_platforms

    return own_platforms(session)


def _presets(session: Session) -> list[dict[str, Any]]:
    """Return the presets that still fit the form; one of another version may not."""
    found = []
    for path in sorted((session.folder / PRESETS).glob("*.json")):
        values = json.loads(path.read_text(encoding="utf-8"))
        found.append({"name": path.stem, "values": checked(values).model_dump()})
    return found


async def _uploaded(session: Session, place: Path, body: bytes) -> dict[str, Any]:
    """Keep a drive if it is understood, and say what was."""
    from starlette.concurrency import run_in_threadpool

    def keep() -> str:
        kept = place.with_name(f".{place.name}")
        kept.write_bytes(body)
        try:
            sentence = session.desk_of_runs().understood(kept)
            kept.replace(place)
        finally:
            kept.unlink(missing_ok=True)
        return sentence

    return {"name": place.name, "sentence": await run_in_threadpool(keep)}


def sentence_of(request: Request, error: Exception) -> JSONResponse:
    """Answer with one sentence for a server's own error, and never with a traceback."""
    del request, error
    return JSONResponse({"sentence": "the server failed at this request; its terminal says more"}, 500)
