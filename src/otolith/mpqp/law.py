"""An explicit law: the regions of a parametric QP, ready to be evaluated, stored and certified.

Notation: θ parameter (p,), z minimiser (n,), τ = (θ - c) / s in [-1, 1]^p; see `leastdistance`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp import archive
from otolith.mpqp.expand import Ints16, Ints32, Rows32
from otolith.mpqp.geometry import exact_rows
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.lookup import answers, census, evaluate, members
from otolith.mpqp.packed import Numbering, Packed, pack
from otolith.mpqp.problem import InvalidProblem, ParametricQp
from otolith.mpqp.sets import Words, adopted, unpack

_NOTHING = np.empty(0, dtype=np.int64)


class Evaluation(NamedTuple):
    """The answer at one parameter."""

    z: Vec  # (n,) minimiser; NaN when not found
    region: int  # region id, or one of MISSED, OUTSIDE, UNSOLVED of `lookup`
    active: Ints  # (k,) active constraints of the problem
    multipliers: Vec  # (k,) of the active constraints, ≥ 0 up to rounding
    found: bool


class Evaluations(NamedTuple):
    """Answers at many parameters."""

    z: Mat  # (N, n), NaN where not found
    region: Ints  # (N,) as in `Evaluation`
    found: NDArray[np.bool_]  # (N,)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only view of an array."""
    view = array.view()
    view.setflags(write=False)
    return view


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Law:
    """All regions of a parametric QP; only one region of each mirror pair is stored.

    Stored region s has id s. The first `alone` of the h stored regions are their own mirror images (all of
    them when the problem has no central symmetry); the image of any other has id s + h - alone. The geometry
    is in the scaled parameter τ. The rows have 32 bits: they guide a walk whose end is checked in 64 bits.
    `halfspaces` and `gains` are computed in 64 bits from the active set.
    """

    problem: ParametricQp
    form: LeastDistance
    keys: Words  # (h, words) active sets, bit i for row i of `form`
    centre: Mat  # (h, p) centre of the largest ball, in τ
    radius: Vec  # (h,) radius of the largest ball, in τ
    start: Ints32  # (h + 1,) first facet of each region
    rows: Rows32  # (facets, p + 1) unit half-space a'τ ≤ b as (a, b)
    constraint: Ints16  # (facets,) row of `form` behind the facet
    beyond: Ints32  # (facets,) region id; -2 infeasible, -3 not a full-dimensional region
    alone: int
    tolerance: float  # smallest radius of a region, in τ
    seconds: float = np.nan  # [s] duration of the enumeration without compiling; NaN if read from a file
    compile_seconds: float = np.nan
    _packed: Packed = field(init=False, repr=False)

    def __post_init__(self) -> None:
        f = self.form
        table = adopted(self.keys, len(f.rows), f.mirror)
        by = Numbering(f.centre, f.half, f.rows, f.weights)
        packed = pack(f, table, self.start, self.rows, self.beyond, self.alone, by)
        object.__setattr__(self, "_packed", packed)
        for name in archive.STORED:
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        """Number of regions, mirror images included."""
        return 2 * len(self.radius) - self.alone

    @property
    def nbytes(self) -> int:
        """Memory of the stored regions with their index of active sets [bytes]."""
        stored = sum(getattr(self, name).nbytes for name in archive.STORED)
        return int(stored + self._packed.slots.nbytes)

    def evaluate(self, theta: Vec, start: int = -1) -> Evaluation:
        """Return minimiser, region, active constraints and multipliers at `theta` (p,).

        `start` is the region where the walk begins, usually that of the last answer; without it the QP is
        solved. The answer satisfies the optimality conditions whatever `start` is.
        """
        n = self.form.Z.shape[0]
        reals, ints = np.empty(2 * n), np.empty(n + 2, dtype=np.int64)
        region = evaluate(self._packed.block, self._point(theta), start, reals, ints)
        k = int(ints[1])
        if k < 0:
            return Evaluation(reals[:n], region, ints[:0], reals[:0], False)
        return Evaluation(reals[:n], region, ints[2 : 2 + k], reals[n : n + k], True)

    def first(self, theta: Vec, count: int, start: int = -1) -> tuple[Vec, int]:
        """Return the first `count` components of the minimiser at `theta` (p,), and the region.

        A caller who needs neither the multipliers nor the rest of the minimiser does not wait for them. The
        optimality conditions are checked as `evaluate` does. The components are NaN, and the region is
        OUTSIDE or UNSOLVED of `lookup`, where there is no answer.

        Raises
        ------
        InvalidProblem : `count` is not between 1 and n, or `theta` has another shape than (p,).
        """
        if not 1 <= count <= self.form.Z.shape[0]:
            raise InvalidProblem(f"{count} components asked for, must be 1 to {self.form.Z.shape[0]}")
        z = np.empty(count)
        return z, evaluate(self._packed.block, self._point(theta), start, z, _NOTHING)

    def _point(self, theta: Vec) -> Vec:
        """Copy one parameter; a kernel must not be given an array of another size or kind."""
        point = np.array(theta, dtype=np.float64)
        if point.shape != self.form.half.shape:
            raise InvalidProblem(f"theta has shape {point.shape}, must be {self.form.half.shape}")
        return point

    def evaluate_many(self, thetas: Mat, start: int = -1) -> Evaluations:
        """Evaluate the law at parameters (N, p); each walk starts in the region of the previous answer."""
        points = np.array(thetas, dtype=np.float64, order="C", ndmin=2)
        if points.shape[1:] != self.form.half.shape:
            raise InvalidProblem(f"thetas have shape {points.shape}, must be (N, {len(self.form.half)})")
        found = answers(len(points), len(self.problem.f))
        evaluate(self._packed.block, points.reshape(-1), start, found.reals, found.ints)
        return Evaluations(found.z, found.region, found.size >= 0)

    def locate_many(self, thetas: Mat) -> Evaluations:
        """Evaluate the law at parameters (N, p) from the regions alone; region -1 where none of them is
        optimal.

        This reveals holes in the table. It is slow where walks fail, since all regions are then tested.
        """
        regions = np.empty(len(thetas), dtype=np.int64)
        z = np.full((len(thetas), len(self.problem.f)), np.nan)
        members(self._packed.block, np.array(thetas, dtype=np.float64, order="C"), self.largest, regions, z)
        return Evaluations(z, regions, regions >= 0)

    def count_many(self, thetas: Mat, margin: float = 0.0) -> Ints:
        """Count the regions that contain each parameter (N, p) at a distance of at least `margin` (in τ)
        from their facets.
        """
        counts = np.empty(len(thetas), dtype=np.int64)
        census(self._packed.block, np.array(self.form.scaled(thetas), order="C"), margin, counts)
        return counts

    @property
    def largest(self) -> int:
        """Id of the region with the largest ball."""
        return int(self.radius.argmax())

    def stored(self, region: int) -> tuple[int, float]:
        """Stored region behind an id, and a sign: +1, or -1 if the id is the stored region's mirror image."""
        h = len(self.radius)
        if not 0 <= region < len(self):
            raise IndexError(f"region {region} of {len(self)}")
        return (region, 1.0) if region < h else (region - (h - self.alone), -1.0)

    def form_rows(self, region: int) -> Ints:
        """Active rows of `form`, in ascending order."""
        s, sign = self.stored(region)
        A = np.empty(len(self.form.rows) + 1, dtype=np.int64)
        k = unpack(self.keys, s, A)
        return A[:k] if sign > 0 else np.sort(self.form.mirror[A[:k]])

    def facets(self, region: int) -> Ints:
        """The row of `form` behind each facet of a region."""
        s, sign = self.stored(region)
        chosen = self.constraint[self.start[s] : self.start[s + 1]].astype(np.int64)
        return chosen if sign > 0 else self.form.mirror[chosen]

    def bits(self) -> Bools:
        """Active rows (h, m) of `form`, for every stored region."""
        octets = self.keys.astype("<u8").view(np.uint8).reshape(len(self.keys), -1)
        bits = np.unpackbits(octets, axis=1, bitorder="little", count=len(self.form.rows))
        return bits.astype(np.bool_)

    def active(self, region: int) -> Ints:
        """Active constraints of the problem, in ascending order."""
        return np.sort(self.form.rows[self.form_rows(region)])

    def gains(self, region: int) -> tuple[Mat, Vec]:
        """Gain K (n, p) and offset k (n,) with z = K θ + k throughout the region."""
        f, A = self.form, self.form_rows(region)
        T = np.linalg.solve(f.Q[np.ix_(A, A)], f.d[:, A].T)
        affine = f.Z + f.V[A].T @ T  # (n, p + 1) in τ
        K = affine[:, :-1] / f.half
        return K, affine[:, -1] - K @ f.centre

    def ball(self, region: int) -> tuple[Vec, float]:
        """Centre (p,) and radius of the largest ball, in τ."""
        s, sign = self.stored(region)
        return sign * self.centre[s], float(self.radius[s])

    def halfspaces(self, region: int) -> tuple[Mat, Vec]:
        """A (facets, p) and b with A θ ≤ b on the region; the rows have length one in τ.

        The bounds of the parameter, and constraints on the parameter alone, hold in addition.
        """
        rows = exact_rows(self.form, self.form_rows(region), self.facets(region))
        A = rows[:, :-1] / self.form.half
        return A, rows[:, -1] + A @ self.form.centre

    def neighbours(self, region: int) -> Ints:
        """Region id beyond each facet, in the order of `halfspaces`; negative where there is no region."""
        s, sign = self.stored(region)
        beyond = self.beyond[self.start[s] : self.start[s + 1]].astype(np.int64)
        if sign > 0:
            return beyond
        return np.array([self.twin(int(r)) if r >= 0 else r for r in beyond], dtype=np.int64)

    def twin(self, region: int) -> int:
        """Id of the mirror image; in a law without symmetry this is the region itself."""
        s, sign = self.stored(region)
        if s < self.alone:
            return s
        return s + len(self.radius) - self.alone if sign > 0 else s

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to restore the law, as plain arrays."""
        return archive.pack(self)

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Law":
        """Restore a law from the arrays that `to_arrays` returns.

        Raises
        ------
        CorruptFile : an array is missing, damaged, or inconsistent with the others.
        """
        return cls(**archive.unpack(arrays))
