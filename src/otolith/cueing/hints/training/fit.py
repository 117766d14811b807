"""Fits the three kinds of hints to a recording.

If a pair's reach is symmetric, a mirrored motion has mirrored rows. Its network then sees every decision
either as it was or mirrored, at random in every pass, and the table keeps one of both, for all pairs
together. A network learns only from the decisions that changed its pair's part of the working set, because it
is not used for the others.
"""

import importlib
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2
from scipy.spatial import cKDTree

from otolith.core.arrays import Bools, Ints, Mat, frozen_array
from otolith.core.errors import MissingExtra
from otolith.core.frames import Dof
from otolith.cueing.hints.coarse import Coarse, CoarseLaws
from otolith.cueing.hints.features import FEATURES, braking_forms, describe_all, mirror_signs
from otolith.cueing.hints.network import BOUND, Network
from otolith.cueing.hints.table import Table
from otolith.cueing.hints.training.recording import Recording
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform
from otolith.qp.stage import StageProblem

OnProgress = Callable[[str], None]
# (share of the passes, learning rate up to that share)
_RATES: Final = ((0.6, 2e-3), (0.85, 6e-4), (1.0, 1.2e-4))
_ROUNDS: Final = 8  # number of rounds in which the table grows
_SAMPLE: Final = 20_000  # number of questions on which the table is tested
_FAR: Final = 4  # number of different rows from which an entry's set counts as wrong
_LEAST_WEIGHT: Final = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How much effort fitting spends; the defaults take about a minute for the thesis's platform."""

    layers: tuple[int, ...] = (96, 64)  # widths of the hidden layers of each pair's network
    passes: int = 40  # passes over the decisions that changed the pair's rows
    batch: int = 256
    entries: int = 4000  # largest number of entries of the table
    levels: int = 12  # number of levels of adaptive washout weights, each with a coarse law
    seed: int = 0


QUICK: Final = Effort(layers=(16,), passes=3, entries=100, levels=2)


def is_symmetric(platform: Platform, pairs: Sequence[Dof]) -> bool:
    """Return whether every reach is symmetric, so that a mirrored motion is equally possible."""
    reaches = [limits.position for pair in pairs for limits in platform.limits(pair)]
    return all(low == -high for low, high in reaches)


def fit_network(
    platform: Platform,
    pairs: Sequence[Dof],
    settings: MpcSettings,
    p: int,
    *,
    recording: Recording,
    effort: Effort,
    progress: OnProgress,
) -> tuple[Network, float]:
    """Return the network of pair p, and its mean loss [nats per decision] in its last pass.

    Raises
    ------
    MissingExtra : scikit-learn is not installed.
    """
    classifier, pair = _classifier(effort), pairs[p]
    features, rows = _features(platform, pairs, recording), _rows(recording)
    own = _pair_of(Problem(platform, pairs, settings).structure, rows.shape[1]) == p
    asked = recording.changed(own)[recording.solved]
    of_pair = features[asked, FEATURES * p : FEATURES * (p + 1)]
    lesson = _Lesson(of_pair, rows[asked] * own, is_symmetric(platform, (pair,)), effort)
    return lesson.learn(classifier, pair.name, progress), float(classifier.loss_)


class _Lesson:
    """The training data of one pair's network: features (n, 15) and optimal rows (n, M·rows)."""

    def __init__(self, features: Mat, rows: NDArray[np.int8], symmetric: bool, effort: Effort) -> None:
        self._features, self._rows, self._effort = features, rows, effort
        self._sides = np.array([1, -1] if symmetric else [1], dtype=np.int8)
        self._mirror = mirror_signs(1) if symmetric else np.ones(FEATURES)
        self._outputs = _outputs(rows, both_sides=symmetric)
        self._mean = 0.5 * (1.0 + self._mirror) * features.mean(axis=0)
        self._deviation = np.maximum(np.sqrt(np.mean((features - self._mean) ** 2, axis=0)), 1e-9)

    def learn(self, classifier: Any, name: str, progress: OnProgress) -> Network:
        """Go through all data in as many passes as the effort states, mirrored at random."""
        passes, rng = self._effort.passes, np.random.default_rng(self._effort.seed)
        for number in range(passes):
            classifier.set_params(learning_rate_init=_rate((number + 1) / passes))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a single pass is not expected to converge
                classifier.fit(*self._turned(rng))
            progress(f"learning {name}: pass {number + 1} of {passes}, loss {classifier.loss_:.3f}")
        weights, biases = (
            tuple(frozen_array(layer, dtype=np.float32) for layer in of)
            for of in (classifier.coefs_, classifier.intercepts_)
        )
        return Network(
            frozen_array(self._mean), frozen_array(self._deviation), weights, biases, self._outputs
        )

    def _turned(self, rng: np.random.Generator) -> tuple[NDArray[np.float32], Bools]:
        """Return standardised features (n, 15) and active outputs (n, outputs), mirrored at random."""
        side = rng.choice(self._sides, (len(self._rows), 1))
        turned = np.where(side < 0, self._features * self._mirror, self._features)
        standard = np.clip((turned - self._mean) / self._deviation, -BOUND, BOUND).astype(np.float32)
        holds: Bools = self._rows[:, np.abs(self._outputs) - 1] * side == np.sign(self._outputs)
        return standard, holds


