"""Every line of what a request must bring, against the real server, and the guard by itself."""

import asyncio
import gzip
import re
import socket
import struct
import time
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from otolith.cli import main
from otolith.commander.security import CLIENTS, MESSAGE, TOKEN, UPLOAD, WORDS, Guard, Rate, Secrets, new_token
from otolith.commander.stream import MESSAGES
from tests.commander.client import Page, Stream
from tests.commander.conftest import Commander, until

READING = ("/", "/health", "/api/start", "/api/result", "/web/main.js")
DOING = (
    ("POST", "/api/check"),
    ("POST", "/api/run"),
    ("POST", "/api/word"),
    ("POST", "/api/parameters"),
    ("PUT", "/api/presets/x"),
    ("DELETE", "/api/presets/x"),
    ("POST", "/api/upload?name=x.csv"),
    ("PUT", "/api/platforms/x.toml"),
    ("POST", "/api/platforms/x.toml/check"),
    ("DELETE", "/api/platforms/x.toml"),
    ("POST", "/api/rig"),
    ("POST", "/api/errand"),
    ("POST", "/api/channels?source=wrc&name=x.json"),
)


def refused_stream(port: int, **headers: str) -> int:
    """Return the status with which a handshake is refused; 101 if it is not."""
    try:
        with Stream(port, headers):
            return 101
    except InvalidStatus as refused:
        return refused.response.status_code


@pytest.mark.parametrize("path", READING)
@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1.evil.example", ""]
)
def test_a_foreign_host_is_not_answered(page: Page, path: str, host: str) -> None:
    answer = page.ask(path, Host=host)
    assert answer.status == 421
    assert "csrf" not in answer.body.decode()


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", "null", "file://"])
def test_a_foreign_origin_is_refused_everywhere_before_a_websocket_opens(page: Page, origin: str) -> None:
    for path in READING:
        assert page.ask(path, Origin=origin).status == 403
    for method, path in DOING:
        assert page.ask(path, {}, method=method, Origin=origin).status == 403
    assert refused_stream(page.port, Origin=origin, Cookie=page.cookie) == 403


def test_a_websocket_asks_for_the_host_too_and_without_an_origin_for_the_secret(page: Page) -> None:
    with socket.create_connection(("127.0.0.1", page.port)) as line:
        line.sendall(
            b"GET /stream HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Protocol: otolith.1\r\n\r\n"
        )
        assert line.recv(64).startswith(b"HTTP/1.1 421 ")
    assert refused_stream(page.port, Origin="") == 403
    assert refused_stream(page.port, Origin="", **{"X-Otolith": page.csrf}) == 101


@pytest.mark.parametrize(("method", "path"), DOING)
@pytest.mark.parametrize("secret", ["", "wrong", "ü"])
def test_nothing_is_done_without_the_secret_of_our_own_page(
    page: Page, method: str, path: str, secret: str
) -> None:
    answer = page.ask(path, {"word": "stop"}, method=method, X_Otolith=secret.encode().decode("latin-1"))
    assert answer.status == 403
    assert "x-otolith" in answer.json["sentence"]


@pytest.mark.parametrize(
    "path",
    [
        "/web/../app.py",
        "/web/..%2fapp.py",
        "/web/%2e%2e/app.py",
        "/web/..%5capp.py",
        "/web//etc/passwd",
        "/web/.",
        "/api/result/../../../../etc/passwd",
        "/api/result/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
        "/api/result/.otolith",
        "/openapi.json",
        "/docs",
    ],
)
def test_no_path_leads_to_the_file_system(page: Page, path: str) -> None:
    answer = page.ask(path)
    assert answer.status in (404, 422)
    assert list(answer.json) == ["sentence"]


@pytest.mark.parametrize("name", ["..", "../x", "%2e%2e%2fx", "a/b", "a%00b", "x" * 65, ".hidden", ""])
def test_names_of_files_and_presets_are_plain(page: Page, commander: Commander, name: str) -> None:
    before = sorted(commander.setup.folder.rglob("*"))
    assert page.ask(f"/api/upload?name={name}", body=b"t,ax\n").status == 422
    time.sleep(0.06)
    assert page.ask(f"/api/presets/{name}", {}, method="PUT").status in (404, 405, 422)
    time.sleep(0.06)
    assert sorted(commander.setup.folder.rglob("*")) == before


def test_only_texts_are_taken_as_drives(page: Page) -> None:
    for name in ("drive.h5", "drive.mf4", "drive.pkl", "drive"):
        answer = page.ask(f"/api/upload?name={name}", body=b"x")
        assert answer.status == 422
        assert "csv" in answer.json["sentence"]


