"""What stands around a session of real processes: a driver, and a Moog base in software that is watched."""

import contextlib
import gc
import os
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from otolith.cli.live_run import Choices
from otolith.core.arrays import Vec
from otolith.live.devices.emulator import ENGAGED, HOME_WITHIN, IDLE, MoogEmulator
from otolith.live.session import Session
from otolith.live.shell.datagrams import LOCAL, opened, receive
from otolith.live.shell.virtual import RATE_HZ, driven, free_port

PATIENCE = 120.0  # [s] for a start with a cold compiler on a busy machine


def until(condition: Callable[[], bool], what: str, patience: float = PATIENCE) -> None:
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < patience, f"not within {patience:.0f} s: {what}"
        time.sleep(0.02)


def hurry(priority: int) -> None:
    """Let this thread wait for no other process, if that is granted; its children are scheduled as ever.

    The threads of a test share one interpreter: whichever holds it while another process has its processor
    would silence the base.
    """
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))


@dataclass
class Rig:
    """A base and a driver, each in a thread of the test."""

    telemetry: int = field(default_factory=free_port)
    device: int = field(default_factory=free_port)
    base: MoogEmulator = field(default_factory=MoogEmulator)
    states: list[int] = field(default_factory=list)  # of the base, in their order
    farthest: Vec = field(default_factory=lambda: np.zeros(6))  # of its poses
    packets: int = 0  # that reached it
    over: threading.Event = field(default_factory=threading.Event)
    before: tuple[int, os.sched_param] = field(
        default_factory=lambda: (os.sched_getscheduler(0), os.sched_getparam(0))
    )  # how the thread of the test is scheduled

    def __enter__(self) -> "Rig":
        self.base.cycle_power(time.monotonic_ns())
        gc.freeze()  # to look through all that earlier tests have left silences the base for 0.1 s and more
        hurry(5)
        self.threads = [threading.Thread(target=run, daemon=True) for run in (self._be_base, self._drive)]
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.over.set()
        for thread in self.threads:
            thread.join()
        os.sched_setscheduler(0, *self.before)
        gc.unfreeze()

    def _be_base(self) -> None:
        hurry(30)  # a base is never busy with anything else
        with opened(self.device) as listening:
            while not self.over.is_set():
                receive(listening, self._take, seconds=0.2, passed=self._look)

    def _take(self, packet: bytes, now_ns: int) -> bytes | None:
        self.packets += 1
        return self.base.receive(packet, now_ns)

    def _look(self, now_ns: int) -> None:
        self.base.tick(now_ns)
        if not self.states or self.states[-1] != self.base.state:
            self.states.append(self.base.state)
        low, high = self.base.envelope.low, self.base.envelope.high
        inside = (self.base.position >= low - HOME_WITHIN) & (self.base.position <= high + HOME_WITHIN)
        assert inside.all(), f"the base left its envelope: {self.base.position}"
        self.farthest = np.maximum(self.farthest, np.abs(self.base.position))

    def _drive(self) -> None:
        hurry(5)
        begin, sequence = time.monotonic(), 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            while not self.over.wait(1.0 / RATE_HZ):
                sequence += 1
                line.sendto(driven(time.monotonic() - begin, sequence), (LOCAL, self.telemetry))

    @property
    def urls(self) -> tuple[str, str]:
        return f"generic+udp://{LOCAL}:{self.telemetry}", f"moog+udp://{LOCAL}:{self.device}"

    def session(self) -> Session:
        incoming, outgoing = self.urls
        return Choices(
            incoming=incoming,
            outgoing=outgoing,
            cueing="classical",
            platform="davsi-4dof",
            dofs="surge-pitch,sway-roll",
            tuning="davsi",
        ).session()

    def moves(self) -> None:
        """Wait until the base is engaged and is moved: its surge has left neutral."""
        until(lambda: self.base.state == ENGAGED and self.farthest[0] > 5e-3, "the base is cued")

    def is_at_home(self) -> None:
        """Wait until the base rests without power where it began."""
        until(lambda: self.base.state == IDLE and not self.base.velocity.any(), "the base has parked", 30.0)
        assert np.abs(self.base.position).max() < 1e-3
