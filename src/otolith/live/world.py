"""A world in virtual time: source, links, schedulers and a device around the two cores of live operation.

A test is a script of faults (`world.at(3.0, lambda: …)`) and assertions on the trace. Nothing sleeps, nothing
reads a clock, and equal seeds give equal traces, bit for bit.

The device here is ideal in everything but what a fault changes: it moves towards the set-point with a lag,
parks when packets end, and has its own envelope. It judges us, not we it: what it notes as violated was sent.
"""

import copy
import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.interfaces import Cueing, PlatformState
from otolith.live.controller import Controller, ControllerInbox
from otolith.live.core.device import Device
from otolith.live.core.gate import Gate
from otolith.live.core.health import Health
from otolith.live.core.ladder import NO_REACTION, Reaction
from otolith.live.core.parameters import Parameters
from otolith.live.core.session import Event
from otolith.live.core.watchdog import LOOK_NS, OUTPUT_NS, Silence
from otolith.live.devices.driver import Request
from otolith.live.links import Link, Source
from otolith.live.machines import IdealDevice, Machine
from otolith.live.messages import DeviceState, Feedback, Plan, Report, SetPoint, State, Word
from otolith.live.output import Output, OutputInbox, OutputOutbox
from otolith.live.recorder import EVERY_NS
from otolith.live.virtual_log import VirtualLog
from otolith.live.wire.generic import Generic
from otolith.platforms import Platform

SECOND: Final = 1_000_000_000  # [ns]
MS: Final = 1_000_000  # [ns]


@dataclass(frozen=True, slots=True)
class Row:
    """One tick of the output, as it is traced."""

    time_ns: int
    state: State
    reason: str  # of what only the operator ends
    motion: Mat  # (3, 6) of the set-point
    sent: bool  # whether set-points are sent
    moves: bool  # whether the device has to follow
    follows: int
    measured: Vec  # (6,) where the platform is
    reported: Vec  # (6,) where its latest reply says that it is
    device: DeviceState


@dataclass(slots=True)
class _Core:
    """When a core runs: the scheduler of the virtual machine."""

    stopped: bool = False
    not_before_ns: int = 0
    late_ns: int = 0  # by which every run comes late


