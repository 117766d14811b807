"""Misprints of equations and tables, decided almost without closed loops."""

from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import specific_force
from otolith.core.lti import StateSpace
from otolith.platforms import load
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import FOUR_DOF, Loop
from otolith_thesis.outcome import Bearing, Claim, Grid, Outcome
from otolith_thesis.published import published
from otolith_thesis.studies.common import bearing

OMEGA_N: Final = 2.5  # [rad/s] together with ζ and ω_w below, a common washout
ZETA: Final = 1.0
OMEGA_W: Final = 0.2  # [rad/s]
ENDS: Final = np.array([1e-4, 1e4])  # [rad/s] in place of 0 and infinity


def filters(answers: Answers) -> Outcome:
    """Show that eqs. 2.2 and 2.4, which are called high-pass, are printed as low-pass."""
    del answers
    n2, second = OMEGA_N**2, [1.0, 2.0 * ZETA * OMEGA_N, OMEGA_N**2]
    third = list(np.polymul(second, [1.0, OMEGA_W]))
    printed = {"2.2": ([n2 * OMEGA_W], third), "2.4": ([n2], second)}
    right = {"2.2": ([1.0, 0.0, 0.0, 0.0], third), "2.4": ([1.0, 0.0, 0.0], second)}
    rows, high_pass = [], []
    for equation in printed:
        for name, (numerator, denominator) in (
            ("printed", printed[equation]),
            ("high-pass", right[equation]),
        ):
            response = StateSpace.from_polynomials(numerator, denominator).frequency_response(ENDS)
            low, high = np.abs(np.ravel(response))
            rows.append((equation, name, float(low), float(high)))
            if name == "printed":
                high_pass.append(bool(low < 0.01 and high > 0.99))
    return Outcome(
        name="study-filters",
        kind="study",
        title="Eqs. 2.2 and 2.4 are low-pass filters as printed",
        section="2.2.1",
        text=(
            "Both are called high-pass filters that wash the platform back. With the printed numerators "
            "slow signals pass and fast ones do not; with s³ (s² · s) and s² it is as the text says: "
            "integrated twice, a step of acceleration then leaves a displacement that returns to zero."
        ),
        claims=(
            Claim(
                text="As printed they are high-pass",
                holds=all(high_pass),
                figures="; ".join(f"eq. {e}: |G(0)| = {a:.2g}, |G(∞)| = {b:.2g}" for e, n, a, b in rows[::2]),
            ),
        ),
        grids=(Grid(title="Gain", header=("eq.", "numerator", "slow", "fast"), rows=tuple(rows)),),
    )


def _about(axis: int, angle: float) -> Mat:
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = (s, -s) if axis == 1 else (-s, s)
    return R


def _mirrored(sign: float) -> Loop:
    return Loop(scenario=f"step-sine:amplitude={sign:g},frequency=0.1", dofs=FOUR_DOF, solver="structured")


def sign_jobs() -> list[Loop]:
    """Return a 4 DOF run and its mirror image."""
    return [_mirrored(+1.0), _mirrored(-1.0)]


def signs(answers: Answers) -> Outcome:
    """Compare the three sign conventions of the tilt in eqs. 2.3, 4.4 and 4.18."""
    theta, phi, g = 0.2, -0.13, np.array([0.0, 0.0, 1.0])
    printed = np.array([-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)])
    as_product = _about(0, theta) @ _about(1, phi) @ g
    right = (_about(1, theta) @ _about(0, phi)).T @ g
    felt = specific_force(np.zeros(3), np.array([phi, theta, 0.0])) / 9.81 + g
    one, other = (answers[_mirrored(sign)] for sign in (1.0, -1.0))
    gap = max(
        float(np.max(np.abs(one.motion[pair].position + other.motion[pair].position))) for pair in FOUR_DOF
    )
    return Outcome(
        name="study-signs",
        kind="study",
        title="Eqs. 2.3, 4.4 and 4.18 use different signs of the tilt; results are the same by symmetry",
        section="2.2.1, 4.1.1, 4.2.1",
        text=(
            "Eq. 2.3 has −g sin θ, eq. 4.4 +g sin θ, eq. 4.18 −g cos θ sin φ beside a + in eq. 2.3. "
            "Limits, cost and model are symmetric, so that a tilt of the other sign mirrors the motion. "
            "Eq. 2.3's product R_x(θ) R_y(φ) does not give its own right-hand side; (R_y(θ) R_x(φ))ᵀ does."
        ),
        claims=(
            Claim(
                text="The product in eq. 2.3 is what stands on its right",
                holds=bool(np.max(np.abs(as_product - printed)) < 1e-9),
                figures=f"apart by {np.max(np.abs(as_product - printed)):.3f} g; "
                f"transposed and in the other order by {np.max(np.abs(right - printed)):.1e} g",
            ),
            Claim(
                text="The right-hand side is what the platform's attitude gives",
                holds=bool(np.max(np.abs(felt - printed)) < 1e-12),
                figures=f"apart by {np.max(np.abs(felt - printed)):.1e} g",
            ),
            Claim(
                text="The mirrored reference gives the mirrored motion (to 1e-6 m)",
                holds=gap < 1e-6,
                figures=f"positions apart by {gap:.1e} m in 4 DOF",
            ),
        ),
    )


