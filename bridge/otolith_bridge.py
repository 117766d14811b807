"""Send the telemetry of iRacing, Assetto Corsa (also Competizione) or rFactor 2 to Otolith, from Windows.

    python otolith_bridge.py iracing --to 192.168.1.20:9100      (pip install pyirsdk)
    python otolith_bridge.py ac --to 192.168.1.20:9100
    python otolith_bridge.py rf2 --to 192.168.1.20:9100          (with the shared memory plugin; drive alone)

These games keep their telemetry in shared memory of the machine they run on. This program reads it and
sends Otolith's generic packet; it is one file and needs only Python 3.11.

**Untested.** It was never run beside a game. Tested are the packing of packets, against Otolith's parser,
and the reading of structures that were filled by hand from public descriptions. Not tested: that the
structures are where these descriptions say, the names of the memories, and every sign. Learn the axes
before anything moves (`otolith live record generic`, `otolith live learn`), and look at
docs/live-formats.md. What is known to be disputed: the order of Assetto Corsa's `accG` (lateral, vertical,
longitudinal is taken here). rFactor 2's memory lists all cars; the first is taken, which is yours only if
you drive alone.
"""

import argparse
import mmap
import socket
import struct
import sys
import time
import zlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

G = 9.80665  # [m/s²]
RUNNING, PAUSED, REPLAY = 1, 2, 4
IRACING, ASSETTO_CORSA, RFACTOR = 1, 2, 3  # source ids
Three = tuple[float, float, float]


class Sample(NamedTuple):
    """One instant: x forward, y left, z up, as far as the game's documents say."""

    stamp: float  # changes with every new sample of the game
    flags: int
    force: Three  # [m/s²] without the standing 1 g
    rate: Three  # [rad/s] roll, pitch, yaw
    velocity: Three  # [m/s]
    source: int


def packet(sample: Sample, sequence: int, time_ns: int) -> bytes:
    """Return Otolith's generic packet: 96 bytes, no attitude."""
    body = struct.pack(
        "<4s2HIQ2I", b"OTLM", 1, 96, sequence & 0xFFFFFFFF, time_ns, sample.flags, sample.source
    )
    body += struct.pack("<3f3f4f3f12x", *sample.force, *sample.rate, 0.0, 0.0, 0.0, 0.0, *sample.velocity)
    return body + struct.pack("<I", zlib.crc32(body))


def of_iracing(sdk: Mapping[str, Any]) -> Sample:
    """Return the sample of pyirsdk's variables; the vertical acceleration of iRacing holds 1 g."""
    flags = (RUNNING if sdk["IsOnTrack"] else PAUSED) | (REPLAY if sdk["IsReplayPlaying"] else 0)
    return Sample(
        stamp=float(sdk["SessionTime"]),
        flags=flags,
        force=(sdk["LongAccel"], sdk["LatAccel"], sdk["VertAccel"] - G),
        rate=(sdk["RollRate"], sdk["PitchRate"], sdk["YawRate"]),
        velocity=(sdk["VelocityX"], sdk["VelocityY"], sdk["VelocityZ"]),
        source=IRACING,
    )


def of_assetto_corsa(physics: bytes, graphics: bytes) -> Sample:
    """Return the sample of `acpmf_physics` (308 bytes of it) and of `acpmf_graphics` (8 bytes of it)."""
    (status,) = struct.unpack_from("<i", graphics, 4)  # 0 off, 1 replay, 2 live, 3 pause
    (number,) = struct.unpack_from("<i", physics, 0)
    (kmh,) = struct.unpack_from("<f", physics, 28)
    lateral, vertical, longitudinal = struct.unpack_from("<3f", physics, 44)  # in g
    pitch, yaw, roll = struct.unpack_from("<3f", physics, 296)
    return Sample(
        stamp=float(number),
        flags={1: REPLAY, 2: RUNNING}.get(status, PAUSED),
        force=(G * longitudinal, G * lateral, G * vertical),
        rate=(roll, pitch, yaw),
        velocity=(kmh / 3.6, 0.0, 0.0),
        source=ASSETTO_CORSA,
    )


def of_rfactor(memory: bytes) -> Sample | None:
    """Return the sample of the first car of rFactor 2; None without cars, or while it is written.

    The car's axes are taken as x left, y up, z backward, which are left-handed.
    """
    begun, ended, _, cars = struct.unpack_from("<2I2i", memory, 0)
    if begun != ended or cars < 1:
        return None
    (elapsed,) = struct.unpack_from("<d", memory, 16 + 12)
    vx, vy, vz, ax, ay, az = struct.unpack_from("<6d", memory, 16 + 184)
    wx, wy, wz = struct.unpack_from("<3d", memory, 16 + 304)
    return Sample(
        stamp=elapsed,
        flags=RUNNING,
        force=(-az, ax, ay),
        rate=(wz, -wx, -wy),
        velocity=(-vz, vx, vy),
        source=RFACTOR,
    )


def _memory(name: str, size: int) -> mmap.mmap:
    """Return a shared memory of Windows by its name."""
    return mmap.mmap(-1, size, tagname=name, access=mmap.ACCESS_READ)  # type: ignore[call-arg,unused-ignore]


def reader(game: str) -> Callable[[], Sample | None]:
    """Return what reads a game: a sample, or None while there is none."""
    if game == "iracing":
        import irsdk

        sdk = irsdk.IRSDK()

        def read() -> Sample | None:
            if not (sdk.is_initialized and sdk.is_connected) and not sdk.startup():
                return None
            sdk.freeze_var_buffer_latest()
            return of_iracing(sdk)

        return read
    if game == "ac":
        physics, graphics = _memory("Local\\acpmf_physics", 512), _memory("Local\\acpmf_graphics", 64)
        return lambda: of_assetto_corsa(physics[:512], graphics[:64])
    telemetry = _memory("$rFactor2SMMP_Telemetry$", 4096)
    return lambda: of_rfactor(telemetry[:4096])


def is_due(sample: Sample, last: Sample | None, silent: float) -> bool:
    """Return whether a sample is sent: it is new, or the game rests and says so ten times a second.

    A game that says it runs but brings nothing new stays silent, so that the receiver notices.
    """
    if last is None or sample.stamp != last.stamp or sample.flags != last.flags:
        return True
    return sample.flags != RUNNING and silent >= 0.1


def main() -> None:
    """Read and send until Ctrl-C."""
    options = argparse.ArgumentParser(description="Send a game's telemetry to Otolith.")
    options.add_argument("game", choices=["iracing", "ac", "rf2"])
    options.add_argument("--to", default="127.0.0.1:9100", metavar="HOST:PORT")
    options.add_argument("--rate", type=float, default=500.0, help="how often to look for new samples [Hz]")
    given = options.parse_args()
    if sys.platform != "win32":
        options.error("the shared memory of these games exists on Windows only")
    host, _, port = given.to.rpartition(":")
    if not host or not port.isdigit() or not given.rate > 0.0:
        options.error("--to must be HOST:PORT, and --rate above 0 Hz")
    read, sending = reader(given.game), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    last, sent, sequence = None, 0, 0
    while True:
        sample, now = read(), time.monotonic_ns()
        if sample is not None and is_due(sample, last, 1e-9 * (now - sent)):
            sending.sendto(packet(sample, sequence, now), (host, int(port)))
            last, sent, sequence = sample, now, sequence + 1
        time.sleep(1.0 / given.rate)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(0)
