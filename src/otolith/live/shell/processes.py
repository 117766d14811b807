"""The two processes of a session: the controller and the output, each a loop around its core.

The only things here are clocks, sockets and shared memory; what is decided, the cores decide.
"""

import multiprocessing
import os
import signal
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.synchronize import Event
from typing import Any, Final

from otolith.core.errors import OtolithError
from otolith.live.axis_test import AxisTest, goal_of
from otolith.live.controller import ControllerInbox
from otolith.live.core.health import Count
from otolith.live.core.ladder import NO_REACTION, Reaction
from otolith.live.devices.driver import Driver, Request
from otolith.live.log import ControllerLog, OutputLog
from otolith.live.messages import Feedback, Report, Rung, SetPoint, State, Word
from otolith.live.output import Output, OutputInbox
from otolith.live.packed import (
    pack_plan,
    pack_report,
    pack_vitals,
    unpack_parameters,
    unpack_plan,
    unpack_report,
    unpack_words,
)
from otolith.live.session import Session
from otolith.live.shell.clock import Ticks
from otolith.live.shell.datagrams import LARGEST, opened, passed_on
from otolith.live.shell.memory import Channel
from otolith.live.shell.recorder import SharedRing, record_until, ring_of
from otolith.live.shell.rights import die_with_parent, take_rights
from otolith.live.shell.timing import ControllerTiming, OutputTiming

TICK_NS: Final = 1_000_000  # [ns] of the output
CONTROLLER, OUTPUT = 10, 20  # real-time priorities


def run_controller(session: Session, names: dict[str, str], ready: Event, said: Any, _: Any) -> None:
    """Be the controller, until the parent asks this process to end."""
    begin_child()
    controller = session.controller()  # which may compile for a minute; a signal ends it at once
    asked = asked_to_end()
    plans, reports, vitals, changes = (
        Channel(names[name]) for name in ("plans", "reports", "vitals", "changes")
    )
    said.put(("controller", *take_rights(CONTROLLER)))
    with (
        opened(session.listen[1], host=session.listen[0]) as listening,
        ring_of(names, "controller") as ring,
    ):
        forward = session.forward
        log = None if ring is None else ControllerLog(ring, lambda: _named(controller.health.counts))
        ready.set()
        period_ns = round(1e9 * session.period)
        last, missed = time.monotonic_ns(), 0
        report: Report | None = None
        timing = ControllerTiming()
        packets: tuple[tuple[int, bytes], ...] = ()
        while not asked:
            # A packet after a tick without one is answered at once; others at twice the rate at most.
            soonest = last + period_ns // 2 if packets else last
            packets = _until_due(listening, last, period_ns, soonest=soonest)
            if forward is not None:
                passed_on(listening, packets, forward)
            now, cpu = time.monotonic_ns(), time.thread_time_ns()
            plans.beat()
            message = reports.read()
            report = report if message is None else unpack_report(message)
            asked_for = changes.read()
            change = None if asked_for is None else unpack_parameters(asked_for)
            inbox = ControllerInbox(packets=packets, report=report, missed=missed, change=change)
            plan = controller.tick(now, inbox)
            plans.write(pack_plan(plan))
            vitals.write(pack_vitals(controller.vitals(now, timing.missed)))
            end = time.monotonic_ns()
            if log is not None:
                log.note(now, inbox, plan)
            missed = (end - now) // period_ns
            if len(plan.stages):
                timing.decisions += 1
                timing.missed += missed
                if packets:
                    timing.cpu.note(time.thread_time_ns() - cpu)
                    timing.plan.note(end - packets[-1][0])
            last = now
    timing.delay = str(controller.delay)
    said.put(("timing", timing))


def run_axis_test(
    axes: tuple[str, ...], session: Session, names: dict[str, str], ready: Event, said: Any, _: Any
) -> None:
    """Be the controller of an axis test, until the parent asks this process to end."""
    begin_child()
    asked = asked_to_end()
    goals = [goal_of(name, session.platform) for name in axes]
    test = AxisTest(goals, session.gate(), session.period)
    plans, reports = Channel(names["plans"]), Channel(names["reports"])
    said.put(("controller", *take_rights(CONTROLLER)))
    ready.set()
    report: Report | None = None
    for now in Ticks(round(1e9 * session.period)):
        if asked:
            return
        plans.beat()
        message = reports.read()
        report = report if message is None else unpack_report(message)
        plans.write(pack_plan(test.tick(now, report)))


def _until_due(
    listening: socket.socket, last: int, period_ns: int, *, soonest: int
) -> tuple[tuple[int, bytes], ...]:
    """Collect packets until one comes at `soonest` [ns] or later, or a period has passed since `last`."""
    packets: list[tuple[int, bytes]] = []
    while True:
        left = last + period_ns - time.monotonic_ns()
        if left <= 0:
            return tuple(packets)
        listening.settimeout(1e-9 * left)
        try:
            packet = listening.recv(LARGEST)
        except TimeoutError:
            return tuple(packets)
        now = time.monotonic_ns()
        packets.append((now, packet))
        if now >= soonest:
            return tuple(packets)


