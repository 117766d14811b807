"""Which braking laws keep a platform within its reach (thesis, section C.1).

The rows are built here from c_v, c_u and T alone, because a platform file refuses c_v²/c_u < 2, the subject
of this study. Consider one axis in continuous time, with e = s_max − s and the row s + c_v v T + ½ c_u u T² ≤
s_max active (eq. C.2). It obeys

    ½ c_u T² e″ + c_v T e′ + e = 0,    damping ratio c_v / √(2 c_u),

so that e keeps its sign exactly if c_v²/c_u ≥ 2. The thesis requires only > 1 (eq. C.1), half of that.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.platforms import load
from otolith_thesis.jobs import Answers
from otolith_thesis.outcome import Claim, Curve, Grid, Outcome, Panel

REACH: Final = 0.5  # [m]
ACCELERATION: Final = 9.81  # [m/s²]
SPEED: Final = 7.2  # [m/s]
C_V: Final = 1.0
RATIOS: Final = (0.45, 0.5, 0.7, 0.95, 1.5)  # c_u: c_v²/c_u of 2.22, 2, 1.43, 1.05, 0.67
T_POSITION: Final = (1.5, 2.0, 2.5, 3.0)  # [s] figure C.2
T_TILT: Final = (0.3, 0.5, 0.7, 1.0)  # [s] figure C.3
INVARIANT: Final = 2.0  # smallest c_v²/c_u without overshoot
PUSH: Final = ("constant", "reversing", "random")
MARGIN: Final = 5e-4  # [m] overshoot that a period of 10 ms causes in any case


@dataclass(frozen=True, slots=True, kw_only=True)
class Attack:
    """Many platforms that are pushed for a minute as hard as their braking row permits."""

    c_u: float
    c_v: float = C_V
    T: float = 2.5  # [s]
    with_position: bool = True  # eq. C.2; False: eq. 4.7 as printed
    period: float = 0.01  # [s]
    seconds: float = 60.0
    tries: int = 200

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"braking law with c_v²/c_u = {self.ratio:.2f}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 0.5

    @property
    def ratio(self) -> float:
        """Return c_v²/c_u."""
        return self.c_v**2 / self.c_u

    def run(self) -> dict[str, float]:
        """Return the largest displacement [m] for every kind of push."""
        return {push: self._largest(push) for push in PUSH}

    def _largest(self, push: str) -> float:
        rng = np.random.default_rng(0)
        s, v, u = np.zeros(self.tries), np.zeros(self.tries), np.full(self.tries, ACCELERATION)
        dt, gain, largest = self.period, 0.5 * self.c_u * self.T**2, 0.0
        for k in range(round(self.seconds / dt)):
            u = _pushed(push, u, k, rng)
            held = (s if self.with_position else 0.0) + self.c_v * v * self.T
            low = np.maximum.reduce(
                [np.full_like(s, -ACCELERATION), (-REACH - held) / gain, (-SPEED - v) / dt]
            )
            high = np.minimum.reduce([np.full_like(s, ACCELERATION), (REACH - held) / gain, (SPEED - v) / dt])
            brake = -np.sign(held) * ACCELERATION
            a = np.where(low > high, brake, np.clip(u, low, np.maximum(low, high)))
            s, v = s + dt * v + 0.5 * dt**2 * a, v + dt * a
            largest = max(largest, float(np.max(np.abs(s))))
        return largest


def _pushed(push: str, u: Vec, k: int, rng: np.random.Generator) -> Vec:
    if push == "constant":
        return u
    if push == "reversing":
        flip = (rng.random(len(u)) < 0.15) & (k % 25 == 0)
        return np.where(flip, -u, u)
    new = rng.uniform(-ACCELERATION, ACCELERATION, len(u)) * rng.choice([0.1, 1.0, 3.0], len(u))
    return np.where(rng.random(len(u)) < 0.01, new, u)


def closed_form_overshoot(ratio: float, c_v: float = C_V, T: float = 2.5) -> float:
    """Return the overshoot [m] of the braking law from s = 0 at its own speed, v = s_max / (c_v T).

    The law starts there with u = 0. The result is its free response from e = s_max, e′ = −s_max/(c_v T) in
    closed form.
    """
    c_u = c_v**2 / ratio
    m, d = 0.5 * c_u * T**2, c_v * T
    roots = np.roots([m, d, 1.0]).astype(complex)
    if abs(roots[0] - roots[1]) < 1e-9:
        roots[1] += 1e-6
    start = np.array([REACH, -REACH / d])
    parts = np.linalg.solve(np.array([[1.0, 1.0], roots]), start)
    t = np.linspace(0.0, 30.0 * T, 30001)
    e = np.real(np.exp(np.outer(t, roots)) @ parts)
    return float(max(0.0, -np.min(e)))


def free_response(T: float, *, c_v: float, c_u: float, limit: float) -> tuple[Vec, Vec, Vec]:
    """Return time, position and speed of eq. C.3's double integrator on its braking surface, from s = 0.

    At rest at the centre the law pushes with u = 2 limit / (c_u T²), and it comes to rest at the limit.
    """
    roots = np.roots([0.5 * c_u * T**2, c_v * T, 1.0]).astype(complex)
    parts = np.linalg.solve(np.array([[1.0, 1.0], roots]), np.array([limit, 0.0]))
    t = np.linspace(0.0, 10.0, 501)
    modes = np.exp(np.outer(t, roots))
    return t, limit - np.real(modes @ parts), -np.real(modes @ (roots * parts))


ATTACKS: Final = tuple(Attack(c_u=c_u) for c_u in RATIOS)
PRINTED: Final = Attack(c_u=0.45, with_position=False)


def row_jobs() -> list[Attack]:
    """Return the thesis's law with and without the position."""
    return [ATTACKS[0], PRINTED]