def test_what_is_too_long_is_refused(page: Page) -> None:
    assert page.ask("/api/check", body=b"{" + b" " * MESSAGE, method="POST").status == 413
    assert page.ask("/api/upload?name=x.csv", body=b"1" * (UPLOAD + 1)).status == 413
    assert page.ask("/api/upload?name=x.csv", body=b"1" * 10, Content_Length="ten").status in (400, 413)


def test_a_body_longer_than_it_announced_ends_the_request(page: Page) -> None:
    """Without a length, in chunks: what is read is counted."""
    head = (
        f"POST /api/check HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\nX-Otolith: {page.csrf}\r\n"
        "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", page.port)) as line:
        line.sendall(head.encode())
        chunk = b"%x\r\n" % 8192 + b" " * 8192 + b"\r\n"
        sent = 0
        try:
            while b"HTTP/1.1" not in _waiting(line) and sent < 100 * MESSAGE:
                line.sendall(chunk)
                sent += len(chunk)
        except OSError:  # the line was closed while it was written to
            pass
        assert sent < 100 * MESSAGE
    assert page.ask("/health").status == 200


def _waiting(line: socket.socket) -> bytes:
    line.setblocking(False)
    try:
        return line.recv(4096)
    except BlockingIOError:
        return b""
    finally:
        line.setblocking(True)


def code_of(stream: Stream) -> int | None:
    """Return the code with which the server closes a stream."""
    try:
        while True:
            stream.next(timeout=10.0)
    except ConnectionClosed as closed:
        return None if closed.rcvd is None else closed.rcvd.code


def closed_by(page: Page, message: str | bytes) -> int | None:
    """Return the code with which the server closes a stream for a message."""
    with page.stream() as stream:
        stream.socket.send(message)
        return code_of(stream)


def test_a_message_that_says_it_is_long_closes_its_websocket(page: Page) -> None:
    """Only the head of the message is sent: what follows could meet the closed socket and reset it, and the
    code would be lost.
    """
    with page.stream() as good:
        for length, code in ((MESSAGE + 1, 1009), (200_000, 1009), (2**40, 1009)):
            with page.stream() as stream:
                masked_text = struct.pack("!BBQI", 0x81, 0xFF, length, 0)  # RFC 6455, 5.2
                stream.socket.socket.sendall(masked_text)
                assert code_of(stream) == code, length
        assert good.until("state")


def test_a_long_message_is_not_taken_in(page: Page) -> None:
    with page.stream() as good:
        with page.stream() as stream:
            stream.socket.send(200_000 * "x")
            assert code_of(stream) in {1009, None}  # None: reset, see above
        assert good.until("state")


def test_garbage_closes_a_websocket_and_nothing_else(page: Page) -> None:
    with page.stream() as good:
        for message in (
            "no json",
            "[" * 60_000,
            b"\x00\xff",
            '{"ack": 10}',
            '{"ack": "1"}',
            '{"want": "all"}',
            '{"want": "raw", "columns": [{}]}',
            "{}",
        ):
            assert closed_by(page, message) == 1008, message[:50]
        assert good.until("state")


def test_a_flood_of_messages_closes_its_own_line_only(page: Page) -> None:
    with page.stream() as good, page.stream() as flood:
        for _ in range(MESSAGES + 1):
            flood.send({"ack": 0})
        assert code_of(flood) == 1008
        assert good.until("state")


def test_there_are_only_so_many_clients(page: Page) -> None:
    until(lambda: refused_stream(page.port, Cookie=page.cookie) == 101)
    time.sleep(0.3)
    streams = [page.stream() for _ in range(CLIENTS)]
    try:
        assert refused_stream(page.port, Cookie=page.cookie) == 503
    finally:
        for stream in streams:
            stream.__exit__()
    until(lambda: refused_stream(page.port, Cookie=page.cookie) == 101)


def test_another_subprotocol_is_refused(page: Page) -> None:
    from websockets.sync.client import connect
    from websockets.typing import Origin

    with (
        pytest.raises(InvalidStatus),
        connect(f"ws://127.0.0.1:{page.port}/stream", origin=Origin(f"http://127.0.0.1:{page.port}")),
    ):
        pass


def test_words_are_counted_but_a_stop_always_passes(page: Page) -> None:
    time.sleep(1.1)
    said = [page.say("resume") for _ in range(WORDS + 5)]
    assert said[0] == 204
    assert 429 in said
    assert page.say("stop") == 204
    time.sleep(1.1)
    assert page.say("nonsense") == 422
    assert page.say("arm") == 422  # a word of live operation


def test_rate_counts_each_client_by_itself_within_a_second() -> None:
    clock = [0.0]
    rate = Rate(3, lambda: clock[0])
    assert [rate.allows("a") for _ in range(4)] == [True, True, True, False]
    assert rate.allows("b")
    clock[0] = 0.99
    assert not rate.allows("a")
    clock[0] = 1.01
    assert rate.allows("a")


