"""A small network per pair that predicts the pair's active rows from its features, with numpy and numba only.

A pair's rows depend almost only on its own motion: the limit circle, which concerns all pairs, is left to the
engine, and the cosine of the other tilt changes few rows. So each pair learns separately, and 2 and 4 DOF
learn in the same way.

Notation: h₀ the features, standardised and bounded; h_{l+1} = max(0, W_lᵀ h_l + b_l). The last layer has one
number per side of a row that was ever active in training, and the row is held at this side if the number is
positive. The layers were fitted as logistic regressions, so positive means more likely than not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec, frozen_array
from otolith.core.copying import copy_to
from otolith.core.jit import kernel
from otolith.cueing.hints.features import FEATURES, describe

Singles = NDArray[np.float32]
BOUND: Final = 8.0  # bound of a feature, in standard deviations


@dataclass(frozen=True, slots=True)
class Network:
    """Layers W (inputs, outputs) and b (outputs,), scaling of the features, and meaning of the outputs."""

    mean: Vec  # (15,)
    deviation: Vec  # (15,) positive
    weights: tuple[Singles, ...]
    biases: tuple[Singles, ...]
    outputs: Ints  # side · (1 + index of the row in the whole horizon) of each output

    @property
    def sizes(self) -> Ints:
        """Return the width of every layer, starting with the features."""
        return np.array([len(self.mean), *(len(b) for b in self.biases)], dtype=np.int64)

    @property
    def numbers(self) -> Singles:
        """Return all parameters in one vector for the kernel: mean, 1/deviation, and W, b of each layer."""
        layers = [part.ravel() for layer in zip(self.weights, self.biases, strict=True) for part in layer]
        return np.concatenate([self.mean, 1.0 / self.deviation, *layers]).astype(np.float32)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return plain arrays."""
        return {
            "sizes": self.sizes,
            "mean": self.mean,
            "deviation": self.deviation,
            "outputs": self.outputs,
            **{f"weight-{i}": w for i, w in enumerate(self.weights)},
            **{f"bias-{i}": b for i, b in enumerate(self.biases)},
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Network":
        """Restore from plain arrays.

        Raises
        ------
        ValueError : the arrays do not belong together.
        KeyError : an array is missing.
        """
        sizes = arrays["sizes"]
        layers = range(len(sizes) - 1)
        weights = tuple(frozen_array(arrays[f"weight-{i}"], dtype=np.float32) for i in layers)
        biases = tuple(frozen_array(arrays[f"bias-{i}"], dtype=np.float32) for i in layers)
        network = cls(
            frozen_array(arrays["mean"]),
            frozen_array(arrays["deviation"]),
            weights,
            biases,
            frozen_array(arrays["outputs"], dtype=np.int64),
        )
        fits = all(w.shape == (n, len(b)) for w, b, n in zip(weights, biases, sizes, strict=False))
        fits = fits and network.deviation.shape == network.mean.shape == (FEATURES,)
        if not fits or not np.array_equal(network.sizes, sizes) or len(network.outputs) != sizes[-1]:
            raise ValueError("the network's layers do not fit each other")
        return network


class Learned:
    """Evaluates the networks, one per pair, for the active rows of the problem to be solved."""

    def __init__(self, networks: Sequence[Network], braking: Mat, shape: tuple[int, int]) -> None:
        features = np.empty(FEATURES * len(braking))
        sizes = np.array([network.sizes for network in networks])
        numbers, outputs = (
            np.concatenate([getattr(network, name) for network in networks])
            for name in ("numbers", "outputs")
        )
        layers = np.empty(2 * int(sizes.max()), dtype=np.float32)
        self._given = (braking, numbers, sizes, outputs, features, layers)
        self._set = np.zeros((1, *shape), dtype=np.int64)
        self._rows = self._set.ravel()

    def reset(self) -> None:
        """Do nothing: there is no memory, and equal states give equal sets."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return a hint (1, M, rows), which is valid until the next call."""
        del plan
        expect(x, wanted, *self._given, self._rows)
        return self._set


@kernel
def expect(
    x: Vec,
    wanted: Vec,
    braking: Mat,
    numbers: Singles,
    sizes: Ints,
    outputs: Ints,
    features: Vec,
    layers: Singles,
    rows: Ints,
) -> None:
    """Write the rows (M·rows,) that the networks expect to be active: +1 upper side, −1 lower, 0 free.

    Parameters
    ----------
    numbers, sizes, outputs : those of all networks, one after the other; `sizes` is (P, layers).
    """
    describe(x, wanted, braking, features)
    rows[:] = 0
    at, first = 0, 0
    for p in range(len(sizes)):
        of_pair = features[FEATURES * p : FEATURES * (p + 1)]
        last = first + sizes[p, -1]
        at += expect_of_pair(of_pair, numbers[at:], sizes[p], outputs[first:last], layers, rows)
        first = last


@kernel
def expect_of_pair(
    features: Vec, numbers: Singles, sizes: Ints, outputs: Ints, layers: Singles, rows: Ints
) -> int:
    """Write the rows that one network expects, and return how many of the numbers belong to it."""
    n, half = sizes[0], len(layers) // 2
    h, following = layers[:half], layers[half:]
    for i in range(n):
        standard = (np.float32(features[i]) - numbers[i]) * numbers[n + i]
        h[i] = min(max(standard, np.float32(-BOUND)), np.float32(BOUND))
    at: int = 2 * n
    for layer in range(1, len(sizes)):
        m = sizes[layer]
        W, z = numbers[at : at + n * m], following[:m]
        copy_to(z, numbers[at + n * m : at + n * m + m])
        for i in range(n):
            if layer == 1 or h[i] > 0.0:  # negative values are cut off at zero
                add(h[i], W[i * m : i * m + m], z)
        at += n * m + m
        n = m
        h, following = following, h
    for j in range(n):
        if h[j] > 0.0:
            rows[abs(outputs[j]) - 1] = 1 if outputs[j] > 0 else -1
    return at


@kernel
def add(factor: float, line: Singles, to: Singles) -> None:
    """Add factor · line to `to`, in place."""
    for j in range(len(to)):
        to[j] += factor * line[j]
