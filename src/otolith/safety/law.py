"""How a platform comes to rest inside its limits from any state: the fallback of every algorithm.

Notation: per axis p position, v speed, a acceleration; u the command, held over a period Δ, which a follows
with lag T: ȧ = (u − a)/T. The *leading* position and speed

    q = p + T v,    w = v + T a    obey    q̇ = w,  ẇ = u    exactly,

a double integrator without lag. In turn T ṗ = q − p and T v̇ = w − v: p and v follow q and w through a
low-pass without overshoot. So an interval (or disc) that contains p now and q always contains p always, and
likewise for v and w. With T = 0 they are equal.

*Stopping in n periods* takes w linearly to zero, with u = −w/(nΔ) in the first period, over the distance w n
Δ/2. *Full braking*, u = ∓U while |w| ≥ UΔ and then the rest, covers the smallest distance, because nothing
reduces w sooner; w = mUΔ + r with 0 ≤ r < UΔ needs mΔ(w − mUΔ/2) + rΔ/2.

Safe set: q, and the position where full braking would end, are within reach. From a safe state the law uses a
comfortable number of periods, at most as many as the room allows and at least as many as U needs; if that is
impossible, it brakes fully. Both choices lead to a safe state: after one period of stopping in n periods,
stopping in n − 1 periods ends at the same position, and full braking continues as full braking. |w| falls, so
the number of periods is finite. Therefore the law, if applied in every period, comes to rest inside the
limits from every safe state, with any number of interruptions.

Surge and sway that share a circle stop in the same number of periods. The path is then straight, from q to
the end, and a disc is convex. From a state that is not safe (a measurement beyond a limit, a start outside)
the law first brakes fully, then returns inside without overshoot: ẇ = (w* − w)/t_w, w* = (b − q)/(10 t_w)
towards a position b inside has two real poles.

Checked by tests/safety/test_stopping.py from random states and with random interruptions.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel

HUGE: Final = 1e6  # [SI] larger than any real state, far below overflow
GUARD: Final = 1e-9  # [m, rad] margin to the ends of the reach, larger than rounding errors
EASE: Final = 0.25  # [s] duration of a comfortable stop from the largest speed
LONGEST: Final = 1000  # largest number of periods of a plan that comes to rest
_AT_REST: Final = 1e-9  # [SI] smaller commands end a plan
_RETURN: Final = 0.01  # share of the reach by which a platform that was outside returns inside
_AGAIN: Final = 0.25  # largest speed of the return, as a share of the speed limit
UNLIMITED: Final = 1e12  # replaces a limit that a platform's file does not give


class Reach(NamedTuple):
    """Limits of the six axes as the law reads them; axes that are not cued have a command of 0."""

    low: Vec  # (6,) [m ×3, rad ×3]
    high: Vec  # (6,)
    speed: Vec  # (6,) [m/s ×3, rad/s ×3]
    command: Vec  # (6,) U [m/s² ×3, rad/s² ×3]
    circle: float  # [m] radius of the limit of surge and sway together; infinite if there is none
    lag: float  # T [s]
    period: float  # Δ [s]


@kernel
def _full_braking(w: float, U: float, dt: float) -> float:
    """Return the distance of full braking from the leading speed w, with the sign of w."""
    full = np.floor(abs(w) / (U * dt))
    rest = abs(w) - full * U * dt
    return math.copysign(full * dt * (abs(w) - 0.5 * full * U * dt) + 0.5 * rest * dt, w)


@kernel
def _needed(w: float, U: float, dt: float) -> float:
    """Return the smallest number of periods n ≥ 1 with |w|/(nΔ) ≤ U."""
    return max(1.0, float(np.ceil(abs(w) / (U * dt) - 1e-9)))


@kernel
def _room(q: float, w: float, low: float, high: float, dt: float) -> float:
    """Return the largest number of periods in which stopping ends within [low, high]; 0 if there is none."""
    if w == 0.0:
        return 1e9 if low <= q <= high else 0.0
    ahead = (high - q) if w > 0.0 else (q - low)
    return max(0.0, float(np.floor(2.0 * ahead / (abs(w) * dt) + 1e-6)))  # math.floor's integer overflows


@kernel
def _room_in_circle(q: Vec, w: Vec, radius: float, dt: float) -> float:
    """Return the largest number of periods in which stopping ends within the circle; 0 if there is none."""
    inside = radius * radius - q[0] * q[0] - q[1] * q[1]
    speed = w[0] * w[0] + w[1] * w[1]
    if inside < 0.0 or speed == 0.0:
        return 0.0 if inside < 0.0 else 1e9
    along = q[0] * w[0] + q[1] * w[1]
    periods: float = 2.0 * (math.sqrt(along * along + speed * inside) - along) / (speed * dt)
    return float(np.floor(periods + 1e-6))


@kernel
def _axis_safe(q: float, w: float, low: float, high: float, U: float, dt: float) -> bool:
    """Return whether q and the end of full braking lie within [low, high]."""
    end = q + _full_braking(w, U, dt)
    return low - GUARD <= q <= high + GUARD and low - GUARD <= end <= high + GUARD


@kernel
def _leading(motion: Mat, T: float, q: Vec, w: Vec) -> None:
    for i in range(6):
        q[i] = motion[0, i] + T * motion[1, i]
        w[i] = motion[1, i] + T * motion[2, i]


@kernel
def _together(q: Vec, w: Vec, reach: Reach, guard: float) -> tuple[float, float]:
    """Return the numbers of periods that surge and sway need to stop together, and that the room allows."""
    dt, n_needed = reach.period, 1.0
    n_room = _room_in_circle(q, w, reach.circle + guard, dt)
    for i in range(2):
        n_needed = max(n_needed, _needed(w[i], reach.command[i], dt))
        n_room = min(n_room, _room(q[i], w[i], reach.low[i] - guard, reach.high[i] + guard, dt))
    return n_needed, n_room


@kernel
def safe(motion: Mat, reach: Reach) -> bool:
    """Return whether full braking from `motion` (3, 6) ends within reach, and within a circle if given."""
    q, w = np.empty(6), np.empty(6)
    _leading(motion, reach.lag, q, w)
    for i in range(6):
        cued = reach.command[i] > 0.0
        if cued and not _axis_safe(q[i], w[i], reach.low[i], reach.high[i], reach.command[i], reach.period):
            return False
    if reach.circle < np.inf:
        n_needed, n_room = _together(q, w, reach, GUARD)
        return n_room >= n_needed
    return True


@kernel
def _back(q: float, w: float, inside: float, reach: Reach, i: int) -> float:
    """Return the command that takes an axis at rest, or already returning, to the position `inside`."""
    loop = max(2.0 * reach.period, 0.05)
    fastest = _AGAIN * reach.speed[i]
    wanted = min(fastest, max(-fastest, (inside - q) / (10.0 * loop)))
    command: float = min(reach.command[i], max(-reach.command[i], (wanted - w) / loop))
    return command


@kernel
def _brake(w: float, n: float, U: float, dt: float) -> float:
    """Return the command of the first period of stopping in n periods, which are no fewer than U needs."""
    return -math.copysign(min(U, abs(w) / (n * dt)), w)


@kernel
def _full(w: float, reach: Reach, i: int) -> float:
    strength: float = min(reach.command[i], abs(w) / reach.period)
    return -math.copysign(strength, w)


@kernel
def _turn(w: float, room: float, reach: Reach, i: int) -> float:
    """Return the command of full braking, or more if that keeps the end of this period within the room."""
    dt = reach.period
    within = 2.0 * (abs(w) * dt - room) / (dt * dt)
    strength: float = min(reach.command[i], max(abs(w) / dt, within))
    return -math.copysign(strength, w)


@kernel
def _comfortable(w: float, fastest: float, dt: float) -> float:
    """Return the number of periods in which a stop from the leading speed w is comfortable."""
    return float(np.ceil(abs(w) * EASE / (fastest * dt)))


@kernel
def _axis(q: float, w: float, reach: Reach, i: int) -> float:
    """Return the command of a single axis."""
    low, high, U, dt = reach.low[i], reach.high[i], reach.command[i], reach.period
    n_room = _room(q, w, low, high, dt)
    n_needed = _needed(w, U, dt)
    if n_room >= n_needed and low <= q <= high:
        n = max(n_needed, min(n_room, _comfortable(w, reach.speed[i], dt)))
        return _brake(w, n, U, dt)
    if _axis_safe(q, w, low, high, U, dt):
        return _full(w, reach, i)
    inside = low <= q <= high
    outwards = 1.0 if (q + _full_braking(w, U, dt) if inside else q) > high else -1.0
    if w * outwards > 0.0:
        room = high - q if outwards > 0.0 else q - low
        return _turn(w, room if inside else np.inf, reach, i)
    margin = _RETURN * min(high - low, UNLIMITED)
    return _back(q, w, (high if outwards > 0.0 else low) - outwards * margin, reach, i)


@kernel
def _in_circle(q: Vec, w: Vec, reach: Reach, u: Vec) -> None:
    """Write the commands of surge and sway, which share a circle."""
    n_needed, n_room = _together(q, w, reach, 0.0)
    dt = reach.period
    n_comfortable = max(_comfortable(w[0], reach.speed[0], dt), _comfortable(w[1], reach.speed[1], dt))
    n = max(n_needed, min(n_room, n_comfortable))
    distance = math.sqrt(q[0] * q[0] + q[1] * q[1])
    outwards = q[0] * w[0] + q[1] * w[1] > 0.0
    if n_room >= n_needed or distance <= reach.circle or outwards:
        for i in range(2):
            u[i] = _brake(w[i], n, reach.command[i], dt)
        return
    for i in range(2):
        u[i] = _back(q[i], w[i], q[i] / distance * reach.circle * (1.0 - 2.0 * _RETURN), reach, i)


@kernel
def stop(motion: Mat, reach: Reach, u: Vec) -> None:
    """Write the law's commands (6,) for `motion` (3, 6)."""
    stop_by(motion, reach, u, np.empty(6), np.empty(6))


