"""Who holds a port, and packets that are passed on."""

import os
import socket
from pathlib import Path

import pytest

from otolith.cli.live_run import Choices
from otolith.core.errors import InputError
from otolith.live.shell.datagrams import LOCAL, PortInUse, opened, passed_on
from otolith.live.shell.ports import holders_of
from otolith.live.shell.virtual import free_port


def test_the_holder_of_a_port_is_named() -> None:
    with opened(0) as holder:
        port = holder.getsockname()[1]
        name = Path("/proc/self/comm").read_text().strip()
        assert holders_of(port) == [f"{name} (process {os.getpid()})"]
        with pytest.raises(PortInUse, match=rf"it is held by {name} \(process {os.getpid()}\); let that"):
            opened(port)
    assert holders_of(port) == []


def test_sockets_of_others_that_cannot_be_seen_leave_the_holder_unnamed(tmp_path: Path) -> None:
    (tmp_path / "net").mkdir()
    head = (
        "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
    )
    row = "  78: 0100007F:14B4 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000 0 4711 2 0 0\n"
    (tmp_path / "net" / "udp").write_text(head + row)
    (tmp_path / "12").mkdir()  # a process whose descriptors are another user's
    assert holders_of(5300, tmp_path) == []
    (tmp_path / "345" / "fd").mkdir(parents=True)
    (tmp_path / "345" / "comm").write_text("simhub\n")
    (tmp_path / "345" / "fd" / "3").symlink_to("socket:[4711]")
    assert holders_of(5300, tmp_path) == ["simhub (process 345)"]
    assert holders_of(5301, tmp_path) == []


def test_packets_are_passed_on_and_nobody_is_waited_for() -> None:
    with opened(0) as line, opened(0) as other:
        passed_on(line, ((1, b"one"), (2, b"two")), (LOCAL, other.getsockname()[1]))
        assert [other.recv(9), other.recv(9)] == [b"one", b"two"]
        passed_on(line, ((3, b"three"),), (LOCAL, free_port()))
        other.sendto(b"still heard", line.getsockname())
        assert line.recv(20) == b"still heard"
        assert isinstance(line, socket.socket)


def test_a_session_does_not_pass_packets_on_to_itself() -> None:
    choices = Choices(
        incoming="forza+udp://0.0.0.0:5300", outgoing="generic+udp://127.0.0.1:9", forward="127.0.0.1:5300"
    )
    with pytest.raises(InputError, match="a port other than that of listen"):
        choices.session()
