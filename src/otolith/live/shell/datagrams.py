"""UDP sockets for what needs no real time: recording packets, and an emulator that answers."""

import contextlib
import socket
import time
from collections.abc import Callable
from typing import Final

from otolith.core.errors import InputError, OtolithError
from otolith.live.shell.ports import holders_of

LOCAL: Final = "127.0.0.1"
LARGEST: Final = 65_535  # [bytes]
WAIT: Final = 0.01  # [s] for a packet, before the time is told


class PortInUse(OtolithError):
    """Another program holds a UDP port, or the user may not open it."""

    def __init__(self, host: str, port: int, reason: str) -> None:
        holders = holders_of(port)
        who = f"it is held by {', '.join(holders)}" if holders else "is another program listening there?"
        advice = (
            "; let that program forward its packets to another port, or end it and let 'otolith live run "
            "--forward HOST:PORT' pass them on"
        )
        super().__init__(
            f"UDP port {port} on {host} cannot be opened: {reason}; {who}{advice if holders else ''}"
        )
        self.host, self.port = host, port


def opened(port: int, *, host: str = LOCAL) -> socket.socket:
    """Return a socket that receives on a port; port 0 lets the system choose.

    Raises
    ------
    InputError : the port is not one.
    PortInUse : it cannot be opened.
    """
    if not 0 <= port <= 65_535:
        raise InputError("UDP port", port, "0 to 65535")
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.bind((host, port))
    except OSError as error:
        made.close()
        raise PortInUse(host, port, error.strerror or str(error)) from error
    made.settimeout(WAIT)
    return made


def receive(
    listening: socket.socket,
    take: Callable[[bytes, int], bytes | None],
    *,
    seconds: float | None = None,
    passed: Callable[[int], None] | None = None,
) -> None:
    """Hand over every packet with the time of its arrival [ns], and send back what `take` returns.

    Parameters
    ----------
    seconds : after which it ends; None for no end.
    passed : is told the time [ns] about every 10 ms, packets or not.
    """
    begin = time.monotonic_ns()
    while seconds is None or time.monotonic_ns() - begin < seconds * 1e9:
        try:
            packet, sender = listening.recvfrom(LARGEST)
        except TimeoutError:
            packet, sender = b"", None
        now = time.monotonic_ns()
        if passed is not None:
            passed(now)
        if sender is not None and (answer := take(packet, now)) is not None:
            listening.sendto(answer, sender)


def passed_on(line: socket.socket, packets: tuple[tuple[int, bytes], ...], to: tuple[str, int]) -> None:
    """Send packets on to another program, which may be absent: nothing is waited for."""
    for _, packet in packets:
        with contextlib.suppress(OSError):  # nobody listens there now, or there is no room: it missed one
            line.sendto(packet, socket.MSG_DONTWAIT, to)
