"""Export a law as C source without dependencies: one header, one file of tables and two functions.

Notation: θ parameter, z minimiser. Of a centrally symmetric law only one region of each mirror pair is
written; the other is reached by reflecting θ in the centre of the box. Rows and gains are written in 64 bits,
so that the regions alone decide; there is no QP behind them. The search first walks along neighbours and then
scans all regions.
"""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat, Vec
from otolith.mpqp.geometry import exact_rows
from otolith.mpqp.law import Law
from otolith.mpqp.problem import InvalidProblem


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
    sizes = {
        "name": name, "NAME": name.upper(), "p": len(law.form.half), "n": count, "h": len(law.radius),
        "alone": law.alone, "regions": len(law), "facets": len(law.beyond), "domain": law.form.E.shape[1],
        "tolerance": f"{law.tolerance:g}", "digest": law.problem.digest,
    }  # fmt: skip
    return CSource(name, _HEADER.format(**sizes), _SOURCE.format(**sizes, tables=_tables(law, count)))


def _tables(law: Law, outputs: int) -> str:
    """Text of all arrays of the source."""
    rows, gains = _rows_and_gains(law, outputs)
    return "\n".join(
        (
            _array("double", "centre", law.form.centre),
            _array("double", "half", law.form.half),
            _array("double", "domain", np.column_stack([law.form.E.T, law.form.e])),
            _array("int", "start", law.start),
            _array("int", "beyond", law.beyond),
            _array("double", "rows", rows),
            _array("double", "gains", gains),
            _array("double", "unconstrained", law.form.Z[:outputs, -1]),
        )
    )


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


def _array(kind: str, name: str, values: Vec | Mat | NDArray[np.int32]) -> str:
    """Text of one C table; an empty table contains one zero, which is never read."""
    flat = values.ravel()
    words = [f"{v:d}" if kind == "int" else f"{v:.17g}" for v in flat.tolist()] or ["0"]
    lines = [", ".join(words[i : i + 8]) for i in range(0, len(words), 8)]
    body = ",\n    ".join(lines)
    return f"static const {kind} {name}[{len(words)}] = {{\n    {body}\n}};\n"


_HEADER = """\
/* Explicit solution of a parametric QP: {regions} regions of radius >= {tolerance}.
   Model {digest}. Written by otolith; C99, no dependencies, no allocation, reentrant. */
#ifndef {NAME}_H
#define {NAME}_H

#define {NAME}_PARAMETERS {p}
#define {NAME}_OUTPUTS {n}
#define {NAME}_REGIONS {regions}

/* Minimiser at theta. Returns the region, from which the next search may start, or -1 when theta lies
   in no region (z is then untouched). start: the last region, or any negative number. */
int {name}_evaluate(const double theta[{NAME}_PARAMETERS], int start, double z[{NAME}_OUTPUTS]);

#endif
"""

_SOURCE = """\
#include "{name}.h"

enum {{ P = {p}, N = {n}, STORED = {h}, ALONE = {alone}, DOMAIN = {domain}, STEPS = 64 }};
static const double TOLERANCE = 1e-9;

{tables}
/* Largest violation among rows first..last-1 of a table of (P + 1) columns; its row in *worst. */
static double violation(const double *table, int first, int last, const double *tau, double sign, int *worst)
{{
    double most = -1e300;
    for (int f = first; f < last; f++) {{
        const double *row = table + (long)f * (P + 1);
        double v = -row[P];
        for (int c = 0; c < P; c++) v += sign * row[c] * tau[c];
        if (v > most) {{ most = v; *worst = f; }}
    }}
    return most;
}}

static int stored(int region) {{ return region < STORED ? region : region - (STORED - ALONE); }}

static int twin(int region)
{{
    if (region < ALONE) return region;
    return region < STORED ? region + STORED - ALONE : region - (STORED - ALONE);
}}

static double outside(int region, const double *tau, int *worst)
{{
    int s = stored(region);
    return violation(rows, start[s], start[s + 1], tau, region < STORED ? 1.0 : -1.0, worst);
}}

static int walk(const double *tau, int region)
{{
    for (int i = 0; i < STEPS && region >= 0; i++) {{
        int worst = 0;
        if (outside(region, tau, &worst) <= TOLERANCE) return region;
        int next = beyond[worst];
        region = next < 0 || region < STORED ? next : twin(next);
    }}
    return -1;
}}

static int scan(const double *tau)
{{
    for (int region = 0; region < 2 * STORED - ALONE; region++) {{
        int worst = 0;
        if (outside(region, tau, &worst) <= TOLERANCE) return region;
    }}
    return -1;
}}

int {name}_evaluate(const double theta[P], int from, double z[N])
{{
    double tau[P];
    int worst = 0;
    for (int c = 0; c < P; c++) {{
        tau[c] = (theta[c] - centre[c]) / half[c];
        if (!(tau[c] >= -1.0 - 1e-8 && tau[c] <= 1.0 + 1e-8)) return -1;
    }}
    if (DOMAIN > 0 && violation(domain, 0, DOMAIN, tau, 1.0, &worst) > 1e-8) return -1;
    int region = from >= 0 && from < 2 * STORED - ALONE ? walk(tau, from) : -1;
    if (region < 0) region = scan(tau);
    if (region < 0) return -1;
    for (int i = 0; i < N; i++) {{
        const double *gain = gains + ((long)stored(region) * N + i) * (P + 1);
        double v = region < STORED ? gain[P] : 2.0 * unconstrained[i] - gain[P]; /* odd about the centre */
        for (int c = 0; c < P; c++) v += gain[c] * tau[c];
        z[i] = v;
    }}
    return region;
}}
"""
