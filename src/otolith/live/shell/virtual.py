"""A driver and a Moog base in processes of their own, for showing a session without a game and a machine."""

import contextlib
import multiprocessing
import os
import socket
import time
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from otolith.live.devices.emulator import Envelope, MoogEmulator
from otolith.live.messages import Flag
from otolith.live.shell.datagrams import LOCAL, opened, receive
from otolith.live.shell.processes import begin_child
from otolith.live.wire.generic import TELEMETRY, seal
from otolith.platforms import Platform

RATE_HZ: Final = 60.0  # packets of the driver per second
NEUTRAL_HEAVE: Final = -0.2  # [m] the base's own heave at our neutral pose
BASE: Final = 5  # real-time priority, below those whose time is measured


def free_port() -> int:
    """Return a UDP port that nobody listens on."""
    with opened(0) as listening:
        return int(listening.getsockname()[1])


@contextlib.contextmanager
def surroundings(platform: Platform) -> Iterator[tuple[int, int]]:
    """Start a driver and a base that goes as far as a platform.

    Yields the port on which the driver's packets are wanted, and the base's.
    """
    telemetry, base = free_port(), free_port()
    context = multiprocessing.get_context("spawn")
    helpers = [
        context.Process(target=be_base, args=(base, Envelope.holding(platform, NEUTRAL_HEAVE)), daemon=True),
        context.Process(target=be_driver, args=(telemetry,), daemon=True),
    ]
    try:
        for helper in helpers:
            helper.start()
        yield telemetry, base
    finally:
        for helper in helpers:
            helper.kill()
            helper.join()


def base_at(port: int) -> dict[str, Any]:
    """Return the device of a session that drives this base."""
    return {
        "kind": "moog",
        "address": f"{LOCAL}:{port}",
        "interface": "CDS7237",
        "neutral_heave_m": NEUTRAL_HEAVE,
        "reach": "platform",
    }


def be_base(port: int, envelope: Envelope) -> None:
    """Be a Moog base in software, until this process is ended."""
    begin_child()
    with contextlib.suppress(OSError):  # a base has a processor of its own, which a busy host does not slow
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(BASE))
    base = MoogEmulator(envelope=envelope)
    with opened(port) as listening:
        base.cycle_power(time.monotonic_ns())
        receive(listening, base.receive, passed=base.tick)


def be_driver(port: int) -> None:
    """Be a vehicle that brakes, accelerates and turns, until this process is ended."""
    begin_child()
    begin, sequence = time.monotonic(), 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        while True:
            sequence += 1
            t = time.monotonic() - begin
            line.sendto(driven(t, sequence), (LOCAL, port))
            time.sleep(max(0.0, begin + sequence / RATE_HZ - time.monotonic()))


def driven(t: float, sequence: int) -> bytes:
    """Return the packet of a drive at a time [s]; speed is the integral of the longitudinal force."""
    omega = 2.0 * np.pi * 0.4
    return seal(
        TELEMETRY,
        {
            "sequence": (sequence,),
            "time": (time.monotonic_ns(),),
            "flags": (int(Flag.RUNNING),),
            "source": (0,),
            "specific force": (1.2 * np.sin(omega * t), 0.8 * np.sin(1.7 * omega * t), 0.0),
            "angular rate": (0.0, 0.0, 0.0),
            "attitude": (1.0, 0.0, 0.0, 0.0),
            "velocity": (20.0 - 1.2 / omega * np.cos(omega * t), 0.0, 0.0),
        },
    )
