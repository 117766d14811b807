"""The application: routes, the stream and the page's files behind one guard."""

import gzip
from importlib.resources import files
from typing import Final

from fastapi import FastAPI, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, RedirectResponse, Response
from starlette.exceptions import HTTPException

from otolith.commander.routes import routes, sentence_of
from otolith.commander.security import TOKEN, Guard, Refused
from otolith.commander.session import Session
from otolith.commander.stream import Stream
from otolith.core.errors import InputError, OtolithError
from otolith.report.page import asset

DRAWING: Final = "drawing.js"
_WEB: Final = files("otolith.commander") / "web"
# Told explicitly: where a system calls a module of JavaScript mere text, browsers refuse it.
_KINDS: Final = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


def create_app(session: Session) -> FastAPI:
    """Return the application of one server."""
    app = FastAPI(
        title="Otolith Commander", openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False
    )
    stream = Stream(session)
    app.include_router(routes(session))

    @app.websocket("/stream")
    async def serve(websocket: WebSocket) -> None:
        await stream.serve(websocket)

    @app.get("/")
    def page(request: Request) -> Response:
        if request.scope["otolith"]["by_token"] and session.secrets.token is not None:
            moved = RedirectResponse("/", 303)
            moved.set_cookie(TOKEN, session.secrets.token, httponly=True, samesite="strict")
            return moved
        return page_file("index.html", request)

    @app.get("/web/{name}")
    def file(name: str, request: Request) -> Response:
        return page_file(name, request)

    _say_errors(app)
    app.add_middleware(Guard, hosts=session.hosts, secrets=session.secrets)
    return app


def page_file(name: str, request: Request) -> Response:
    """Return a file of the page, packed for whoever can unpack it."""
    content, kind = _content(name)
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(content, media_type=kind)
    headers = {"content-encoding": "gzip", "vary": "accept-encoding"}
    return Response(gzip.compress(content, mtime=0), media_type=kind, headers=headers)


def _content(name: str) -> tuple[bytes, str]:
    """Return a file of the page and its kind; only those that were shipped have a name here."""
    if name == DRAWING:  # reports hold the same text in themselves, where nothing is exported
        return f"{asset(DRAWING)}export {{ Drawing }};\n".encode(), _KINDS[".js"]
    shipped = {entry.name: entry for entry in _WEB.iterdir() if entry.is_file()} if _WEB.is_dir() else {}
    kind = _KINDS.get(f".{name.rpartition('.')[2]}")
    if name not in shipped or kind is None:
        raise Refused(404, "the page has no such file")
    return shipped[name].read_bytes(), kind


def _say_errors(app: FastAPI) -> None:
    """Let every error be one sentence."""

    @app.exception_handler(InputError)
    def refused_value(_: Request, error: InputError) -> JSONResponse:
        return JSONResponse({"field": field_of(error), "sentence": str(error)}, 422)

    @app.exception_handler(OtolithError)
    def refused(_: Request, error: OtolithError) -> JSONResponse:
        return JSONResponse({"field": "", "sentence": str(error)}, 422)

    @app.exception_handler(Refused)
    def refused_request(_: Request, refused: Refused) -> JSONResponse:
        return JSONResponse({"sentence": refused.sentence}, refused.status)

    @app.exception_handler(HTTPException)
    def no_route(_: Request, error: HTTPException) -> JSONResponse:
        return JSONResponse({"sentence": str(error.detail)}, error.status_code)

    @app.exception_handler(RequestValidationError)
    def no_object(_: Request, __: RequestValidationError) -> JSONResponse:
        return JSONResponse({"field": "", "sentence": "what was sent is no object of JSON"}, 422)

    app.add_exception_handler(Exception, sentence_of)


def field_of(error: InputError) -> str:
    """Return the setting of the form that an error is about; empty if it is none."""
    from otolith.commander.schema import Form

    name = error.field.removeprefix("--").partition(" ")[0].replace("-", "_")
    return name if name in Form.model_fields else ""