def bound(answers: Answers) -> Outcome:
    """Measure overshoots, which show that the bound of eq. C.1 is 2, not 1."""
    largest = {attack: max(answers[attack].values()) for attack in ATTACKS}
    rows = tuple(
        (
            attack.ratio,
            C_V / math.sqrt(2.0 * attack.c_u),
            *(answers[attack][push] for push in PUSH),
            closed_form_overshoot(attack.ratio),
        )
        for attack in ATTACKS
    )
    kept = [attack.ratio for attack, far in largest.items() if far <= REACH + MARGIN]
    broken = [attack.ratio for attack, far in largest.items() if far > REACH + MARGIN]
    right = min(kept) >= INVARIANT - 1e-9 and max(broken) < INVARIANT
    least = load("thesis").braking
    return Outcome(
        name="study-braking-bound",
        kind="study",
        title="Eq. C.1: the platform overshoots its reach unless c_v²/c_u is at least 2",
        section="C.1",
        text=(
            "The thesis asks for c_v²/c_u > 1. A platform is pushed as hard as the row lets it be, for a "
            "minute, two hundred times in three ways; the reach is 0.5 m, the period 10 ms. The last column "
            "is the closed form of one approach from the centre. The thesis's own values "
            f"(c_v = {least.c_v:g}, c_u = {least.c_u:g}) give {least.c_v**2 / least.c_u:.2f} and are safe."
        ),
        claims=(
            Claim(
                text="As printed, c_v²/c_u > 1 suffices",
                holds=all(a.ratio <= 1.0 or far <= REACH + MARGIN for a, far in largest.items()),
                figures=", ".join(f"{far:.4f} m at {a.ratio:.2f}" for a, far in largest.items()),
            ),
            Claim(
                text="c_v²/c_u ≥ 2 suffices, and nothing less does",
                holds=right,
                figures=f"kept at {min(kept):.2f} and above, broken at {max(broken):.2f} and below",
            ),
        ),
        grids=(
            Grid(
                title="Largest displacement [m] by kind of push, reach 0.5 m",
                header=("c_v²/c_u", "damping ratio", *PUSH, "overshoot in closed form [m]"),
                rows=rows,
            ),
        ),
        panels=(_surface_panel(),),
    )


def _surface_panel() -> Panel:
    curves = []
    for c_u in RATIOS:
        t, s, _ = free_response(2.5, c_v=C_V, c_u=c_u, limit=REACH)
        curves.append(Curve(label=f"c_v²/c_u = {C_V**2 / c_u:.2f}", x=t, y=s))
    return Panel(
        title="On the braking surface, from rest at the centre",
        x_label="time [s]",
        y_label="position [m]",
        curves=(*curves, _level(REACH, "reach")),
    )


def printed_rows(answers: Answers) -> Outcome:
    """Show that eqs. 4.7 and 4.8, which lack the position, let the platform drift away."""
    with_position, without = answers[ATTACKS[0]], answers[PRINTED]
    return Outcome(
        name="study-braking-rows",
        kind="study",
        title="Eqs. 4.7 and 4.8 lack the position; eq. C.2 has it",
        section="4.1.1, C.1",
        text=(
            "As printed, s_min ≤ c_v v T + ½ c_u a T² ≤ s_max bounds the speed by 0.2 m/s wherever the "
            "platform is. With the position in it (eq. C.2) the row is a law that comes to rest at the limit."
        ),
        claims=(
            Claim(
                text="As printed, the row alone keeps the platform within its reach",
                holds=max(without.values()) <= REACH + MARGIN,
                figures=f"{max(without.values()):.2f} m after a minute; reach 0.5 m",
            ),
            Claim(
                text="With the position, it does",
                holds=max(with_position.values()) <= REACH + MARGIN,
                figures=f"{max(with_position.values()):.4f} m",
            ),
        ),
        grids=(
            Grid(
                title="Largest displacement in a minute [m]",
                header=("row", *PUSH),
                rows=(
                    ("eq. C.2, with position", *(with_position[push] for push in PUSH)),
                    ("eq. 4.7 as printed", *(without[push] for push in PUSH)),
                ),
            ),
        ),
    )


def _level(value: float, label: str) -> Curve:
    return Curve(label=label, x=np.array([0.0, 10.0]), y=np.array([value, value]), dash=True)


def figure_c1(answers: Answers) -> Outcome:
    """Draw figure C.1: the braking control law for four values of T of travel and of tilt."""
    del answers
    panels = []
    for name, times, limit, unit in (
        ("travel", T_POSITION, REACH, "m"),
        ("tilt", T_TILT, 30.0, "deg"),
    ):
        responses = {T: free_response(T, c_v=C_V, c_u=0.45, limit=limit) for T in times}
        for what, index, of in (("", 1, unit), ("speed of ", 2, f"{unit}/s")):
            curves = [Curve(label=f"T = {T:g} s", x=r[0], y=r[index]) for T, r in responses.items()]
            panels.append(
                Panel(
                    title=f"{what}{name}".capitalize(),
                    x_label="time [s]",
                    y_label=f"[{of}]",
                    curves=tuple(curves),
                )
            )
    return Outcome(
        name="figure-c.1",
        kind="figure",
        title="Braking control law evolution for different parameter settings T",
        section="C.1",
        text=(
            "On its surface the law is linear and second order with damping ratio c_v/√(2 c_u) = 1.05 for "
            "every T: T stretches time and nothing else. What makes a T good is the acceleration that it "
            "asks for, 2 s_max / (c_u T²) from rest at the centre."
        ),
        panels=tuple(panels),
    )