class World:
    """Everything around the cores, moved by one queue of events.

    Parameters
    ----------
    cueing : has decided at least once, so that it compiles nothing here.
    drive : see `Source`.
    park : (6,) [m, rad] where the platform rests without power.
    tick : [s] of the output.
    device : an ideal one if none is given.
    """

    def __init__(
        self,
        cueing: Cueing,
        platform: Platform,
        *,
        drive: Callable[[float], Vec],
        park: Vec,
        seed: int = 0,
        tick: float = 1e-3,
        device: Machine | None = None,
    ) -> None:
        lag = platform.actuators.lag_s
        gate = Gate(platform, lag=lag, period=cueing.period)
        travel = Gate(platform, lag=lag, period=cueing.period, park=park)
        self.rng = np.random.default_rng(seed)
        self.now_ns = 0
        self.gate, self.travel = gate, travel
        self.source = Source(drive)
        self._park = np.asarray(park, dtype=np.float64)
        self.device: Any = IdealDevice(park=self._park) if device is None else device
        self.links = {name: Link() for name in ("telemetry", "device", "feedback")}
        self.cores = {name: _Core() for name in ("controller", "output", "supervisor", "source", "device")}
        self.costs_ns: list[int] = []  # of the controller's next steps
        self.trace: list[Row] = []
        self.plans: list[Plan] = []
        self.on_plan: Callable[[Plan], Plan] | None = None  # what becomes of a plan in the memory
        self.reaction: Reaction = NO_REACTION  # of the shell
        self.change: Parameters | None = None  # that the controller is asked for at its next tick
        self.log: VirtualLog | None = None
        self.page = 0  # signs of life of a page
        self.page_only = False  # whether it alone commands
        self._tick_ns, self._period_ns = round(1e9 * tick), round(1e9 * cueing.period)
        self._events: list[tuple[int, int, Callable[[], None]]] = []
        self._count = 0
        self._words: list[Word] = []
        self._begin(cueing)
        for beginning in (self._send, self._reply):
            self._after(0, beginning)

    def _begin(self, cueing: Cueing) -> None:
        """Start a session: its processes, and the memory between them."""
        self.controller = Controller(cueing, self.gate, parse=Generic().parse, health=Health())
        self.output = Output(self.gate, self.travel, Device.at(self._park))
        self.latched = ""  # why the supervisor has ended the session
        self._packets: list[tuple[int, bytes]] = []
        self._plan: Plan | None = None
        self._feedback: Feedback | None = None
        self._reported: Vec | None = None
        self._report: Report | None = None
        self._missed = self._beats = self._reports = 0
        self._silence = Silence(2 * LOOK_NS)
        for name, run in (
            ("output", self._output),
            ("controller", self._control),
            ("supervisor", self._supervise),
        ):
            self.cores[name] = _Core()
            self._after(0, run)

    # What a script says.

    def at(self, seconds: float, action: Callable[[], Any]) -> None:
        """Let something happen at a time [s]."""
        self._push(round(1e9 * seconds), action)

    def say(self, *words: Word) -> None:
        """Let the operator say something now."""
        self._words.extend(words)

    def silence(self, link: str, seconds: float) -> None:
        """Let a link drop everything from now on, for a time [s]."""
        self.links[link].silent_until_ns = self.now_ns + round(1e9 * seconds)

    def stop(self, core: str, seconds: float | None = None) -> None:
        """Stop a core from now on, for a time [s] or for good."""
        if seconds is None:
            self.cores[core].stopped = True
        else:
            self.cores[core].not_before_ns = self.now_ns + round(1e9 * seconds)

    def delay(self, core: str, late: float, seconds: float) -> None:
        """Let every run of a core come late by a time [s], from now on for a time [s]."""
        self.cores[core].late_ns = round(1e9 * late)
        self.at(self.seconds + seconds, partial(setattr, self.cores[core], "late_ns", 0))

    def record(self, log: VirtualLog) -> "World":
        """Log the session from now on."""
        self.log, self.cores["recorder"] = log, _Core()
        self._record()
        return self

    def command_by_page(self) -> None:
        """Let a page give a sign of life now, and every second until it is stopped."""
        self.cores.setdefault("page", _Core())
        if self._runs("page", self.command_by_page):
            self.page += 1
            self._after(SECOND, self.command_by_page)

    def run(self, until: float) -> "World":
        """Let the world go on until a time [s]."""
        end = round(1e9 * until)
        while self._events and self._events[0][0] <= end:
            self.now_ns, _, event = heapq.heappop(self._events)
            event()
        self.now_ns = max(self.now_ns, end)
        return self

    def restart(self) -> None:
        """Let the operator start the session anew after the supervisor has ended it, one second from now."""
        self._after(SECOND, partial(self._begin, self.controller.cueing))

    def again(self) -> "World":
        """Return a copy of this world that goes on by itself.

        The algorithm is shared, because not every one can be copied: it begins anew from where the platform
        is, and one of the worlds goes on at a time. What a script has announced must be over.
        """
        cueing = self.controller.cueing
        world = copy.deepcopy(self, {id(cueing): cueing})
        pose, twist, acceleration = self.output.motion
        cueing.reset(PlatformState(pose=pose, twist=twist, acceleration=acceleration))
        return world

    @property
    def state(self) -> State:
        """Return the state of the session."""
        return State.FAULT if self.latched else self.output.session.state

    @property
    def seconds(self) -> float:
        """Return the time [s]."""
        return 1e-9 * self.now_ns

    # What goes on by itself.

    def _push(self, time_ns: int, event: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._events, (max(time_ns, self.now_ns), self._count, event))

    def _after(self, span_ns: int, event: Callable[[], None]) -> None:
        self._push(self.now_ns + span_ns, event)

    def _runs(self, name: str, event: Callable[[], None]) -> bool:
        """Return whether a core runs now; if it is delayed, it runs later."""
        core = self.cores[name]
        if core.stopped:
            return False
        if self.now_ns < core.not_before_ns:
            self._push(core.not_before_ns, event)
            return False
        return True

    def _send(self) -> None:
        if not self._runs("source", self._send):
            return
        self._after(round(1e9 / self.source.rate_hz), self._send)
        self._transmit("telemetry", self.source.packet(self.now_ns))

    def _transmit(self, name: str, packet: bytes) -> None:
        link = self.links[name]
        for time_ns in link.times(self.now_ns, self.rng):
            content = link.content(packet, self.rng)
            self._push(time_ns, partial(self._arrive, content))

    def _arrive(self, packet: bytes) -> None:
        self._packets.append((self.now_ns, packet))

    def _control(self) -> None:
        if not self._runs("controller", self._control):
            return
        self._beats += 1
        inbox = ControllerInbox(
            packets=tuple(self._packets), report=self._report, missed=self._missed, change=self.change
        )
        self._packets.clear()
        self.change = None
        plan = self.controller.tick(self.now_ns, inbox)
        if self.log is not None:
            self.log.controller.note(self.now_ns, inbox, plan)
        cost = self.costs_ns.pop(0) if self.costs_ns else 300_000
        self._missed = cost // self._period_ns
        self._after(cost, partial(self._publish, plan))
        self._after(max(self._period_ns, cost), self._control)

    def _publish(self, plan: Plan) -> None:
        if not self.cores["controller"].stopped:
            self._plan = plan if self.on_plan is None else self.on_plan(plan)
            self.plans.append(plan)

    def _output(self) -> None:
        if not self._runs("output", self._output):
            return
        inbox = OutputInbox(
            plan=self._plan,
            beats=self._beats,
            feedback=self._feedback,
            words=tuple(self._words),
            page=self.page if self.page_only else None,
            reaction=self.reaction,
        )
        self._feedback = None
        self._words.clear()
        told = len(self.output.session.events)
        out = self.output.tick(self.now_ns, inbox)
        if self.log is not None:
            self.log.output.note(self.now_ns, inbox, out, self.output.session.events[told:])
        self._report = out.report
        self._reports += 1
        self._note(out)
        if out.set_point is not None:
            self._to_device(out.set_point, out.request)
        self._after(self._tick_ns + self.cores["output"].late_ns, self._output)

    def _record(self) -> None:
        if self.log is None or not self._runs("recorder", self._record):
            return
        self.log.recorder.tick(self.now_ns)
        self._after(EVERY_NS, self._record)

    def _supervise(self) -> None:
        """Watch the output; where it is silent, end the session."""
        if not self._runs("supervisor", self._supervise):
            return
        silent = self._silence.look(self.now_ns, self._reports)
        if silent <= OUTPUT_NS:
            self._after(LOOK_NS, self._supervise)
            return
        self.latched = f"the output has said nothing for {silent // MS} ms"
        session = self.output.session
        session.events.append(Event(self.now_ns, session.state, State.FAULT, self.latched))
        for name in ("output", "controller", "supervisor"):
            self.cores[name].stopped = True

    def _to_device(self, set_point: SetPoint, request: Request) -> None:
        for time_ns in self.links["device"].times(self.now_ns, self.rng):
            self._push(time_ns, partial(self.device.receive, time_ns, set_point, request))

    def _reply(self) -> None:
        if not self._runs("device", self._reply):
            return
        self.device.step(self.now_ns)
        self._after(round(1e9 / self.output.device.rate_hz), self._reply)
        feedback = self.device.feedback()
        if feedback is not None:
            for time_ns in self.links["feedback"].times(self.now_ns, self.rng):
                self._push(time_ns, partial(self._hear, feedback))

    def _hear(self, feedback: Feedback) -> None:
        self._feedback = feedback
        self._reported = feedback.pose

    def _note(self, out: OutputOutbox) -> None:
        self.trace.append(
            Row(
                time_ns=self.now_ns,
                state=out.report.state,
                reason=self.output.session.ladder.kept.reason,
                motion=out.report.motion,
                sent=out.sends,
                moves=self.output.moves_device,
                follows=out.report.follows,
                measured=self.device.pose,
                reported=self.device.pose if self._reported is None else self._reported,
                device=self.device.state,
            )
        )


def states(world: World) -> list[tuple[float, State, str]]:
    """Return the changes of state: time [s], state, and why."""
    return [(1e-9 * event.time_ns, event.after, event.reason) for event in world.output.session.events]


def arm_and_engage(world: World, at: float = 0.1) -> World:
    """Let the operator arm, and engage as soon as the platform is ready."""
    world.run(at)
    world.say(Word.ARM)
    while world.state is not State.READY and world.seconds < at + 30.0:
        world.run(world.seconds + 0.05)
    world.say(Word.ENGAGE)
    return world


def sines(forces: Mapping[int, tuple[float, float]]) -> Callable[[float], Vec]:
    """Return a drive of one sine per channel: channel -> amplitude [m/s², rad/s] and frequency [Hz]."""

    def drive(t: float) -> Vec:
        wanted = np.zeros(6)
        for channel, (amplitude, hertz) in forces.items():
            wanted[channel] = amplitude * np.sin(2.0 * np.pi * hertz * t)
        return wanted

    return drive
