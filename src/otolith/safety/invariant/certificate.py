"""The proof that an axis can stay in its set, in the form in which it is stored, and its check.

A certificate holds a command for every vertex of the set that leads back inside. It is checked without
relying on the code that found it. The vertices are enumerated anew by another algorithm (Qhull; Barber,
Dobkin & Huhdanpaa, 1996), the limits are those of the platform, and every step is computed by the law that
stops a platform (`otolith.safety.law.move`). A certificate with one vertex missing or one facet moved is
refused.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import CorruptFile
from otolith.safety.invariant.axis import Axis, AxisSet
from otolith.safety.invariant.contraction import Cell, cells, sides
from otolith.safety.law import move

_SAME: Final = 1e-7  # scaled distance below which two vertices are the same
_ROUNDING: Final = 1e-12  # scaled; largest difference between two exact formulas of one step
_ARRAYS: Final = ("forms", "lower", "upper")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisCertificate:
    """The set of one axis, lower ≤ forms x ≤ upper with x = (p, v, a), and a command for each vertex."""

    forms: Mat  # (r, 3); the last one is z, that of the wedge
    lower: Vec  # (r,) less than 0
    upper: Vec  # (r,) greater than 0
    cells: tuple[Cell, ...]

    def __post_init__(self) -> None:
        r = len(self.forms)
        for name, shape in zip(_ARRAYS, ((r, 3), (r,), (r,)), strict=True):
            array = frozen_array(getattr(self, name))
            if array.shape != shape or not np.isfinite(array).all():
                raise ValueError(f"{name} has shape {array.shape}, must be {shape} of finite numbers")
            object.__setattr__(self, name, array)
        if r == 0 or not (self.lower < 0.0).all() or not (self.upper > 0.0).all():
            raise ValueError("rest at the neutral pose does not lie inside")
        for cell in self.cells:
            n = len(cell.vertices)
            if cell.vertices.shape != (n, 3) or cell.commands.shape != (n,) or n < 4:
                raise ValueError("a cell has not one command for each of at least 4 vertices")

    @classmethod
    def of(cls, proved: AxisSet) -> Self:
        """Return the certificate of a set, which is a proof only after `check` has passed it."""
        rows = proved.rows
        return cls(
            forms=np.array([[row.place, row.speed, row.acceleration] for row in rows]),
            lower=np.array([row.lower for row in rows]),
            upper=np.array([row.upper for row in rows]),
            cells=cells(proved),
        )

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all data by name; a "/" separates groups."""
        arrays: dict[str, NDArray[Any]] = {name: getattr(self, name) for name in _ARRAYS}
        for number, cell in enumerate(self.cells):
            own = {"side": np.array(cell.side), "vertices": cell.vertices, "commands": cell.commands}
            arrays |= {f"cell-{number}/{name}": array for name, array in own.items()}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a certificate; raise CorruptFile if an array is missing or does not fit the others."""
        count = len({name.partition("/")[0] for name in arrays if name.startswith("cell-")})
        try:
            found = tuple(
                Cell(
                    int(arrays[f"cell-{number}/side"]),
                    frozen_array(arrays[f"cell-{number}/vertices"]),
                    frozen_array(arrays[f"cell-{number}/commands"]),
                )
                for number in range(count)
            )
            return cls(**{name: arrays[name] for name in _ARRAYS}, cells=found)
        except KeyError as error:
            raise CorruptFile(f"the certificate lacks the array {error.args[0]}") from error
        except (ValueError, TypeError) as error:
            raise CorruptFile(f"the certificate is damaged: {error}") from error


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """The result of a check. It is a proof if `shrink` is below 1 and all counts from `beyond` on are 0."""

    facets: int
    vertices: int
    shrink: float  # λ: from each vertex the command leads into λ S
    beyond: int  # number of limits of the platform and rows of the braking law that the set exceeds
    missing: int  # vertices of the facets that the certificate does not have
    strays: int  # vertices of the certificate that the facets do not have
    refused: int  # commands beyond their bound, out of the set, or away from the circle's centre

    @property
    def passed(self) -> bool:
        """Return whether the certificate proves its set."""
        return self.shrink < 1.0 and not (self.beyond or self.missing or self.strays or self.refused)


def check(certificate: AxisCertificate, axis: Axis) -> Judgement:
    """Check a certificate for an axis as a platform's file describes it."""
    C = np.vstack([certificate.forms, -certificate.forms])
    b = np.concatenate([certificate.upper, -certificate.lower])
    found = tuple(sorted(cell.side for cell in certificate.cells)) == tuple(sorted(sides(axis)))
    missing, strays, refused, shrink, corners = 0 if found else 1, 0, 0, 0.0, []
    for cell in certificate.cells:
        expected = _enumerated(C, b, cell, certificate.forms[-1]) / axis.scale
        stored = cell.vertices / axis.scale
        missing += _lacking(expected, stored)
        strays += _lacking(stored, expected)
        after = np.array([_moved(axis, x, u) for x, u in zip(cell.vertices, cell.commands, strict=True)])
        shrink = max(shrink, float((after @ C.T / b).max()))
        refused += _refused(axis, cell, after, certificate.forms[-1])
        corners.append(expected * axis.scale)
    return Judgement(
        facets=int((C.any(axis=1)).sum()),
        vertices=sum(len(cell.vertices) for cell in certificate.cells),
        shrink=shrink,
        beyond=_beyond(axis, np.vstack(corners)),
        missing=missing,
        strays=strays,
        refused=refused,
    )


