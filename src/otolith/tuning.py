"""Constant washout weights, found by optimisation instead of by hand (thesis, Table 5.3).

With weights on given states, the implicit MPC cues every scenario. The objective is

    J = mean over scenarios of ln(RMSE(f) / RMS(f_ref)) + μ · RMS(travel) / reach,

the logarithm of the geometric mean of the relative errors, plus a price μ on the travel that is used: travel
that is not used is available for the next manoeuvre. J is minimised over the logarithms of the weights by the
simplex method of Nelder & Mead (Computer Journal 7, 1965), which needs no derivative, because J has kinks
where limits become active.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.core.jobs import Workers
from otolith.cueing.design import Design, implicit
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.interfaces import Cueing
from otolith.loop import simulate
from otolith.metrics import tracking_rmse, travel_rms
from otolith.plant import Ideal
from otolith.platforms import Platform
from otolith.scenarios import Scenario

DEAREST: Final = 1e3  # largest μ
TRAVEL_PRICE: Final = 0.5  # μ: half the reach in RMS counts as much as 28 % of error
BOUNDS: Final = (1e-4, 1e2)  # bounds of every weight
START: Final = 0.3  # initial value of every weight
FIRST_STEP: Final = 0.7  # initial size of the simplex, in decades
CLOSE: Final = 0.02  # size of the simplex at which it stops, in decades and in J


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuned:
    """The best weights that were found."""

    weights: Mapping[str, float]  # by state
    objective: float
    evaluations: int
    by_scenario: Mapping[str, tuple[float, float]]  # RMSE(f) [m/s²], RMS of the travel [m]

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "weights": dict(self.weights),
            "objective": self.objective,
            "evaluations": self.evaluations,
            "scenarios": {
                name: {"rmse": rmse, "travel_rms": travel}
                for name, (rmse, travel) in self.by_scenario.items()
            },
        }


def check_price(price: float) -> None:
    """Refuse a price μ of travel that is no number, or below zero, or so large that errors have no say."""
    if not 0.0 <= price <= DEAREST:
        raise InputError("--price", f"{price:g}", f"0 to {DEAREST:g}")


def tune(
    platform: Platform,
    states: Sequence[str],
    scenarios: Sequence[Scenario],
    *,
    evaluations: int = 40,
    price: float = TRAVEL_PRICE,
    jobs: int = 1,
    progress: Callable[[int, float], None] = lambda _, __: None,
) -> Tuned:
    """Tune constant weights on `states` of the surge-pitch pair.

    Parameters
    ----------
    price : μ.
    jobs : number of processes that share the scenarios; the result is the same.
    progress : is called with the number and J of each evaluation.

    Raises
    ------
    InputError : there is no scenario or no state, a state is unknown, there are too few evaluations for a
        simplex, or the price is none.
    """
    if not scenarios or not states:
        raise InputError("scenarios and states", "none", "at least one of each")
    if evaluations < len(states) + 1:
        raise InputError("evaluations", evaluations, f"at least {len(states) + 1}, a simplex")
    check_price(price)
    constant(dict.fromkeys(states, 0.0))  # refuses unknown states
    corner = np.full(len(states), math.log10(START))
    simplex = np.vstack([corner, corner + FIRST_STEP * np.eye(len(states))])
    if jobs > 1:
        _cueing(platform, dict.fromkeys(states, START))  # compiles what is missing, once for all processes
    with Workers(jobs, (platform, tuple(scenarios))) as workers:
        search = _Search(workers, platform, tuple(states), tuple(scenarios), price, progress)
        scipy.optimize.minimize(
            search.objective,
            corner,
            method="Nelder-Mead",
            bounds=[tuple(np.log10(BOUNDS))] * len(states),
            options={"initial_simplex": simplex, "maxfev": evaluations, "xatol": CLOSE, "fatol": CLOSE},
        )
    return search.best


def _cueing(platform: Platform, weights: Mapping[str, float]) -> Cueing:
    settings = MpcSettings(washout=constant(weights))
    return implicit(Design(platform=platform, dofs=(SURGE_PITCH,), mpc=settings))


def _cued(
    of: tuple[Platform, tuple[Scenario, ...]], item: tuple[Mapping[str, float], Sequence[int]]
) -> list[tuple[float, float]]:
    """Return error and travel of some scenarios, by number, cued with these weights."""
    (platform, scenarios), (weights, numbers) = of, item
    cueing, axis, found = _cueing(platform, weights), SURGE_PITCH.translation, []
    for number in numbers:
        scenario = scenarios[number]
        run = simulate(cueing, Ideal(), scenario, platform=platform, dofs=(SURGE_PITCH.name,))
        found.append((float(tracking_rmse(run)[axis]), float(travel_rms(run)[axis])))
    return found


def _shares(scenarios: Sequence[Scenario], jobs: int) -> list[list[int]]:
    """Return the numbers of the scenarios in shares that take about as long, the longest first."""
    shares: list[list[int]] = [[] for _ in range(min(jobs, len(scenarios)))]
    for k in sorted(range(len(scenarios)), key=lambda k: -scenarios[k].duration):
        min(shares, key=lambda share: sum(scenarios[i].duration for i in share)).append(k)
    return shares


class _Search:
    """Evaluates the objective and keeps the best weights."""

    def __init__(
        self,
        workers: Workers[tuple[Platform, tuple[Scenario, ...]]],
        platform: Platform,
        states: tuple[str, ...],
        scenarios: tuple[Scenario, ...],
        price: float,
        progress: Callable[[int, float], None],
    ) -> None:
        self._platform, self._states, self._scenarios = platform, states, scenarios
        self._workers, self._shares = workers, _shares(scenarios, workers.jobs)
        self._price, self._progress, self._count = price, progress, 0
        self.best = Tuned(weights={}, objective=math.inf, evaluations=0, by_scenario={})

    def objective(self, logarithms: Vec) -> float:
        """Return J for weights with these decimal logarithms."""
        self._count += 1
        weights = dict(zip(self._states, (10.0**logarithms).tolist(), strict=True))
        found = self._cued(weights)
        low, high = self._platform.limits(SURGE_PITCH)[0].position
        parts = [
            math.log(rmse / _size(scenario)) + self._price * 2.0 * travel / (high - low)
            for scenario, (rmse, travel) in zip(self._scenarios, found.values(), strict=True)
        ]
        J = float(np.mean(parts))
        if self.best.objective > J:
            self.best = Tuned(weights=weights, objective=J, evaluations=self._count, by_scenario=found)
        self._progress(self._count, J)
        return J

    def _cued(self, weights: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return error and travel of every scenario by name."""
        results = self._workers.each(_cued, [(weights, share) for share in self._shares])
        found = {
            k: one
            for share, of_share in zip(self._shares, results, strict=True)
            for k, one in zip(share, of_share, strict=True)
        }
        return {scenario.name: found[k] for k, scenario in enumerate(self._scenarios)}


def _size(scenario: Scenario) -> float:
    """Return the RMS of the wanted force [m/s²]."""
    t = np.arange(0.0, scenario.duration, 0.01)
    return float(np.sqrt(np.mean(scenario.specific_force(t)[:, 0] ** 2)))