def table_6_1(answers: Answers) -> Outcome:
    """Show that Table 6.1 exchanges pitch and roll, and that the actuator's row has a wrong sign."""
    del answers
    hexapod = load("davsi").six_legs()
    reach = {axis: _travel(hexapod, index) for axis, index in (("roll", 3), ("pitch", 4))}
    symmetric = {axis: abs(low + high) < 1e-6 for axis, (low, high) in reach.items()}
    return Outcome(
        name="study-table-6.1",
        kind="study",
        title="Table 6.1: pitch and roll are exchanged, and −1.297 m is a length",
        section="6",
        text=(
            "A hexapod built alike on the left and right rolls equally to both sides, whatever its size; "
            "the table gives the symmetric range to pitch. A leg is 1.297 to 1.937 m long; a range from "
            "−1.297 m has no meaning. Shown on the shipped surrogate, whose legs were fitted to the table, "
            "each axis alone."
        ),
        claims=(
            Claim(
                text="The axis with a symmetric range is pitch, as printed",
                holds=symmetric["pitch"] and not symmetric["roll"],
                figures="; ".join(f"{axis} {a:.1f} to {b:.1f} deg" for axis, (a, b) in reach.items()),
            ),
        ),
        grids=(
            Grid(
                title="Reach of one axis alone [deg]",
                header=("axis", "surrogate, from", "to", "printed"),
                rows=(
                    ("pitch", *reach["pitch"], "±24.3"),
                    ("roll", *reach["roll"], "−25.4 … 28.4"),
                ),
            ),
        ),
    )


def _travel(hexapod: Any, axis: int) -> tuple[float, float]:
    """Return how far one rotation reaches in both directions [deg] until a leg ends, by bisection."""
    low, high = hexapod.stroke

    def within(angle: float) -> bool:
        pose = np.zeros(6)
        pose[axis] = angle
        lengths: Vec = hexapod.lengths(pose)
        return bool(low <= lengths.min() and lengths.max() <= high)

    ends = []
    for sign in (-1.0, 1.0):
        inside, outside = 0.0, np.deg2rad(60.0)
        while outside - inside > 1e-9:
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if within(sign * middle) else (inside, middle)
        ends.append(float(np.rad2deg(sign * inside)))
    return ends[0], ends[1]


_PERCENTAGES: Final = {"table-5.5": "table-5.6", "table-5.9": "table-5.10", "table-c.4": "table-c.5"}


def arithmetic(answers: Answers) -> Outcome:
    """Show that Tables 5.6, 5.10 and C.5 follow from 5.5, 5.9 and C.4, except for their signs."""
    del answers
    rows, worse = [], []
    for counts, percent in _PERCENTAGES.items():
        models = list(published(percent).average)
        signed = {
            model: [100.0 * (1.0 - row[model] / row["implicit"]) for row in published(counts).rows]
            for model in models
        }
        worse += [
            f"{percent}, {row['scenario']}, {model}: {value:.2f} %"
            for model in models
            for row, value in zip(published(counts).rows, signed[model], strict=True)
            if value < 0.0
        ]
        rows += [
            (percent, model, published(percent).average[model], float(np.mean(signed[model])))
            for model in models
        ]
    first, last = (row for row in rows if row[0] == "table-c.5" and row[1] != "implicit-trajectory")
    return Outcome(
        name="study-arithmetic",
        kind="study",
        title="The tables of percentages count worse as better",
        section="5.2.4, 5.3.2, C.4.1",
        text=(
            "They print magnitudes, and average them: a model that needs more iterations counts as an "
            "improvement. With signs, the hybrid with the first input leads in Table C.5, not the one with "
            "all inputs. "
            f"Worse, yet counted as better: {'; '.join(worse)}."
        ),
        claims=(
            Claim(
                text="In Table C.5 the hybrid with all inputs saves more on average",
                holds=last[3] > first[3],
                figures=f"{first[1]} {first[3]:.2f} %, {last[1]} {last[3]:.2f} %",
            ),
        ),
        grids=(
            Grid(
                title="Average saving [%]",
                header=("table", "model", "printed", "from the published means, with sign"),
                rows=tuple(rows),
            ),
        ),
        bears_on=bearing(tuple(_PERCENTAGES.values()), bool(worse), Bearing.EXPLAINS),
    )