@kernel
def stop_by(motion: Mat, reach: Reach, u: Vec, q: Vec, w: Vec) -> None:
    """Write the law's commands (6,) for `motion` (3, 6); q and w (6,) are to work with."""
    _leading(motion, reach.lag, q, w)
    shared = reach.circle < np.inf  # by surge and sway
    for i in range(2 if shared else 0, 6):
        u[i] = _axis(q[i], w[i], reach, i) if reach.command[i] > 0.0 else 0.0
    if shared:
        _in_circle(q, w, reach, u)


@kernel
def decay(T: float, dt: float) -> float:
    """Return the share of an acceleration that is left after dt [s] of lag T [s]."""
    return math.exp(-dt / T) if T > 0.0 else 0.0


@kernel
def move(motion: Mat, u: Vec, T: float, dt: float) -> None:
    """Advance `motion` (3, 6) exactly by dt [s] under held commands (6,) with lag T [s]."""
    move_by(motion, u, T, dt, decay(T, dt))


@kernel
def move_by(motion: Mat, u: Vec, T: float, dt: float, rho: float) -> None:
    """Advance `motion` (3, 6) as `move` does, with `decay` rho known."""
    for i in range(6):
        p, v, a = motion[0, i], motion[1, i], motion[2, i]
        if T == 0.0:
            a = u[i]
        q, w = p + T * v, v + T * a
        q += dt * w + 0.5 * dt * dt * u[i]
        w += dt * u[i]
        a = u[i] + rho * (a - u[i])
        motion[2, i] = a
        motion[1, i] = w - T * a
        motion[0, i] = q - T * motion[1, i]