def run_recorder(_session: Session, names: dict[str, str], ready: Event, _said: Any, file: Any, /) -> None:
    """Be the recorder of the log, until the parent asks this process to end."""
    begin_child()
    record_until(asked_to_end(), names, ready, file.number)


def run_output(session: Session, names: dict[str, str], ready: Event, said: Any, _lock: Any) -> None:
    """Be the output: until it is asked to end, and the platform rests without power or in a fault.

    It keeps the lock of the device as long as it lives.
    """
    begin_child()
    output = session.output()
    asked = asked_to_end()
    said.put(("output", *take_rights(OUTPUT)))
    plans, reports, words = (Channel(names[name]) for name in ("plans", "reports", "words"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line, ring_of(names, "output") as ring:
        shared = _Shared(plans, reports, words, ring, session.settings.page_only)
        line.setblocking(False)
        line.connect(session.device)
        ready.set()
        _roll(output, _Line(line, session.driver), shared, asked, said)


class _Line:
    """The socket to the device; it never waits, and its errors become reactions."""

    def __init__(self, line: socket.socket, driver: Driver) -> None:
        self._line, self._driver = line, driver
        self.reaction = NO_REACTION

    def hear(self) -> Feedback | None:
        """Return the latest that the device reported, if anything came."""
        latest: Feedback | None = None
        while (packet := self._try(lambda: self._line.recv(LARGEST))) is not None:
            try:
                latest = self._driver.decode(packet)
            except OtolithError as error:
                self.reaction = Reaction(Rung.RETURN, str(error))
        return latest

    def send(self, set_point: SetPoint, request: Request) -> None:
        """Send the packet for a set-point; where the driver has nothing to say, none is sent."""
        try:
            packet = self._driver.encode(set_point, request)
        except OtolithError as error:  # no code for this pose: it is not sent in a lesser form
            self.reaction = Reaction(Rung.FAULT, str(error))
            return
        if packet:
            self._try(lambda: self._line.send(packet))

    def _try(self, action: Callable[[], Any]) -> Any:
        try:
            return action()
        except BlockingIOError:
            return None
        except ConnectionRefusedError:  # nobody listens there, yet: the same as silence
            return None
        except OSError as error:
            self.reaction = Reaction(Rung.FAULT, f"the line to the device: {error.strerror}")
            return None


@dataclass(frozen=True, slots=True)
class _Shared:
    """The memory that the output shares with others."""

    plans: Channel
    reports: Channel
    words: Channel
    ring: SharedRing | None  # of the log
    page_only: bool  # whether the signs of whoever speaks the words are watched


def _roll(output: Output, line: _Line, shared: _Shared, asked: list[int], said: Any) -> None:
    """Make one set-point per tick until asked to end and nothing moves any more."""
    plans, reports, words = shared.plans, shared.reports, shared.words
    ticks, told, parking = Ticks(TICK_NS), 0, False
    timing = OutputTiming(late=ticks.late)
    answered = 0
    log = None if shared.ring is None else OutputLog(shared.ring, lambda: _counts(output, ticks))
    for now in ticks:
        message, spoken = plans.read(), words.read()
        given = () if spoken is None else unpack_words(spoken)
        if asked and not parking:
            parking, given = True, (*given, Word.PARK)
        plan = None if message is None else unpack_plan(message)
        heard = line.hear()  # before its reaction is asked for
        inbox = OutputInbox(
            plan=plan,
            beats=plans.beats,
            feedback=heard,
            words=given,
            page=words.beats if shared.page_only else None,
            reaction=line.reaction,
        )
        out = output.tick(now, inbox)
        if line.reaction.rung is not Rung.FAULT or Word.REARM in given:
            line.reaction = NO_REACTION
        if out.set_point is not None:
            line.send(out.set_point, out.request)
        if plan is not None and out.report.follows == plan.sequence and plan.telemetry_ns > answered:
            answered = plan.telemetry_ns
            timing.answer.note(time.monotonic_ns() - answered)
        reports.write(pack_report(out.report))
        events = output.session.events[told:]
        if log is not None:
            log.note(now, inbox, out, events)
        if events:
            said.put(("event", *(f"{event.after}: {event.reason}" for event in events)))
            told += len(events)
        if asked and out.report.state in {State.IDLE, State.PARKED, State.FAULT}:
            reports.finish()
            timing.skipped = ticks.skipped
            said.put(("timing", timing))
            return
        timing.work.note(time.monotonic_ns() - now)


def _counts(output: Output, ticks: Ticks) -> dict[str, int]:
    """Return what the log counts of the output."""
    return {"skipped": ticks.skipped, "latest_ns": ticks.late.largest, "refusals": output.refusals}


def _named(counts: Mapping[Count, int]) -> dict[str, int]:
    """Return counts by their names, as the log writes them."""
    return {str(name): count for name, count in counts.items()}


def asked_to_end() -> list[int]:
    """Return a list that SIGTERM makes longer, so that a loop can end where it stands well."""
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: asked.append(number))
    return asked


def begin_child() -> None:
    """Let the session's parent decide about signals of the terminal, and go where it goes.

    Ctrl-Z, too: a session that stands still for a while is a fault, not a pause.
    """
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTSTP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    die_with_parent(signal.SIGTERM, os.getppid() if parent is None or parent.pid is None else parent.pid)
