"""Every algorithm, plant and platform through outages of every kind: does it stop inside and come back?

    python benchmarks/outages.py [ALGORITHM ...]

A sine of 1 m/s² at 0.2 Hz, whose force reads NaN, inf, 1e7 m/s² or nothing at all for 0.01 to 10 s, and
again. Prints a line per combination: nodes beyond a hard limit, how far the rate of tilt passed its own, the
largest speed from 3 s after the beginning of the longest outage to its end, and the RMSE of the last 10 s
over that of the undisturbed run. `missing`: no decision comes, and the plant follows the last command's plan.
"""

import itertools
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from otolith import metrics, registry
from otolith.core.errors import InputError
from otolith.cueing.design import Design
from otolith.interfaces import Command, Cueing, PlatformState, Reference
from otolith.loop import Run, simulate
from otolith.loop.interrupted import Interrupted, Outage
from otolith.platforms import load
from otolith.scenarios import scenario

PLATFORMS, PLANTS = ("davsi", "davsi-4dof", "thesis"), ("ideal", "actuator", "hexapod")
KINDS = {"NaN": np.nan, "inf": np.inf, "1e7": 1e7, "missing": None}
SPANS = ((2.0, 2.01), (2.5, 2.55), (3.0, 3.3), (3.4, 3.5), (3.6, 4.6), (6.0, 16.0))
LAST, DURATION = 16.0, 56.0


class Silent:
    """Another algorithm that is not asked in given spans: its last command's plan is followed instead."""

    def __init__(self, cueing: Cueing, spans: Sequence[tuple[float, float]]) -> None:
        self._cueing, self._spans, self._decisions, self._followed = cueing, spans, 0, 0
        self._last: Command | None = None

    @property
    def period(self) -> float:
        return self._cueing.period

    def reset(self, state: PlatformState) -> None:
        self._decisions, self._followed, self._last = 0, 0, None
        self._cueing.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        now = self._decisions * self.period
        self._decisions += 1
        silent = any(start - 1e-9 <= now < end - 1e-9 for start, end in self._spans)
        if not silent or self._last is None:
            self._last, self._followed = self._cueing.step(state, reference), 0
            return self._last
        plan, k = self._last.plan, self._followed
        self._followed += 1
        return replace(self._last, acceleration=plan[k] if k < len(plan) else np.zeros(6))


def drive(cueing: Cueing, platform: str, plant: str) -> Run:
    of = load(platform)
    wanted = scenario(f"sine:amplitude=1,frequency=0.2,duration={DURATION:g}")
    moved = registry.PLANTS[plant].load()(of)
    step = 1e-3 if plant == "hexapod" else 0.01
    return simulate(cueing, moved, wanted, platform=of, dofs=("surge-pitch",), plant_period=step)


def last_error(run: Run) -> float:
    last = run.time > run.time[-1] - 10.0
    return float(np.sqrt(np.mean((run.felt_force - run.reference_force)[last, 0] ** 2)))


def judged(run: Run, without: Run) -> str:
    """One line's figures."""
    excesses = metrics.excesses(run)
    beyond = sum(one.violations for one in excesses if "tilt_rate" not in one.quantity)
    rate = np.degrees(max(one.at_nodes for one in excesses if "tilt_rate" in one.quantity))
    still = np.abs(run.twist[(run.time > LAST - 7.0) & (run.time <= LAST)]).max()
    return f"{beyond:6}  {rate:9.4f}  {still:9.1e}  {last_error(run) / last_error(without):7.4f}"


def main(algorithms: list[str]) -> None:
    print("platform    plant         algorithm          told     beyond  deg/s over  speed      last 10 s")
    for platform, plant, algorithm in itertools.product(PLATFORMS, PLANTS, algorithms):
        assumed = registry.CUEING[algorithm].plant
        on = assumed if plant == "ideal" else plant
        dead_time = registry.PLANTS[on].load()(load(platform)).dead_time
        try:
            cueing = registry.make_cueing(algorithm, Design(platform=load(platform)), dead_time=dead_time)
        except InputError as error:
            print(f"{platform:11} {on:13} {algorithm:18} {error}", flush=True)
            continue
        without = drive(cueing, platform, on)
        for kind, value in KINDS.items():
            broken: Cueing = Silent(cueing, SPANS)
            if value is not None:
                broken = Interrupted(cueing, [Outage(start=a, end=b, value=value) for a, b in SPANS])
            figures = judged(drive(broken, platform, on), without)
            print(f"{platform:11} {on:13} {algorithm:18} {kind:8} {figures}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or [name for name in registry.CUEING if not name.startswith("hybrid-l")])
