"""The output's core: plans, feedback and the operator's words in, one set-point out per tick.

It owns the state machine, because it alone talks to the device, so it alone can park it. It rolls plans out,
hands every set-point to the gate, watches the controller, and watches the device. It owns no clock, no socket
and no thread: a shell, or a test, tells it the time.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import OtolithError
from otolith.live.core.device import Device, assumed
from otolith.live.core.gate import Gate, Verdict
from otolith.live.core.ladder import NO_REACTION, InARow, Lasting, Reaction, strongest
from otolith.live.core.moves import Move
from otolith.live.core.rollout import Rollout
from otolith.live.core.session import POWERED, Seen, Session
from otolith.live.core.watchdog import ControllerWatch, PageWatch
from otolith.live.devices.driver import Request, judged
from otolith.live.messages import DeviceState, Feedback, Plan, Report, Rung, SetPoint, State, Word

MS: Final = 1_000_000  # [ns]
GAP: Final = 1000 * MS  # between two ticks: the machine was suspended, and the device's watchdog has acted
LONGEST_STEP: Final = 5e-3  # [s] that the motion advances at once
ALIKE: Final = np.array([1e-3] * 3 + [np.radians(0.1)] * 3)  # first set-point and measured pose [m, rad]
REFUSALS: Final = 10  # plans in a row that the gate refuses
LASTS: Final = 100 * MS  # a deviation or a silence of the device that is a reaction
OUTSIDE: Final = np.array([20e-3] * 3 + [np.radians(2.0)] * 3)  # [m, rad] beyond the reach that is R4


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputInbox:
    """What reached the output since its last tick."""

    plan: Plan | None = None  # the latest
    beats: int = 0  # decisions that the controller has begun
    feedback: Feedback | None = None  # the latest
    words: tuple[Word, ...] = ()
    page: int | None = None  # signs of life of the page that alone commands; None where others do, too
    reaction: Reaction = NO_REACTION  # of whoever else watches, such as the line to the device


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputOutbox:
    """What the output says in one tick."""

    set_point: SetPoint | None  # to be sent now; None between the packets of the device's rate
    sends: bool  # False: set-points have ended, so that the device's own watchdog acts
    request: Request
    report: Report


class Output:
    """Makes one set-point per tick.

    Parameters
    ----------
    gate : of cueing. travel : of the moves from and to the park pose; its reach contains that pose.
    token : names the session.
    forbids : why the platform must not be armed; empty if it may be.
    """

    def __init__(
        self, gate: Gate, travel: Gate, device: Device, *, token: int = 0, forbids: str = ""
    ) -> None:
        self.session, self.device = Session(), device
        self._gate, self._travel, self._token, self.forbids = gate, travel, token, forbids
        self._rollout = Rollout(gate)
        self._rollout.place(device.park)
        self._move: Move | None = None
        self._move_s = 0.0  # [s] of the move that have passed
        self._plan: Plan | None = None
        self._watch, self._page = ControllerWatch(), PageWatch()
        self._followed = -1
        self._feedback = Feedback()
        self._feedback_ns: int | None = None
        self._last_ns: int | None = None
        self._sequence = 0
        self._arrived_ns = 0  # when the move ended, and the device's own begins
        self._brought = False  # the device is engaged by us, and has to follow
        self._refused = -1  # sequence of the plan that the gate refused last
        self._refusals = InARow(REFUSALS, Rung.RETURN, "plans refused by the gate")
        self._strays = Lasting(LASTS, Rung.RETURN, "the measured pose differs from the set-point")
        self._reached = NO_REACTION  # reaction to the motion of the last tick
        self.refusals = 0  # set-points that the gate did not let pass
        self.last_refusal = Verdict()

    @property
    def motion(self) -> Mat:
        """Return a copy of pose, twist and acceleration (3, 6) of the set-points."""
        return self._rollout.motion.copy()

    def tick(self, now_ns: int, inbox: OutputInbox) -> OutputOutbox:
        """Make one set-point."""
        dt_ns = 0 if self._last_ns is None else now_ns - self._last_ns
        gap = Reaction(Rung.FAULT, f"no tick for {dt_ns // MS} ms") if dt_ns > GAP else NO_REACTION
        page = self._page.look(now_ns, inbox.page)
        due = self._is_due(now_ns)
        self._last_ns = now_ns
        self._receive(now_ns, inbox)
        before = self.session.state
        seen = Seen(
            words=inbox.words,
            reaction=strongest(gap, page, inbox.reaction, self._reached, self._of_device(now_ns)),
            cueing=self._of_controller(now_ns, inbox.beats),
            brought=self._brought,
            passed_checks=before is State.CHECKING and self._check(now_ns),
            done=self._is_done(before),
            healthy=self._plan is not None and self._plan.healthy,
            parked="parked" if self.device.reports else "commanded to park; the device reports nothing",
        )
        state = self.session.step(now_ns, seen)
        if state is not before:
            self._enter(state)
        self._reached = self._go_on(now_ns, 1e-9 * dt_ns)
        self._sequence += 1
        sends = state is not State.FAULT or self.device.on_silence == "falls"
        return OutputOutbox(
            set_point=self._set_point(now_ns) if sends and due else None,
            sends=sends,
            request=self._request(),
            report=self._report(now_ns),
        )

    # What arrives.

    def _receive(self, now_ns: int, inbox: OutputInbox) -> None:
        if not self.device.reports:
            rests_ns = now_ns - self._arrived_ns if self._arrived else None
            state = assumed(self.session.state, now_ns - self.session.since_ns, rests_ns)
            self._feedback, self._feedback_ns = Feedback(state=state), now_ns
        elif inbox.feedback is not None:
            self._feedback, self._feedback_ns = judged(inbox.feedback, self._token), now_ns
        plan = inbox.plan
        if plan is not None and (self._plan is None or plan.sequence > self._plan.sequence):
            self._plan = plan

    def _of_controller(self, now_ns: int, beats: int) -> Reaction:
        plan = self._plan
        dead = self._watch.look(now_ns, beats, plan)
        if plan is None or dead.rung is not Rung.NONE:
            return dead
        return strongest(Reaction(plan.rung, plan.reason), self._refusals.reaction)

    def _of_device(self, now_ns: int) -> Reaction:
        """Return the reaction to what the device reports, in states in which it matters."""
        state, found = self.session.state, self._feedback
        if state not in POWERED:
            return NO_REACTION
        if found.faults:
            return Reaction(Rung.FAULT, f"the device reports: {', '.join(found.faults)}")
        if self.moves_device and found.state is not DeviceState.ENGAGED:
            return Reaction(Rung.FAULT, f"the device is {found.state}, not engaged")
        age = now_ns - (self._feedback_ns or 0)
        if age > LASTS:
            return Reaction(Rung.RETURN, f"no reply from the device for {age // MS} ms")
        return self._of_pose(now_ns) if self.moves_device else NO_REACTION

    def _of_pose(self, now_ns: int) -> Reaction:
        measured, bounds = self._feedback.pose, self._travel.bounds
        if measured is None:
            return NO_REACTION
        if not bool(np.all((measured >= bounds.low - OUTSIDE) & (measured <= bounds.high + OUTSIDE))):
            return Reaction(Rung.FAULT, "the measured pose is outside the platform's reach")
        motion = self._rollout.motion
        allowed = self.device.band + self.device.lag_s * np.abs(motion[1])
        return self._strays.note(bool(np.any(np.abs(measured - motion[0]) > allowed)), now_ns)

    # What a state begins with, does, and ends with.

    @property
    def moves_device(self) -> bool:
        """Whether the device is engaged and has to follow the set-points."""
        return self._brought and not (self.session.state is State.PARKING and self._arrived)

    @property
    def _arrived(self) -> bool:
        return self._move is not None and self._move_s >= self._move.duration

    def _check(self, now_ns: int) -> bool:
        """Return whether the device can be engaged; refuse it with the reason if it cannot."""
        found = self._feedback
        if self.forbids:
            self.session.give_up(now_ns, self.forbids)
            return False
        if self._feedback_ns is None or now_ns - self._feedback_ns > LASTS:
            if now_ns - self.session.since_ns > LASTS:
                self.session.give_up(now_ns, "the device does not answer")
            return False
        if found.faults or found.state in {DeviceState.FAULT, DeviceState.UNKNOWN, DeviceState.OFF}:
            self.session.give_up(
                now_ns, f"the device is {found.state}: {', '.join(found.faults) or 'no fault'}"
            )
            return False
        try:
            self._begin_move(np.zeros(6))
        except OtolithError as error:
            self.session.give_up(now_ns, str(error))
            return False
        return True

    def _begin_move(self, goal: Vec) -> None:
        """Begin a move from where the platform is measured to be, or from the set-point where it moves."""
        if self.session.state in {State.CHECKING, State.ENGAGING}:
            self._place_where_measured()
            self._rollout.gate = self._travel
        self._move = Move(self._rollout.motion, goal, self._rollout.gate)
        self._move_s = 0.0

    def _place_where_measured(self) -> None:
        """Let the set-points be where the platform is, at rest; while nothing follows them."""
        measured = self._feedback.pose
        self._rollout.place(self.device.park if measured is None else measured)

    def _is_done(self, state: State) -> bool:
        if state is State.PARKING:
            return self._arrived and self._is_parked()
        return state in {State.ENGAGING, State.RETURNING} and self._arrived

    def _is_parked(self) -> bool:
        """Return whether the device says so, or is measured to be there without power."""
        found = self._feedback
        if found.state in {DeviceState.IDLE, DeviceState.STANDBY, DeviceState.OFF}:
            return True
        at = found.pose is not None and bool(
            np.all(np.abs(found.pose - self.device.park) <= self.device.band)
        )
        return at and found.state is not DeviceState.ENGAGED and found.state is not DeviceState.PARKING

    def _enter(self, state: State) -> None:
        """Prepare what a state does; the motion itself goes on where it is."""
        self._followed = -1
        if state in {State.IDLE, State.PARKED, State.FAULT}:
            self._brought = False
        if state is State.READY:
            self._rollout.gate = self._gate
            self._refusals.note(False)
        if state in {State.ENGAGING, State.RETURNING, State.PARKING, State.FAULT}:
            self._move = None

    def _go_on(self, now_ns: int, dt: float) -> Reaction:
        """Let the motion advance by dt [s] as the state demands."""
        match self.session.state:
            case State.ENGAGING:
                return self._engage(now_ns, dt)
            case State.ENGAGED | State.HOLDING:
                return self._cue(now_ns, dt)
            case State.RETURNING:
                return self._ease(np.zeros(6), dt)
            case State.PARKING:
                return self._park(now_ns, dt)
            case State.FAULT:
                self._rollout.brake(dt)
            case State.READY | State.CHECKING | State.IDLE | State.PARKED:
                self._rollout.motion[1:] = 0.0
        return NO_REACTION

    def _engage(self, now_ns: int, dt: float) -> Reaction:
        """Wait for the device, then rise to neutral from where it is measured to be."""
        if self._brought:
            return self._on_the_move(dt)
        if self._feedback.state is DeviceState.ENGAGED:
            self._brought = True
            return self._try_move(np.zeros(6))
        self._place_where_measured()
        if now_ns - self.session.since_ns > self.device.engages_ns:
            self.session.give_up(now_ns, self._too_slow("engage"))
        return NO_REACTION

    def _park(self, now_ns: int, dt: float) -> Reaction:
        """Ease to the park pose, then let the device park itself."""
        if not self._arrived:
            self._rollout.gate = self._travel
            self._arrived_ns = now_ns
            return self._ease(self.device.park, dt)
        if now_ns - self._arrived_ns > self.device.engages_ns:
            return Reaction(Rung.FAULT, self._too_slow("park"))
        return NO_REACTION

    def _too_slow(self, what: str) -> str:
        seconds, found = 1e-9 * self.device.engages_ns, self._feedback
        return f"the device did not {what} within {seconds:.0f} s; it is {found.state}"

    def _ease(self, goal: Vec, dt: float) -> Reaction:
        """Brake to rest, then move to a pose."""
        if self._move is not None:
            return self._on_the_move(dt)
        if not self._rollout.rests:
            self._rollout.brake(dt)
            return NO_REACTION
        return self._try_move(goal)

    def _try_move(self, goal: Vec) -> Reaction:
        try:
            self._begin_move(goal)
        except OtolithError as error:
            return Reaction(Rung.FAULT, str(error))
        return NO_REACTION

    def _on_the_move(self, dt: float) -> Reaction:
        """Advance along the move, each set-point through the gate."""
        move = self._move
        if move is None:
            return NO_REACTION
        self._move_s += dt
        motion = np.empty((3, 6))
        move.at(self._move_s, motion)
        verdict = self._rollout.gate.point(motion, self._rollout.motion, dt)
        if not verdict.passes:
            self._note(verdict)
            return Reaction(Rung.FAULT, f"a move left the limits: {verdict}")
        self._rollout.motion[:] = motion
        return NO_REACTION

    def _cue(self, now_ns: int, dt: float) -> Reaction:
        """Follow the plan; where it has no stage for now, or the gate refuses it, the way to rest."""
        plan, self._followed = self._plan, -1
        usable = plan is not None and plan.generation == self.session.generation and len(plan.stages) > 0
        done = 0.0
        while dt - done > 1e-9:
            step = min(LONGEST_STEP, dt - done)
            at_ns = now_ns - round(1e9 * (dt - done))
            command = plan.command(max(at_ns, plan.time_ns)) if usable and plan is not None else None
            if command is None or plan is None or plan.sequence == self._refused:
                self._rollout.brake(step)
            else:
                self._followed = plan.sequence
                verdict = self._rollout.follow(command, step)
                if not verdict.passes:
                    self._note(verdict)
                    self._refused, self._followed = plan.sequence, -1
                self._refusals.note(not verdict.passes)
            done += step
        return NO_REACTION

    def _note(self, verdict: Verdict) -> None:
        self.refusals += 1
        self.last_refusal = verdict

    # What leaves.

    def _is_due(self, now_ns: int) -> bool:
        """Return whether a packet of the device's own rate falls between the last tick and this one."""
        if self._last_ns is None:
            return True
        rate = 1e-9 * self.device.rate_hz
        return int(now_ns * rate) != int(self._last_ns * rate)

    def _set_point(self, now_ns: int) -> SetPoint:
        state, motion = self.session.state, self._rollout.motion
        if state in {State.IDLE, State.CHECKING, State.PARKED}:
            self._place_where_measured()
        return SetPoint(
            sequence=self._sequence,
            time_ns=now_ns,
            pose=motion[0],
            twist=motion[1],
            acceleration=motion[2],
            state=state,
            token=self._token,
        )

    def _request(self) -> Request:
        state = self.session.state
        if state is State.IDLE and self._feedback.state is DeviceState.FAULT:
            return Request.RESET
        if state is State.IDLE and self._feedback.state is DeviceState.ENGAGED:
            return Request.PARK  # it engaged after we had given up
        if state is State.ENGAGING and not self._brought:
            return Request.ENGAGE
        if state is State.PARKING and self._arrived:
            powered = self._feedback.state in {DeviceState.ENGAGED, DeviceState.STANDBY}
            return Request.PARK if powered else Request.HOLD
        return Request.MOVE if state in POWERED or state is State.FAULT else Request.HOLD

    def _report(self, now_ns: int) -> Report:
        return Report(
            time_ns=now_ns,
            motion=self._rollout.motion,
            state=self.session.state,
            generation=self.session.generation,
            follows=self._followed,
            measured=self._feedback.pose,
        )
