"""CPU time of a live decision in a warm loop and after a pause, and of the gate's judgement of a plan.

    python benchmarks/live_decision.py [--plans 60]

A decision is a tick of the live controller with one packet, with `predictive` on `davsi-4dof` in four axes.
`warm`: ticks one after the other, in a time that passes by itself. `after a pause`: each after 8 ms of sleep,
as in a session, which finds its caches cold. Plans are sines of 1.6 s that pass; the least of 20 counts.
To compare versions, call this script with the other tree's `src` in PYTHONPATH, in turns.
"""

import argparse
import gc
import time

import numpy as np

from otolith.cli.live_run import Choices
from otolith.live.controller import Controller, ControllerInbox
from otolith.live.core.gate import Gate
from otolith.live.messages import Plan, Report, State
from otolith.live.shell.virtual import driven, free_port
from otolith.platforms import load

STEP_NS, TICKS, FIRST = 8_333_333, 600, 50  # the first ticks are left out


def decisions(controller: Controller, pause: float) -> np.ndarray:
    """Return the thread CPU time [us] of every decision, each after a pause [s]."""
    now, spent, plan = time.monotonic_ns(), [], None
    for k in range(1, TICKS + 1):
        now += STEP_NS
        time.sleep(pause)
        packet = (now, driven(1e-9 * now, k))
        inbox = ControllerInbox(packets=(packet,), report=rests(now, plan))
        begin = time.thread_time_ns()
        plan = controller.tick(now, inbox)
        spent.append(1e-3 * (time.thread_time_ns() - begin))
    return np.array(spent[FIRST:])


def rests(now: int, plan: Plan | None) -> Report:
    """Return a report of an engaged platform at rest."""
    return Report(
        time_ns=now - 1_000_000,
        motion=np.zeros((3, 6)),
        state=State.ENGAGED,
        generation=1,
        follows=0 if plan is None else plan.sequence,
    )


def judgements(count: int) -> np.ndarray:
    """Return the thread CPU time [us] of the judgement of plans that pass."""
    platform = load("davsi-4dof")
    gate, rng = Gate(platform, lag=platform.actuators.lag_s, period=0.01), np.random.default_rng(0)
    spent: list[float] = []
    t = 0.01 * np.arange(160)[:, None]
    while len(spent) < count:
        size = gate.reach.command * rng.random(6) * rng.choice([0.1, 0.3, 0.6, 1.0])
        stages = size * np.sin(rng.uniform(1.0, 12.0, 6) * t + rng.uniform(0.0, 2.0 * np.pi, 6))
        times = []
        for _ in range(20):
            begin = time.thread_time_ns()
            passes = gate.plan(np.zeros((3, 6)), stages, 0.01).passes
            times.append(1e-3 * (time.thread_time_ns() - begin))
        if passes:
            spent.append(min(times))
    return np.array(spent)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plans", type=int, default=60)
    given = parser.parse_args()
    choices = Choices(cueing="predictive", platform="davsi-4dof", dofs="surge-pitch,sway-roll", tuning=None)
    controller = choices.between(free_port(), free_port()).session().controller()
    gc.freeze()
    gc.disable()
    decisions(controller, 0.0)
    found = {
        "decision, warm": decisions(controller, 0.0),
        "decision, after a pause of 8 ms": decisions(controller, 0.008),
        "gate, a plan of 1.6 s": judgements(given.plans),
    }
    print(f"{'thread CPU time [us]':34}{'median':>9}{'p99':>9}{'most':>9}")
    for what, times in found.items():
        print(f"{what:34}" + "".join(f"{np.percentile(times, share):9.1f}" for share in (50, 99, 100)))


if __name__ == "__main__":
    main()
