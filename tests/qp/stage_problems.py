"""Random stage problems of one small structure; a helper of the tests."""

import numpy as np

from otolith.qp.stage import StageProblem, StageQp

N, NX, NU = 7, 4, 2

A_PATTERN = np.array([[1, 1, 0, 0], [0, 1, 0, 0.5], [0, 0, 1, 0.5], [0, 0, 0, 0.5]])
B_PATTERN = np.array([[0, 0.5], [0.5, 0], [0, 0.5], [0.5, 0.5]])
C_PATTERN = np.array([[1, 0, 0, 0], [0, 0.5, 0.5, 0.5], [0, 0, 0, 1.0]])
OUTPUT = np.array([[True, False, True, False], [False, True, True, False]])
VARYING = np.array([[True, False, True, False]])


def _values(pattern: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Numbers for the entries that are data, 0.5 in the pattern; ones stay ones."""
    return np.where(pattern == 0.5, rng.uniform(0.2, 0.9, pattern.shape), pattern)


def stage_problem(rng: np.random.Generator, *, soft: float = np.inf) -> StageProblem:
    """Sizes and sparsity are always the same, so that one compiled module serves all tests."""
    penalty = np.full(3 + 1 + NU, np.inf)
    penalty[[0, 1, 3]] = soft
    return StageProblem(
        horizon=N,
        A=_values(A_PATTERN, rng),
        B=_values(B_PATTERN, rng),
        C=_values(C_PATTERN, rng),
        output=OUTPUT,
        varying=VARYING,
        weighted=(0, 3),
        control_weight=rng.uniform(0.1, 1.0, NU),
        penalty=penalty,
    )


def stage_qp(
    rng: np.random.Generator, *, soft: float = np.inf, tight: float = 1.0, pull: float = 3.0
) -> StageQp:
    """A feasible problem (without inputs from x_0 = 0 all rows hold); `pull` tells how far it strains."""
    problem = stage_problem(rng, soft=soft)
    rows = (N, problem.rows)
    return StageQp(
        problem=problem,
        x0=np.zeros(NX),
        output=rng.standard_normal((N, *OUTPUT.shape)) * OUTPUT,
        error=pull * rng.standard_normal((N, len(OUTPUT))),
        state_weight=rng.uniform(0.0, 2.0, (N, 2)),
        state_linear=pull * rng.standard_normal((N, 2)),
        input_linear=pull * rng.standard_normal((N, NU)),
        varying=rng.standard_normal((N, *VARYING.shape)) * VARYING,
        lower=-tight * rng.uniform(0.1, 1.0, rows),
        upper=tight * rng.uniform(0.1, 1.0, rows),
    )
