"""The network's kernel against matrix products, and its arrays there and back."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints.features import FEATURES, braking_forms, describe
from otolith.cueing.hints.network import BOUND, Learned, Network
from otolith.platforms import load

SHAPE = (5, 9)


def random_network(rng: np.random.Generator, layers: tuple[int, ...], *, first: int = 1) -> Network:
    """Its outputs are rows from the number `first` on."""
    sizes = (FEATURES, *layers)
    named = rng.choice(np.arange(first, first + 22), sizes[-1], replace=False) * rng.choice(
        [-1, 1], sizes[-1]
    )
    return Network(
        rng.normal(size=sizes[0]),
        rng.uniform(0.5, 2.0, sizes[0]),
        tuple(rng.normal(size=pair).astype(np.float32) for pair in itertools.pairwise(sizes)),
        tuple(rng.normal(size=n).astype(np.float32) for n in layers),
        named.astype(np.int64),
    )


@given(seed=st.integers(0, 10_000), pairs=st.sampled_from([1, 2]), hidden=st.sampled_from([(), (7,), (8, 5)]))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_the_kernel_is_the_matrix_product(seed: int, pairs: int, hidden: tuple[int, ...]) -> None:
    rng = np.random.default_rng(seed)
    networks = [random_network(rng, (*hidden, 12), first=1 + 22 * p) for p in range(pairs)]
    forms = braking_forms(load("thesis"), (SURGE_PITCH, SWAY_ROLL)[:pairs])
    x, wanted = rng.normal(size=6 * pairs), 3.0 * rng.normal(size=pairs)
    features = np.empty(FEATURES * pairs)
    describe(x, wanted, forms, features)
    expected, clear = np.zeros(45), np.ones(45, dtype=bool)
    for p, network in enumerate(networks):
        of_pair = features[FEATURES * p : FEATURES * (p + 1)]
        h = np.clip((of_pair - network.mean) / network.deviation, -BOUND, BOUND)
        for number, (W, b) in enumerate(zip(network.weights, network.biases, strict=True)):
            h = (np.maximum(h, 0.0) if number else h) @ W.astype(np.float64) + b
        at = np.abs(network.outputs) - 1
        expected[at] = np.where(h > 0.0, np.sign(network.outputs), 0)
        clear[at] = np.abs(h) > 1e-3  # single precision may decide otherwise at zero itself
    sets = Learned(networks, forms, SHAPE).sets(x, wanted, np.empty((0, 0)))
    assert sets is not None
    (found,) = sets
    assert_array_equal(found.ravel()[clear], expected[clear])


def test_arrays_there_and_back_are_the_same_network() -> None:
    network = random_network(np.random.default_rng(0), (6, 4))
    again = Network.from_arrays(network.to_arrays())
    assert_array_equal(again.numbers, network.numbers)
    assert_array_equal(again.outputs, network.outputs)


@pytest.mark.parametrize("name", ["weight-1", "bias-0", "outputs"])
def test_layers_that_do_not_fit_are_refused(name: str) -> None:
    arrays = random_network(np.random.default_rng(0), (6, 4)).to_arrays()
    with pytest.raises(ValueError, match="do not fit"):
        Network.from_arrays({**arrays, name: arrays[name][:-1]})
