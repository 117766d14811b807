"""The controller's core: packets in, a plan out, once per tick. It owns no clock, no socket and no thread.

parse → health → reference → `Cueing.step` → the gate on the whole plan → where that fails, the fallbacks:
what is left of the plan before, then the way to rest. A plan is published at every tick, also where nothing
is cued: the output takes its absence for the controller's death.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import InputError, OtolithError
from otolith.core.frames import specific_force
from otolith.interfaces import Command, Cueing, PlatformState, Status
from otolith.live.core.felt_delay import FeltDelay
from otolith.live.core.gate import Gate, Verdict
from otolith.live.core.health import Condition, Health
from otolith.live.core.ladder import FAILURES, LATE, LATE_MOST, InARow, Reaction, strongest
from otolith.live.core.parameters import Parameters, Tuned
from otolith.live.core.reference import BLEND_BACK, FADE_IN, Cued, Fader, Observer, reference
from otolith.live.core.rollout import Rollout, ahead
from otolith.live.core.session import CUED
from otolith.live.messages import Plan, Report, Rung, Telemetry, Vitals
from otolith.live.wire.formats import OtherPacket

NOTHING: Final = frozen_array(np.full(3, np.nan))  # asked for
UNTRUSTED: Final = 1e-3  # residual of the optimality conditions from which an answer is none

Parse = Callable[[bytes], Telemetry]
Wanted = Callable[[Telemetry], Vec]


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerInbox:
    """What reached the controller since its last tick."""

    packets: tuple[tuple[int, bytes], ...] = ()  # (arrival [ns], bytes)
    report: Report | None = None  # the latest of the output
    missed: int = 0  # periods that the last tick took too long
    change: Parameters | None = None  # what whoever controls asks for from now on


@dataclass(slots=True)
class _Counters:
    """What ends cueing when it happens too often in a row."""

    failures: InARow = field(
        default_factory=lambda: InARow(FAILURES, Rung.RETURN, "decisions without a trusted answer")
    )
    late: InARow = field(default_factory=lambda: InARow(LATE_MOST, Rung.RETURN, "periods missed"))


def plain(telemetry: Telemetry) -> Vec:
    """Return what a source in our axes says should be felt (6,): specific force and angular rate.

    What a source does not send is zero; whether the map of its axes is right is not judged here.
    """
    force = np.zeros(3) if telemetry.acceleration is None else telemetry.acceleration
    rate = np.zeros(3) if telemetry.angular_rate is None else telemetry.angular_rate
    return np.concatenate([force, rate])


class Controller:
    """Decides one plan per tick.

    Parameters
    ----------
    cueing : any algorithm of the registry; it has decided once before it is handed over, so that nothing is
        compiled here.
    gate : of the platform, in the algorithm's own period.
    parse : makes a sample of a packet, or raises an error of `otolith.core.errors`.
    wanted : makes of a sample what should be felt (6,), in our axes: the axis map.
    tuned : how much of it is cued, and what else may change while it runs.
    """

    def __init__(
        self,
        cueing: Cueing,
        gate: Gate,
        *,
        parse: Parse,
        wanted: Wanted = plain,
        health: Health | None = None,
        tuned: Tuned | None = None,
    ) -> None:
        if getattr(cueing, "carriers", 1) > 1:
            bound = "one that leaves the base at rest: live operation drives the platform alone"
            raise InputError("the cueing algorithm", "one that moves a base", bound)
        self.health = Health() if health is None else health
        self.cueing, self._gate = cueing, gate
        self._parse, self.wanted = parse, wanted
        self.tuned = Tuned() if tuned is None else tuned
        self._observer, self._fader = Observer(), Fader()
        self._counters = _Counters()
        self._rollout = Rollout(gate)
        self._period_ns = round(1e9 * cueing.period)
        self._plan: Plan | None = None  # the latest that moves the platform
        self._sequence = 0
        self._generation = -1  # of the engagement that is cued
        self._rise = FADE_IN
        self._last_ns: int | None = None
        self._telemetry_ns = 0
        self.refused = 0  # plans that the gate did not let pass
        self.delay = FeltDelay()
        self.asked = NOTHING  # (3,) [m/s²] force that the last decision should let feel; NaN without one

    def tick(self, now_ns: int, inbox: ControllerInbox) -> Plan:
        """Decide one plan."""
        for arrival_ns, packet in inbox.packets:
            self._receive(arrival_ns, packet)
        condition = self.health.look(now_ns)
        late = self._counters.late.note(inbox.missed > 0, inbox.missed)
        dt = 0.0 if self._last_ns is None else 1e-9 * (now_ns - self._last_ns)
        self._last_ns = now_ns
        self.tuned.step(dt, inbox.change)
        report = inbox.report
        if report is None or report.state not in CUED:
            self._observer.reset() if condition.reaction.rung >= Rung.FADE else None
            self.asked = NOTHING
            self.delay.pause()
            return self._publish(now_ns, np.empty((0, 6)), condition, report, late)
        if report.generation != self._generation:
            self._engage(report)
        motion = ahead(self._rollout, report.motion, self._plan, (report.time_ns, now_ns))
        self.delay.felt(now_ns, specific_force(motion[2, :3], motion[0, 3:]))
        stages, outcome = self._decide(now_ns, motion, condition, dt)
        plan = self._publish(
            now_ns, stages, condition, report, late, self._counters.failures.reaction, outcome=outcome
        )
        self._plan = plan
        return plan

    def vitals(self, now_ns: int, missed: int) -> Vitals:
        """Return what is shown to whoever looks on; `missed` periods were too long since the beginning."""
        return Vitals(
            time_ns=now_ns,
            asked=self.asked,
            missed=missed,
            clock_ns=self.health.clock_ns,
            parameters=self.tuned.asked,
        )

    def _receive(self, arrival_ns: int, packet: bytes) -> None:
        try:
            telemetry = self._parse(packet)
            wanted = self.wanted(telemetry)
        except OtherPacket:  # sound, but without motion: it says nothing of the telemetry's health
            return
        except OtolithError:
            self.health.unreadable()
            return
        if self.health.take(arrival_ns, telemetry, wanted):
            self._observer.sample(arrival_ns, wanted)
            self.delay.wanted(arrival_ns, wanted)
            self._telemetry_ns = arrival_ns

    def _engage(self, report: Report) -> None:
        """Begin a new engagement from where the set-points are."""
        self._generation = report.generation
        self.cueing.reset(_state(report.motion))
        self._fader.reset()
        self._counters = _Counters()
        self._plan, self._rise = None, FADE_IN

    def _decide(self, now_ns: int, motion: Mat, condition: Condition, dt: float) -> tuple[Mat, str]:
        """Return stages that pass the gate from `motion`, and how they came about."""
        up = condition.reaction.rung < Rung.FADE and condition.healthy
        weight = self._fader.step(dt, up=up, rise=self._rise)
        if weight == 0.0:
            self._observer.reset()
            self._rise = FADE_IN if self._plan is None else BLEND_BACK
        if self._counters.late.count >= LATE:
            return self._fallback(now_ns, motion), "too late"
        cued = Cued(scale=self.tuned.now.scale)
        wanted = reference(self._observer, now_ns, cued, weight=weight, period=self.cueing.period)
        self.asked = wanted.specific_force
        try:
            command = self.cueing.step(_state(motion), wanted)
        except Exception as error:  # noqa: BLE001 (an algorithm may be anybody's; its failure must not stop us)
            self._counters.failures.note(True)
            return self._fallback(now_ns, motion), f"{type(error).__name__}: {error}"
        trusted = command.outcome.status is Status.DECIDED and command.outcome.residual <= UNTRUSTED
        self._counters.failures.note(not trusted)
        return self._passed(now_ns, motion, command)

    def _passed(self, now_ns: int, motion: Mat, command: Command) -> tuple[Mat, str]:
        """Return the command's stages if the gate lets them pass, else a fallback."""
        stages = np.vstack([command.acceleration[None], command.plan])
        if command.outcome.residual > UNTRUSTED:
            return self._fallback(now_ns, motion), f"residual {command.outcome.residual:.1e}"
        verdict = self._judge(motion, stages)
        if verdict.passes:
            return stages, str(command.outcome.status)
        self.refused += 1
        return self._fallback(now_ns, motion), f"gate: {verdict}"

    def _fallback(self, now_ns: int, motion: Mat) -> Mat:
        """Return what is left of the plan before if it still passes, else the way to rest."""
        if self._plan is not None:
            k = (now_ns - self._plan.time_ns) // self._period_ns
            left = self._plan.stages[k:]
            if len(left) and self._judge(motion, left).passes:
                return left
        return self._gate.rest(motion)

    def _judge(self, motion: Mat, stages: Mat) -> Verdict:
        return self._gate.plan(motion, stages, self.cueing.period)

    def _publish(
        self,
        now_ns: int,
        stages: Mat,
        condition: Condition,
        report: Report | None,
        *reactions: Reaction,
        outcome: str = "",
    ) -> Plan:
        reaction = strongest(condition.reaction, *reactions)
        self._sequence += 1
        return Plan(
            sequence=self._sequence,
            generation=-1 if report is None else report.generation,
            time_ns=now_ns,
            period_ns=self._period_ns,
            stages=stages,
            rung=reaction.rung,
            reason=reaction.reason,
            healthy=condition.healthy,
            telemetry_ns=self._telemetry_ns,
            outcome=outcome,
        )


def _state(motion: Mat) -> PlatformState:
    return PlatformState(pose=motion[0], twist=motion[1], acceleration=motion[2])