def _classifier(effort: Effort) -> Any:
    try:
        neural = importlib.import_module("sklearn.neural_network")
    except ModuleNotFoundError as error:
        raise MissingExtra(
            "learning a hint needs scikit-learn, which is not installed: pip install 'otolith[hint]'"
        ) from error
    return neural.MLPClassifier(
        effort.layers,
        batch_size=effort.batch,
        max_iter=1,
        warm_start=True,
        alpha=1e-6,
        random_state=effort.seed,
    )


def _rate(share: float) -> float:
    return next(rate for until, rate in _RATES if share <= until)


def _features(platform: Platform, pairs: Sequence[Dof], recording: Recording) -> Mat:
    """Return the features (solved, 15P)."""
    features = np.empty((len(recording), FEATURES * len(pairs)))
    describe_all(recording.x, recording.wanted, braking_forms(platform, pairs), features)
    return features[recording.solved]


def _rows(recording: Recording) -> NDArray[np.int8]:
    """Return the optimal sets (solved, M·rows)."""
    sets = recording.sets[recording.solved]
    return sets.reshape(len(sets), -1)


def _outputs(rows: NDArray[np.int8], *, both_sides: bool) -> Ints:
    """Return side · (1 + row) of every side that was ever active, or whose opposite side was."""
    upper, lower = (rows > 0).any(axis=0), (rows < 0).any(axis=0)
    if both_sides:
        upper = lower = upper | lower
    return np.concatenate([np.flatnonzero(upper) + 1, -np.flatnonzero(lower) - 1])


def _pair_of(problem: StageProblem, rows: int) -> Ints:
    """Return the index of the pair to which each of the first rows of the horizon belongs.

    Rows of the circle belong to no pair and have an index beyond the last.
    """
    P = problem.inputs // 2
    of_constant = np.argmax(problem.C != 0.0, axis=1) // (problem.states // P)
    of_stage = np.concatenate([of_constant, np.full(len(problem.varying), P), np.arange(2 * P) // 2])
    return np.asarray(np.resize(of_stage, rows), dtype=np.int64)


def fit_table(platform: Platform, pairs: Sequence[Dof], recording: Recording, effort: Effort) -> Table:
    """Return entries of the most frequent sets, then of questions with a wrong nearest entry (Hart, 1968)."""
    symmetric, rng = is_symmetric(platform, pairs), np.random.default_rng(effort.seed)
    done = recording.solved
    questions = np.hstack([recording.x, recording.wanted])[done]
    side = np.where(symmetric & (recording.wanted[done, 0] < 0.0), -1, 1)
    deviation = np.maximum(np.std(questions, axis=0), 1e-9)
    parameters = side[:, None] * questions / deviation
    rows = _rows(recording) * side[:, None].astype(np.int8)
    sets, which = np.unique(rows, axis=0, return_inverse=True)
    chosen = _entries(parameters, sets, which.ravel(), effort, rng)
    used, index = np.unique(which.ravel()[chosen], return_inverse=True)
    shape = recording.sets.shape[1:]
    return Table(deviation, parameters[chosen], index, sets[used].reshape(-1, *shape), symmetric)


def _entries(
    parameters: Mat, sets: NDArray[np.int8], which: Ints, effort: Effort, rng: np.random.Generator
) -> Ints:
    """Return which questions become entries."""
    frequent = np.argsort(-np.bincount(which))[: effort.entries // 4]
    order = rng.permutation(len(which))
    _, first = np.unique(which[order], return_index=True)  # a random question for every set
    chosen, sample = order[first[frequent]], order[:_SAMPLE]
    for _ in range(_ROUNDS):
        _, nearest = cKDTree(parameters[chosen]).query(parameters[sample])
        differ = np.count_nonzero(sets[which[chosen[nearest]]] != sets[which[sample]], axis=1)
        wrong = sample[differ >= _FAR]
        more = min(effort.entries // _ROUNDS, effort.entries - len(chosen), len(wrong))
        chosen = np.concatenate([chosen, rng.choice(wrong, more, replace=False)])
    return chosen


def fit_laws(
    platform: Platform,
    pairs: Sequence[Dof],
    settings: MpcSettings,
    recording: Recording,
    effort: Effort,
) -> CoarseLaws:
    """Return the regions of the coarse explicit laws that the recording visits."""
    levels = _levels(pairs, settings, recording, effort)
    nothing = tuple(np.empty((0, 7)) for _ in range(len(pairs) * len(levels)))
    laws = Coarse(CoarseLaws(levels, nothing), platform, pairs, settings)
    return CoarseLaws(levels, laws.visit(recording.x, recording.wanted))


def _levels(pairs: Sequence[Dof], settings: MpcSettings, recording: Recording, effort: Effort) -> Mat:
    """Return washout weights (levels, w): cluster centres of their logarithms, one level if constant."""
    states = recording.x.reshape(-1, 6)[:: 7 * len(pairs)]
    weights = np.array([[weight.at(x) for weight in settings.washout] for x in states])
    distinct: Mat = np.unique(np.maximum(weights, _LEAST_WEIGHT), axis=0)
    if len(distinct) <= effort.levels:
        return distinct
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an empty cluster is a level that is never nearest
        centres, _ = kmeans2(
            np.log(np.maximum(weights, _LEAST_WEIGHT)), effort.levels, seed=effort.seed, minit="++"
        )
    return np.asarray(np.exp(centres), dtype=np.float64)
