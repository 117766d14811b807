"""Convert an explicit law to plain arrays and back; arrays are checked when a law is made from them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.errors import CorruptFile, OtolithError
from otolith.mpqp.leastdistance import LeastDistance, least_distance
from otolith.mpqp.problem import ParametricQp

if TYPE_CHECKING:
    from otolith.mpqp.law import Law

Arrays = Mapping[str, NDArray[Any]]
STORED: Final = {
    "keys": np.uint64, "centre": np.float64, "radius": np.float64, "start": np.int32, "rows": np.float32,
    "constraint": np.int16, "beyond": np.int32,
}  # fmt: skip
_PROBLEM: Final = ("H", "F", "f", "G", "w", "S", "lower", "upper")


def pack(law: "Law") -> dict[str, NDArray[Any]]:
    """Return the arrays of a law by name; how long it took to make is not part of it."""
    arrays = {name: getattr(law, name) for name in STORED}
    arrays |= {name: np.array(getattr(law, name)) for name in ("alone", "tolerance")}
    arrays |= {f"problem.{name}": getattr(law.problem, name) for name in _PROBLEM}
    arrays["rows_kept"] = law.form.rows
    arrays["symmetric"] = np.array(len(law.form.mirror) > 0)
    return arrays


def unpack(arrays: Arrays) -> dict[str, Any]:
    """Return the arguments of `Law` that the arrays of a law contain.

    Raises
    ------
    CorruptFile : an array is missing, damaged, or inconsistent with the others.
    """
    try:
        problem = ParametricQp(**{name: arrays[f"problem.{name}"] for name in _PROBLEM})
        form = _form(problem, arrays)
        stored = {name: np.array(arrays[name], dtype=kind, order="C") for name, kind in STORED.items()}
        tolerance, alone = float(arrays["tolerance"]), int(arrays["alone"])
    except KeyError as error:
        raise CorruptFile(f"the explicit law lacks the array {error.args[0]}") from error
    except (OtolithError, ValueError, TypeError, IndexError) as error:
        raise CorruptFile(f"the explicit law is damaged: {error}") from error
    _check(stored, form, alone)
    return {"problem": problem, "form": form, "alone": alone, "tolerance": tolerance, **stored}


def _form(problem: ParametricQp, arrays: Arrays) -> LeastDistance:
    """Derive the least-distance problem of the kept rows anew from the model."""
    whole = least_distance(problem)
    kept = np.isin(whole.rows, arrays["rows_kept"])
    if kept.sum() != len(arrays["rows_kept"]):
        raise ValueError("its constraints are not those of its model")
    form = whole.without(np.flatnonzero(~kept))
    return form if bool(arrays["symmetric"]) else form.unsymmetric()


def _check(stored: dict[str, NDArray[Any]], form: LeastDistance, alone: int) -> None:
    """Check that every shape and every index is consistent with the others.

    Raises
    ------
    CorruptFile : a shape or an index is not.
    """
    m, _, p = form.sizes
    h, facets = len(stored["radius"]), len(stored["beyond"])
    words = max(1, -(-m // 64))
    shapes = {
        "keys": (h, words), "centre": (h, p), "radius": (h,), "start": (h + 1,), "rows": (facets, p + 1),
        "constraint": (facets,), "beyond": (facets,),
    }  # fmt: skip
    for name, shape in shapes.items():
        if stored[name].shape != shape:
            raise CorruptFile(f"the explicit law's {name} has shape {stored[name].shape}, must be {shape}")
    start, regions = stored["start"], 2 * h - alone
    sound = 0 <= alone <= h and start[0] == 0 and start[-1] == facets and (np.diff(start) >= 0).all()
    sound = sound and (stored["constraint"] >= 0).all() and (stored["constraint"] < m).all()
    sound = sound and (stored["beyond"] < regions).all() and np.isfinite(stored["rows"]).all()
    bits = np.unpackbits(
        stored["keys"].astype("<u8").view(np.uint8).reshape(h, -1), axis=1, bitorder="little"
    )
    sound = sound and not bits[:, m:].any() and (bits.sum(axis=1) <= form.V.shape[1]).all()
    if not sound:
        raise CorruptFile("the explicit law's regions refer to what does not exist")
