"""ACADO's way to a QP's answer: the answer of another solver, and the changes that qpOASES itself counts."""

import numpy as np
import pytest

from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Qp, Status
from otolith_thesis.parametric import FromMultipliers, follow
from otolith_thesis.solver_variants import has_qpoases


def problem(seed: int, n: int = 8, m: int = 12, bounds: int = 8) -> Qp:
    """Feasible at a random point, with rows that bind."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((n, n))
    A = rng.standard_normal((m, n))
    inside = np.concatenate([0.2 * rng.standard_normal(n)] * 2)[:n]
    rows = np.concatenate([inside[:bounds], A @ inside])
    room = rng.uniform(0.05, 0.6, (2, len(rows)))
    return Qp(root @ root.T + np.eye(n), 3.0 * rng.standard_normal(n), A, rows - room[0], rows + room[1])


def test_the_answer_is_that_of_daqp_and_the_way_is_longer_from_nothing() -> None:
    longer = 0
    for seed in range(30):
        qp = problem(seed)
        cold = follow(qp, np.zeros(len(qp.upper)))
        other = DenseSolver().solve(qp)
        assert cold.status is Status.OPTIMAL
        assert cold.residual < 1e-9
        np.testing.assert_allclose(cold.z, other.z, atol=1e-8)
        nearly = Qp(qp.H, qp.g * 1.02, qp.A, qp.lower, qp.upper)
        longer += cold.changes > follow(nearly, cold.y).changes
    assert longer == 30


def test_the_same_problem_again_needs_no_change() -> None:
    solver = FromMultipliers(1e-6)
    qp = problem(3)
    first, again = solver.solve(qp), solver.solve(qp)
    assert first.changes > 3
    assert again.changes == 0
    np.testing.assert_allclose(again.z, first.z, atol=1e-10)


def test_the_point_from_which_the_way_starts_plays_no_part() -> None:
    """So a guess of the controls, which is such a point, saves ACADO's solver nothing."""
    rng = np.random.default_rng(5)
    for seed in range(20):
        qp = problem(seed)
        y0 = follow(problem(seed + 100), np.zeros(len(qp.upper))).y
        from_zero = follow(qp, y0)
        elsewhere = follow(qp, y0, rng.standard_normal(len(qp.g)))
        assert elsewhere.changes == from_zero.changes
        np.testing.assert_allclose(elsewhere.z, from_zero.z, atol=1e-7)


def test_dependent_rows_are_exchanged() -> None:
    """Three rows through one point of the plane: the third takes the place of one of the others."""
    A = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    top = np.array([1.0, 1.0, 1.9])
    qp = Qp(np.eye(2), np.array([-5.0, -2.0]), A, np.full(3, -np.inf), top)
    start = np.array([4.0, 1.0, 0.0])  # the multipliers without the third row
    found = follow(qp, start)
    np.testing.assert_allclose(found.z, [1.0, 0.9], atol=1e-10)
    assert found.changes == 1
    assert (np.sign(found.y) == [1, 0, 1]).all()


def test_an_infeasible_problem_is_no_answer() -> None:
    qp = Qp(np.eye(1), np.zeros(1), np.array([[1.0], [1.0]]), np.array([1.0, -np.inf]), np.array([2.0, 0.5]))
    solver = FromMultipliers(1e-6)
    assert solver.solve(qp).status is not Status.OPTIMAL
    assert solver.y is None


@pytest.mark.skipif(not has_qpoases(), reason="qpOASES is not installed: pip install 'otolith[check]'")
def test_from_nothing_qpoases_counts_as_many_changes() -> None:
    """casadi makes a new qpOASES problem for the first solve; its far bounds and ramping are switched off."""
    casadi = pytest.importorskip("casadi")
    for seed in range(20):
        qp = problem(seed)
        sparsity = {"h": casadi.Sparsity.dense(*qp.H.shape), "a": casadi.Sparsity.dense(*qp.A.shape)}
        options = {"printLevel": "none", "enableFarBounds": False, "enableRamping": False, "sparse": False}
        solver = casadi.conic("cold", "qpoases", sparsity, options | {"initialStatusBounds": "inactive"})
        b = qp.bounds
        solver(h=qp.H, g=qp.g, a=qp.A, lba=qp.lower[b:], uba=qp.upper[b:], lbx=qp.lower[:b], ubx=qp.upper[:b])
        ours = follow(qp, np.zeros(len(qp.upper))).changes
        assert ours == solver.stats()["iter_count"]