def test_every_answer_forbids_what_a_page_does_not_need(page: Page) -> None:
    for path in READING:
        headers = {name.lower(): value for name, value in page.ask(path).headers.items()}
        assert "default-src 'self'" in headers["content-security-policy"]
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert not [name for name in headers if name.startswith("access-control")]
    assert page.ask("/web/main.js").headers["content-type"].startswith("text/javascript")


def test_the_page_asks_no_other_host() -> None:
    """No address of another host in what is served; links to licences in comments are not asked for."""
    for entry in (files("otolith.commander") / "web").iterdir():
        if entry.name.endswith((".js", ".css", ".html")):
            text = re.sub(r"/\*.*?\*/|//[^\n]*", "", entry.read_text(encoding="utf-8"), flags=re.DOTALL)
            assert not re.search(r"(src|href|import|from|url|fetch)\W{1,3}(https?:)?//\w", text), entry.name


def test_nothing_is_unpickled() -> None:
    for path in (Path(__file__).parents[2] / "src/otolith/commander").glob("*.py"):
        assert "pickle" not in path.read_text(encoding="utf-8")


async def asked(secrets: Secrets, path: str = "/api/start", **given: Any) -> int:
    """Return the status with which a guard answers; 200 where the request is passed on."""
    sent: list[Any] = []

    async def application(scope: Any, receive: Any, send: Any) -> None:
        sent.append({"status": 200})

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "http.request", "body": b""}

    headers = [(b"host", b"box:1")] + [
        (name.replace("_", "-").encode(), value.encode()) for name, value in given.pop("headers", {}).items()
    ]
    scope = {"type": "http", "method": "GET", "path": path, "headers": headers, "query_string": b""} | given
    await Guard(application, hosts=frozenset({"box:1"}), secrets=secrets)(scope, receive, send)
    return next(message["status"] for message in sent if "status" in message)


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_with_a_token_nothing_is_answered_without_it(kind: str) -> None:
    secrets = Secrets(token=new_token())
    token = str(secrets.token)
    assert len(token) >= 43  # 32 bytes

    def status(path: str = "/api/start", **given: Any) -> int:
        return asyncio.run(asked(secrets, path, type=kind, **given))

    assert status() == 401
    assert status(headers={"cookie": f"{TOKEN}={token[:-1]}"}) == 401
    assert status(headers={"cookie": f"{TOKEN}=ü"}) == 401
    assert status(headers={"authorization": "Bearer wrong"}) == 401
    assert status(query_string=f"token={token}".encode()) == 401  # only in the address of the first page
    assert status("/", query_string=f"token={token}".encode()) == 200
    assert status(headers={"cookie": f"{TOKEN}={token}"}) == 200
    assert status(headers={"authorization": f"Bearer {token}"}) == 200


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Commander]:
    made = Commander(tmp_path_factory.mktemp("guarded"), token=new_token())
    try:
        yield made
    finally:
        made.end()


def test_the_printed_address_gives_a_cookie_and_hides_the_token(guarded: Commander) -> None:
    token = str(guarded.setup.secrets.token)
    page = Page.__new__(Page)
    page.port, page.csrf, page.cookies = guarded.port, "", {}
    until(lambda: _answers(page))
    assert page.ask("/").status == 401
    moved = page.ask(f"/?token={token}")
    assert (moved.status, moved.headers["location"]) == (303, "/")
    cookie = moved.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert page.ask("/api/start", Cookie=page.cookie).status == 200
    assert refused_stream(page.port) == 401
    assert refused_stream(page.port, Cookie=page.cookie) == 101
    assert refused_stream(page.port, Origin="", Authorization=f"Bearer {token}") == 101


def _answers(page: Page) -> bool:
    try:
        return page.ask("/health").status == 401
    except OSError:
        return False


def test_another_host_needs_a_token(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["commander", "--host", "0.0.0.0"])
    assert ended.value.code == 2
    assert "--token" in capsys.readouterr().err


def test_a_taken_port_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(SystemExit):
            main(["commander", "--port", str(taken.getsockname()[1])])
    assert "not free" in capsys.readouterr().err


def test_a_packed_file_of_the_page_is_the_same_file(page: Page) -> None:
    plain, packed = page.ask("/web/main.js"), page.ask("/web/main.js", Accept_Encoding="gzip")
    assert packed.headers["content-encoding"] == "gzip"
    assert len(packed.body) < len(plain.body)
    assert gzip.decompress(packed.body) == plain.body
    assert "content-encoding" not in plain.headers