@kernel
def advance(motion: Mat, u: Vec, reach: Reach) -> None:
    """Advance `motion` (3, 6) by one period under the held commands (6,), in place."""
    move(motion, u, reach.lag, reach.period)


@kernel
def allowed(motion: Mat, u: Vec, reach: Reach) -> bool:
    """Return whether commands (6,) keep a motion (3, 6) safe; True if it is not safe now."""
    if not safe(motion, reach):
        return True
    after = motion.copy()
    advance(after, u, reach)
    return safe(after, reach)


@kernel
def none_above(u: Vec, most: float) -> bool:
    """Return whether no command (6,) is larger than `most`."""
    left = 0
    for i in range(6):
        left += not abs(u[i]) <= most  # a NaN fails every comparison
    return left == 0


@kernel
def to_rest(motion: Mat, reach: Reach, given: int, out: Mat) -> int:
    """Write after the `given` commands in `out` (K, 6) the law's until rest; return the number of all.

    `motion` (3, 6) advances by the first command.
    """
    ahead, k = motion.copy(), 0
    rho = decay(reach.lag, reach.period)
    while k < len(out):
        if k >= given:
            stop(ahead, reach, out[k])
            if k > 0 and none_above(out[k], _AT_REST):
                break
        move_by(ahead, out[k], reach.lag, reach.period, rho)
        if k == 0:
            for j in range(3):
                for i in range(6):
                    motion[j, i] = ahead[j, i]
        k += 1
    return k
