"""`otolith live record`, `learn` and `emulate`, with packets over the local network."""

import json
import socket
import struct
import threading
from pathlib import Path

import numpy as np
import pytest

from otolith.cli import main
from otolith.live.wire.axes import axes_from_toml
from otolith.live.wire.capture import Packet, packet_record, read_capture, session_record
from tests.live.wire.golden import forza
from tests.live.wire.minute import DRIVE, forza_packet


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    return capsys.readouterr().err


def run(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code in (0, None)


class Sender(threading.Thread):
    """Sends packets to a port until it is told to stop."""

    def __init__(self, port: int, packets: list[bytes]) -> None:
        super().__init__(daemon=True)
        self.port, self.packets, self.over = port, packets, threading.Event()

    def run(self) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            while not self.over.wait(0.01):
                for packet in self.packets:
                    one.sendto(packet, ("127.0.0.1", self.port))


def test_record_keeps_packets_as_they_came(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    port, out = free_port(), tmp_path / "drive.otc"
    sender = Sender(port, [forza(311).packet, b"no packet"])
    sender.start()
    run(["live", "record", "forza", "--port", str(port), "--seconds", "0.5", "--out", str(out)])
    sender.over.set()
    capture = read_capture(out.read_bytes(), out.name)
    assert capture.source == "forza"
    assert {one.data for one in capture.packets} == {forza(311).packet, b"no packet"}
    times = [one.time_ns for one in capture.packets]
    assert times == sorted(times)
    output = capsys.readouterr().err
    assert "most often: size of Forza packet is 9 bytes" in output


def test_record_without_packets_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "drive.otc"
    message = refused(
        ["live", "record", "f1", "--port", str(free_port()), "--seconds", "0.1", "--out", str(out)], capsys
    )
    assert "number of packets received is 0, must be at least one within 0.1 s" in message
    assert not out.exists()


def test_a_port_in_use_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        port = str(one.getsockname()[1])
        message = refused(["live", "record", "f1", "--port", port, "--out", str(tmp_path / "d.otc")], capsys)
    assert f"UDP port {port} on 127.0.0.1 cannot be opened" in message
    assert "UDP port is 70000, must be 0 to 65535" in refused(
        ["live", "emulate", "moog", "--port", "70000"], capsys
    )


def capture(tmp_path: Path) -> Path:
    path = tmp_path / "minute.otc"
    records = [packet_record(Packet(round(1e9 * t), forza_packet(k))) for k, t in enumerate(DRIVE.t)]
    path.write_bytes(session_record("forza") + b"".join(records))
    return path


def test_learn_from_a_capture(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    log, out = capture(tmp_path), tmp_path / "axes.toml"
    run(["live", "learn", "--log", str(log), "--out", str(out)])
    output = capsys.readouterr()
    assert "force: forward = channel 1, left = channel 2, up = channel 3 [m/s²]" in output.out
    assert "test 'circle': r = " in output.out
    assert "vertical force is not proven" in output.err
    axes = axes_from_toml(out.read_text(), out.name)
    assert axes.source == "forza"
    run(["live", "learn", "--log", str(log), "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert printed["sha256"] == axes.digest
    assert printed["evidence"]["straight"] > 0.99


def test_learn_says_what_it_leaves_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    log = capture(tmp_path)
    log.write_bytes(log.read_bytes() + packet_record(Packet(0, b"damage")) + b"cut")
    run(["live", "learn", "--log", str(log), "--json"])
    said = capsys.readouterr()
    assert json.loads(said.out)["force"] == ["1", "2", "3"]
    assert "1 of 3331 packets are left out, the first: size of Forza packet is 6 bytes" in said.err
    assert "minute.otc ends within a packet" in said.err


def test_learn_from_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """A table in the axes of motor sport (y right, z down) with gravity, in g and deg/s."""
    log = tmp_path / "drive.csv"
    ax, ay, az = DRIVE.force.T / 9.80665
    rate = np.degrees(DRIVE.rate)
    rows = np.column_stack(
        [DRIVE.t, ax, -ay, -az - 1.0, rate[:, 0], -rate[:, 1], -rate[:, 2], 3.6 * DRIVE.speed]
    )
    names = "time [s],ax [g],ay [g],az [g],roll_rate [deg/s],pitch_rate [deg/s],yaw_rate [deg/s],speed [km/h]"
    np.savetxt(log, rows, delimiter=",", header=names, comments="", fmt="%.6f")
    run(["live", "learn", "--log", str(log), "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert printed["force"] == printed["rate"] == ["1", "-2", "-3"]
    assert (printed["gravity"], printed["force_unit"], printed["rate_unit"]) == (True, "m/s²", "rad/s")


def test_learn_says_what_failed(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    log = capture(tmp_path)
    log.write_bytes(log.read_bytes()[:120_000])  # the first half: no circle
    assert "must be about 60 s" in refused(["live", "learn", "--log", str(log), "--out", "x.txt"], capsys)
    message = refused(["live", "learn", "--log", str(log), "--source", "f1"], capsys)
    assert "packet format of F1 packet is 1" in message
    table = tmp_path / "drive.csv"
    table.write_text("t,ax\n0,0\n1,0\n")
    assert "--source is 'f1', must be left out" in refused(
        ["live", "learn", "--log", str(table), "--source", "f1"], capsys
    )
    assert "without ay, must be with ax, ay, yaw rate and speed" in refused(
        ["live", "learn", "--log", str(table)], capsys
    )


def test_emulated_moog_answers_over_the_network(capsys: pytest.CaptureFixture[str]):
    port = free_port()
    replies: list[bytes] = []

    def talk() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            one.settimeout(0.2)
            while len(replies) < 3:
                one.sendto(struct.pack(">I7f", 175, 0, 0, -0.1, 0, 0, 0, 0), ("127.0.0.1", port))
                try:
                    replies.append(one.recv(100))
                except TimeoutError:
                    continue
                except ConnectionRefusedError:
                    continue

    talker = threading.Thread(target=talk, daemon=True)
    talker.start()
    run(["live", "emulate", "moog", "--port", str(port), "--seconds", "1.5"])
    talker.join(5.0)
    assert len(replies) == 3
    assert {len(reply) for reply in replies} == {40}
    assert struct.unpack(">3I", replies[-1][:12]) == (0, 0, 0x22)  # standby, in DOF mode
    output = capsys.readouterr().err
    assert "standby" in output
    assert "watchdog" in output  # nobody sends any more
