"""Export a law as C source without dependencies: one header, one file of tables and two functions.

Notation: θ parameter, z minimiser. Of a centrally symmetric law only one region of each mirror pair is
written; the other is reached by reflecting θ in the centre of the box. Rows and gains are written in 64 bits.

A call walks along neighbours. After WALK regions, or where the walk meets the end of the feasible parameters,
it solves the QP, as `lookup` does, and looks its active set up. So a call has a bound on its work that the
header states, however far θ has jumped, and an answer where a region is missing.
"""

import re
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat
from otolith.mpqp.c_text import HEADER, SOURCE
from otolith.mpqp.dualqp import DEPENDENT, LOOSE, RETRIED, TIED, TIGHT
from otolith.mpqp.geometry import exact_rows
from otolith.mpqp.law import Law
from otolith.mpqp.problem import InvalidProblem
from otolith.mpqp.region import kernel_form
from otolith.mpqp.sets import adopted

WALK: Final = 24  # regions that a walk looks at; longer ones cost more than the QP
CHANGES: Final = 200  # changes of the active set within which the QP ends; 66 have been seen, on a facet


@dataclass(frozen=True, slots=True)
class CSource:
    """The text of the two files; the source includes `<name>.h`."""

    name: str
    header: str
    source: str


def export_c(law: Law, name: str, *, outputs: int | None = None) -> CSource:
    """Write the C99 source of a law, its functions and constants prefixed by `name`.

    `outputs` limits the minimiser to its first components (an MPC applies the first input only).

    Raises
    ------
    InvalidProblem : `name` is not a C identifier, or `outputs` is not between 1 and n.
    """
    n = len(law.problem.f)
    count = n if outputs is None else outputs
    if not re.fullmatch(r"[A-Za-z_]\w*", name, flags=re.ASCII):
        raise InvalidProblem(f"the name {name!r} must be a C identifier")
    if not 1 <= count <= n:
        raise InvalidProblem(f"{count} outputs asked for, must be between 1 and {n}")
    words = {**_sizes(law, count), "name": name, "NAME": name.upper()}
    source = SOURCE.substitute(words, tables=_tables(law, count))
    return CSource(name, HEADER.substitute(words), source)


def _sizes(law: Law, outputs: int) -> dict[str, Any]:
    """Return the numbers in the texts."""
    (m, n, p), grain, most = law.form.sizes, law.form.grain, int(np.diff(law.start).max())
    factor, slacks = n**3 // 3 + n**2, n * m
    change = slacks + 2 * factor + 4 * n**2  # a row comes in; on average at most one goes out
    ties = 4 * n * (factor + slacks + m * (n**2 + 2 * n))
    return {
        "p": p, "n": outputs, "m": m, "nv": n, "h": len(law.radius), "alone": law.alone,
        "regions": len(law), "domain": law.form.E.shape[1], "words": law.keys.shape[1],
        "slots": len(_slots(law)), "symmetric": int(len(law.form.mirror) > 0),
        "tolerance": f"{law.tolerance:g}", "digest": law.problem.digest, "steps": WALK, "most": most,
        "changes": CHANGES, "operations": WALK * most * (p + 1) + CHANGES * change + ties,
        "dependent": DEPENDENT, "tied": TIED, "tight": TIGHT * grain,
        "loosest": max(LOOSE, RETRIED * TIGHT * grain),
    }  # fmt: skip


def _slots(law: Law) -> NDArray[np.int32]:
    """Index of the active sets: where the search for a key begins and goes on; see `sets`."""
    return adopted(law.keys, len(law.form.rows), law.form.mirror).slots


def _tables(law: Law, outputs: int) -> str:
    """Text of all arrays of the source."""
    form, (rows, gains) = law.form, _rows_and_gains(law, outputs)
    tables: tuple[tuple[str, str, NDArray[Any]], ...] = (
        ("double", "centre", form.centre),
        ("double", "half", form.half),
        ("double", "domain", np.column_stack([form.E.T, form.e])),
        ("int", "start", law.start),
        ("int", "beyond", law.beyond),
        ("double", "rows", rows),
        ("double", "gains", gains),
        ("double", "unconstrained", form.Z[:outputs]),
        ("double", "gram", form.Q),
        ("double", "distance", form.d.T),
        ("double", "slopes", form.V[:, :outputs]),
        ("double", "delta", kernel_form(form).delta),
        ("int", "mirror", form.mirror),
        ("uint64_t", "keys", law.keys),
        ("int", "slots", _slots(law)),
    )
    return "\n".join(_array(*table) for table in tables)


def _rows_and_gains(law: Law, outputs: int) -> tuple[Mat, Mat]:
    """Half-spaces (facets, p + 1) and affine laws (h·outputs, p + 1) of the stored regions, in τ."""
    p = len(law.form.half)
    rows, gains = np.empty((len(law.beyond), p + 1)), np.empty((len(law.radius), outputs, p + 1))
    for s in range(len(law.radius)):
        facets = slice(law.start[s], law.start[s + 1])
        A = law.form_rows(s)
        rows[facets] = exact_rows(law.form, A, law.constraint[facets].astype(np.int64))
        T = np.linalg.solve(law.form.Q[np.ix_(A, A)], law.form.d[:, A].T)
        gains[s] = (law.form.Z + law.form.V[A].T @ T)[:outputs]
    return rows, gains.reshape(-1, p + 1)


def _array(kind: str, name: str, values: NDArray[Any]) -> str:
    """Text of one C table; an empty table contains one zero, which is never read."""
    form = {"double": "{:.17g}", "int": "{:d}", "uint64_t": "UINT64_C({:d})"}[kind]
    words = [form.format(value) for value in values.ravel().tolist()] or ["0"]
    lines = [", ".join(words[i : i + 8]) for i in range(0, len(words), 8)]
    body = ",\n    ".join(lines)
    return f"static const {kind} {name}[{len(words)}] = {{\n    {body}\n}};\n"
