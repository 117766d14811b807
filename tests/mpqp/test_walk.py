"""Walks across facets that have several regions on their far side."""

import numpy as np

from otolith.mpqp import Law
from otolith.mpqp.certify import _facet_point
from otolith.mpqp.oracle import solve


def beside_shared_facets(law: Law, wanted: int) -> list[tuple[int, int, np.ndarray]]:
    """(region, region linked to, θ) with θ just past a facet and in neither of the two."""
    rng = np.random.default_rng(0)
    cases: list[tuple[int, int, np.ndarray]] = []
    while len(cases) < wanted:
        region = int(rng.integers(len(law)))
        tau, row, facet = _facet_point(law, region, rng)
        if facet < 0 or (linked := int(law.neighbours(region)[facet])) < 0:
            continue
        theta = law.form.centre + law.form.half * (tau + 1e-5 * row)
        answer = law.evaluate(theta)
        if answer.region >= 0 and answer.region not in (region, linked):
            cases.append((region, linked, theta))
    return cases


def test_a_walk_over_a_facet_with_several_neighbours_ends_in_the_right_one(blocked: Law) -> None:
    """The link of such a facet leads to one of them; the walk goes on from there, or the QP decides."""
    for region, linked, theta in beside_shared_facets(blocked, 200):
        truth, cold = solve(blocked.problem, theta), blocked.evaluate(theta)
        for start in (region, linked, blocked.twin(region)):
            answer = blocked.evaluate(theta, start)
            assert (answer.found, answer.region) == (True, cold.region)
            np.testing.assert_allclose(answer.z, truth, rtol=0.0, atol=1e-8)
        located = blocked.locate_many(theta[None, :])
        assert located.region[0] == cold.region
