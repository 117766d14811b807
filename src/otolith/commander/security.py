"""What a request must bring before anything else looks at it: the right host, origin, token and size.

By default a web server answers any host name and opens a websocket for any page (measured), so a page of
somebody else in the same browser, or a name that is made to point to 127.0.0.1, could operate a platform.
This stands before routing, and before the handshake of a websocket too.
"""

import hmac
import json
import secrets
import time
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any, Final
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

CSRF: Final = "x-otolith"  # header with the value that only our own page can have read
TOKEN, CLIENT = "otolith-token", "otolith-client"  # cookies
MESSAGE: Final = 65_536  # [bytes] of a request's body, or of a message of a websocket
UPLOAD: Final = 1 << 20  # [bytes] of an uploaded file
CLIENTS: Final = 8  # websockets at a time
WORDS: Final = 20  # per second and client
_READING: Final = ("GET", "HEAD")
_HEADERS: Final = {
    "content-security-policy": "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Secrets:
    """What the keeper makes once, so that a server that comes back knows its pages again."""

    csrf: str = field(default_factory=lambda: secrets.token_urlsafe(32))
    token: str | None = None  # must be brought by every request; None: this machine alone is answered


def new_token() -> str:
    """Return a token of 32 bytes."""
    return secrets.token_urlsafe(32)


class Rate:
    """Counts what each client says, and refuses more than so many within a second."""

    def __init__(self, most: int = WORDS, now: Callable[[], float] = time.monotonic) -> None:
        self._most, self._now = most, now
        self._told: dict[str, list[float]] = {}

    def allows(self, client: str) -> bool:
        """Count a word of a client, unless it is one too many."""
        now = self._now()
        self._told = {who: times for who, times in self._told.items() if times[-1] > now - 1.0}
        times = [when for when in self._told.get(client, []) if when > now - 1.0]
        if len(times) >= self._most:
            return False
        self._told[client] = [*times, now]
        return True


class Refused(Exception):
    """A request is refused: the status, and one sentence."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status, self.sentence = status, sentence


class Guard:
    """Middleware before routing.

    Parameters
    ----------
    hosts : that may be asked for, each as "name:port".
    """

    def __init__(self, app: App, *, hosts: frozenset[str], secrets: Secrets) -> None:
        self._app, self._hosts, self._secrets = app, hosts, secrets

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what is in order; answer everything else with one sentence."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        try:
            headers = self._checked(scope)
        except Refused as refused:
            await _answer(scope, send, refused.status, refused.sentence)
            return
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)
            return
        body = _Body(receive, UPLOAD if scope["path"] == "/api/upload" else MESSAGE)
        if not body.announced(headers.get("content-length", "0")):
            await _answer(scope, send, 413, body.sentence)
            return
        await self._app(scope, body.receive, _with_headers(send))

    def _checked(self, scope: Scope) -> dict[str, str]:
        """Return the headers, and note the client in the scope.

        Raises
        ------
        Refused : host, origin, token or the header against forgery is not right.
        """
        headers = {
            name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]
        }
        cookies = _cookies(headers.get("cookie", ""))
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts:
            raise Refused(421, f"this server is not {host[:100] or 'without a name'}")
        if origin is not None and origin.partition("://")[2] not in self._hosts:
            raise Refused(403, "a page of another origin may not ask here")
        token = self._secrets.token
        if token is not None and not _equal(_token(scope, headers, cookies), token):
            raise Refused(
                401, "the token is missing or wrong: open the address that was printed at the start"
            )
        own = _equal(headers.get(CSRF, ""), self._secrets.csrf)
        if scope["type"] == "websocket":
            if origin is None and token is None and not own:
                raise Refused(403, f"without an origin, the header {CSRF} is needed")
        elif scope["method"] not in _READING and not own:
            raise Refused(403, f"the header {CSRF} is missing or wrong")
        scope["otolith"] = {"client": cookies.get(CLIENT, ""), "by_token": _given(scope) is not None}
        return headers


class _Body:
    """The body of a request, which ends the request where it becomes too long."""

    def __init__(self, receive: Receive, most: int) -> None:
        self._receive, self._most, self._had = receive, most, 0
        self.sentence = f"what was sent is too long, must be at most {most} bytes"

    def announced(self, length: str) -> bool:
        """Return whether the length that the header announces is allowed."""
        return length.isascii() and length.isdigit() and int(length) <= self._most

    async def receive(self) -> Message:
        """Return the next part."""
        message = await self._receive()
        self._had += len(message.get("body", b""))
        if self._had > self._most:  # longer than announced
            return {"type": "http.disconnect"}
        return message


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            present = {name.lower() for name, _ in message["headers"]}
            added = [
                (name.encode(), value.encode())
                for name, value in _HEADERS.items()
                if name.encode() not in present
            ]
            message["headers"] = [*message["headers"], *added]
        await send(message)

    return sent


async def _answer(scope: Scope, send: Send, status: int, sentence: str) -> None:
    """Answer with a status and a sentence; a websocket is refused before it opens."""
    kind = "http"
    if scope["type"] == "websocket":
        kind = "websocket.http"
    body = json.dumps({"sentence": sentence}).encode()
    headers = [(b"content-type", b"application/json"), (b"content-length", str(len(body)).encode())]
    send = _with_headers(send) if kind == "http" else send
    await send({"type": f"{kind}.response.start", "status": status, "headers": headers})
    await send({"type": f"{kind}.response.body", "body": body})


def _equal(given: str, secret: str) -> bool:
    """Compare in constant time."""
    return hmac.compare_digest(given.encode(), secret.encode())


def _given(scope: Scope) -> str | None:
    """Return the token in the address, if there is one."""
    found = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token")
    return found[0] if found else None


def _token(scope: Scope, headers: dict[str, str], cookies: dict[str, str]) -> str:
    """Return the token of a request: in the address of the first page, as a cookie, or as a header."""
    by_address = _given(scope) if scope["path"] == "/" else None
    bearer = headers.get("authorization", "").removeprefix("Bearer ")
    return by_address or cookies.get(TOKEN, "") or bearer


def _cookies(text: str) -> dict[str, str]:
    try:
        return {name: morsel.value for name, morsel in SimpleCookie(text).items()}
    except CookieError:
        return {}
