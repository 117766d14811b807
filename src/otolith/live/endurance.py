"""A long run in virtual time: adversarial references and random faults, judged by code of its own.

The operator of this world re-arms, parks and engages as soon as it is allowed to, so that as much as possible
happens while the platform moves. What must not happen is counted: set-points beyond a limit or with a jump
(`otolith.live.audit`), exceptions that a core lets out, faults that the device finds by itself, and
compilations after arming.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.interfaces import Cueing
from otolith.live.audit import audit
from otolith.live.compilations import compiled
from otolith.live.faults.matrix import park_of
from otolith.live.messages import DeviceState, Flag, State, Word
from otolith.live.world import MS, World
from otolith.platforms import Platform

STRETCH: Final = 2.0  # [s] between looks of the operator, and of the judge
FAULT_EVERY: Final = 4.0  # [s] mean time between two faults
PIECE: Final = 3.0  # [s] of one kind of reference
LARGEST: Final = 15.0  # [m/s²] of a reference
STEEPEST: Final = 1.5  # [rad/s]


class Adversary:
    """A reference that changes its kind every few seconds: sines, steps, noise, a ramp, and nothing."""

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def __call__(self, t: float) -> Vec:
        """Return the wanted force and rate (6,) at a time [s]."""
        piece = int(t / PIECE)
        rng = np.random.default_rng((self._seed, piece))
        size = np.array([LARGEST] * 3 + [STEEPEST] * 3) * rng.random() ** 2 * rng.uniform(-1.0, 1.0, 6)
        since = t - piece * PIECE
        kind = int(rng.integers(5))
        if kind == 0:
            shape: Vec = np.sin(2.0 * np.pi * rng.uniform(0.05, 5.0, 6) * t)
        elif kind == 1:
            shape = np.where(since > rng.uniform(0.0, PIECE, 6), 1.0, -1.0)
        elif kind == 2:
            shape = np.random.default_rng((self._seed, int(1e3 * t))).uniform(-1.0, 1.0, 6)
        elif kind == 3:
            shape = np.full(6, since / PIECE)
        else:
            shape = np.zeros(6)
        return size * shape


@dataclass(slots=True)
class Account:
    """What happened, and what must not have."""

    seconds: float = 0.0
    set_points: int = 0
    decisions: int = 0
    engagements: int = 0
    restarts: int = 0  # after the supervisor had ended a session
    cued_seconds: float = 0.0
    fallbacks: int = 0  # decisions in whose place a fallback was published
    refused_plans: int = 0  # by the gate, in the controller
    refused_set_points: int = 0  # by the gate, in the output
    faults: Counter[str] = field(default_factory=Counter)  # injected
    violations: list[str] = field(default_factory=list)  # escapes of the gate
    exceptions: list[str] = field(default_factory=list)
    device_faults: list[str] = field(default_factory=list)  # that nobody injected
    compilations: int = 0

    @property
    def clean(self) -> bool:
        """Return whether nothing happened that must not."""
        return not (self.violations or self.exceptions or self.device_faults or self.compilations)


def endurance(
    cueing: Cueing,
    platform: Platform,
    seconds: float,
    *,
    seed: int = 0,
    tick: float = 1e-3,
    progress: Callable[[float], None] = lambda _: None,
) -> Account:
    """Run for a time [s], with a new fault every few seconds, and return the account.

    Parameters
    ----------
    tick : [s] of the output.
    """
    world = World(cueing, platform, drive=Adversary(seed), park=park_of(platform), seed=seed, tick=tick)
    account, rng = Account(), np.random.default_rng((seed, 1))
    injected: set[str] = set()
    _schedule(world, rng, account, injected)
    before = compiled()
    while world.seconds < seconds:
        try:
            world.run(min(seconds, world.seconds + STRETCH))
        except Exception as error:  # noqa: BLE001 (what a core lets out is what is looked for)
            account.exceptions.append(f"{type(error).__name__}: {error} at {world.seconds:.3f} s")
            break
        _operate(world, rng, account)
        _judge(world, platform, account, injected)
        progress(world.seconds / seconds)
    account.compilations = compiled() - before
    account.seconds = world.seconds
    _close(world, account)
    return account


def _close(world: World, account: Account) -> None:
    """Take over what the processes of a session have counted."""
    account.engagements += world.output.session.generation
    account.refused_plans += world.controller.refused
    account.refused_set_points += world.output.refusals


def _operate(world: World, rng: np.random.Generator, account: Account) -> None:
    """Say what an impatient operator says, and start anew what the supervisor has ended."""
    if world.latched:
        account.restarts += 1
        _close(world, account)
        world.restart()
        return
    words = {
        State.IDLE: (Word.ARM,),
        State.PARKED: (Word.REARM, Word.ARM),
        State.READY: (Word.REARM, Word.ENGAGE),
        State.FAULT: (Word.REARM,),
    }
    if rng.random() < 0.05:
        world.say(Word(rng.choice([word.value for word in Word])))
    elif world.state in words:
        world.say(*words[world.state])


def _judge(world: World, platform: Platform, account: Account, injected: set[str]) -> None:
    """Take account of the trace since the last judgement; its last two ticks begin the next."""
    trace = world.trace
    account.violations += [str(violation) for violation in audit(trace, platform)]
    account.set_points += len(trace) - 2
    account.decisions += sum(len(plan.stages) > 0 for plan in world.plans)
    account.fallbacks += sum(plan.outcome not in {"", "decided"} for plan in world.plans)
    cued = sum(row.state in {State.ENGAGED, State.HOLDING} for row in trace)
    account.cued_seconds += STRETCH * cued / len(trace)
    for name in world.device.faults:
        if name not in injected:
            account.device_faults.append(f"{name} at {world.seconds:.3f} s")
    del trace[:-2]
    world.plans.clear()
    world.output.session.events.clear()


def _schedule(world: World, rng: np.random.Generator, account: Account, injected: set[str]) -> None:
    """Let a fault happen after a random time, and the next one after it."""

    def happen() -> None:
        name = str(rng.choice(list(FAULTS)))
        account.faults[name] += 1
        FAULTS[name](world, rng, injected)
        _schedule(world, rng, account, injected)

    world.at(world.seconds + rng.exponential(FAULT_EVERY), happen)


Fault = Callable[[World, np.random.Generator, set[str]], None]


def _silence(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.silence("telemetry", float(rng.exponential(0.2)))


def _noise(world: World, rng: np.random.Generator, _: set[str]) -> None:
    link = world.links["telemetry"]
    link.loss, link.corruption, link.duplication, link.reordering = rng.random(4) * 0.3
    link.jitter_ns = int(rng.integers(20 * MS))


def _restart(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.source.sequence = int(rng.integers(2 * world.source.sequence + 1))
    world.source.clock_ns += int(rng.integers(-50, 50)) * 100 * MS


def _pause(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.source.flags = Flag(int(rng.integers(8)))
    world.at(world.seconds + rng.exponential(0.5), lambda: setattr(world.source, "flags", Flag.RUNNING))


def _slow(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.costs_ns = [int(rng.exponential(15 * MS)) for _ in range(int(rng.integers(1, 12)))]


def _hang(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.stop("controller", float(rng.exponential(0.05)))


def _late(world: World, rng: np.random.Generator, injected: set[str]) -> None:
    """Let the output hang for up to 12 ms, or now and then so long that the supervisor ends the session."""
    seconds = float(rng.uniform(0.0, 0.012))
    if rng.random() < 0.1:
        seconds = 0.2
        injected.add("watchdog")
    world.stop("output", seconds)


def _device(world: World, _: np.random.Generator, injected: set[str]) -> None:
    injected.add("watchdog")  # packets end after every fault
    world.device.fail(world.now_ns, "limit switch")
    injected.add("limit switch")


def _measure(world: World, rng: np.random.Generator, injected: set[str]) -> None:
    injected.add("watchdog")
    world.device.offset = rng.normal(0.0, 0.01, 6)
    world.at(world.seconds + 0.5, lambda: setattr(world.device, "offset", np.zeros(6)))


def _replies(world: World, rng: np.random.Generator, _: set[str]) -> None:
    world.silence("feedback", float(rng.exponential(0.1)))


def _state(world: World, rng: np.random.Generator, injected: set[str]) -> None:
    injected.add("watchdog")
    world.device.shown = DeviceState(rng.choice([state.value for state in DeviceState]))
    world.at(world.seconds + 0.1, lambda: setattr(world.device, "shown", None))


FAULTS: Final[dict[str, Fault]] = {
    "silence": _silence,
    "bad link": _noise,
    "restart": _restart,
    "flags": _pause,
    "slow steps": _slow,
    "controller hangs": _hang,
    "output hangs": _late,
    "device fails": _device,
    "measured pose off": _measure,
    "replies lost": _replies,
    "device state": _state,
}