def _enumerated(C: Mat, b: Vec, cell: Cell, z: Vec) -> Mat:
    """Return the vertices (n, 3) of a cell by Qhull, which needs a point inside it."""
    facets, bounds = (np.vstack([C, -cell.side * z]), np.append(b, 0.0)) if cell.side else (C, b)
    scale = np.abs(cell.vertices).max(axis=0)
    D = facets * scale
    length = np.linalg.norm(D, axis=1)
    inside = cell.vertices.mean(axis=0) / scale
    if not (D @ inside < bounds).all():
        return np.empty((0, 3))  # then every vertex of the certificate is a stray
    halfspaces = np.column_stack([D, -bounds]) / length[:, None]
    points: Mat = scipy.spatial.HalfspaceIntersection(halfspaces, inside).intersections * scale
    return points


def _lacking(points: Mat, among: Mat) -> int:
    """Return how many of `points` (n, 3) are not near one of `among` (m, 3)."""
    if not len(points) or not len(among):
        return len(points)
    distance = np.abs(points[:, None] - among[None]).max(axis=2)
    return int((distance.min(axis=1) > _SAME).sum())


def _moved(axis: Axis, x: Vec, u: float) -> Vec:
    """Return the state (3,) one period after x (3,) under the held command u."""
    motion, commands = np.zeros((3, 6)), np.zeros(6)
    motion[:, 0], commands[0] = x, u
    move(motion, commands, axis.lag, axis.period)
    return motion[:, 0].copy()


def _refused(axis: Axis, cell: Cell, after: Mat, z: Vec) -> int:
    """Return how many commands of a cell are refused."""
    refused = np.abs(cell.commands) > axis.command * (1.0 + _ROUNDING)
    if cell.side:
        nearer = (1.0 - 0.5 * axis.towards_centre) * np.abs(cell.vertices @ z)
        refused |= np.abs(after @ z) > nearer + _ROUNDING * axis.scale[0]
        refused |= cell.side * (cell.vertices @ z) < -_SAME * axis.scale[0]
    return int(refused.sum())


def _beyond(axis: Axis, corners: Mat) -> int:
    """Return how many of the platform's own rows some corner (n, 3) of the set exceeds."""
    most = np.abs(corners[:, 2]).max(initial=0.0) > axis.command * (1.0 + _SAME)
    count = int(most)
    for row in axis.limit_rows():
        values = corners @ [row.place, row.speed, row.acceleration]
        room = _SAME * (row.upper - row.lower)
        count += bool(
            values.max(initial=0.0) > row.upper + room or values.min(initial=0.0) < row.lower - room
        )
    return count
