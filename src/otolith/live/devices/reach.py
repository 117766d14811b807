"""How far a device can go, and whether that holds what a session may ask of it."""

from typing import Final, NamedTuple

from otolith.core.arrays import Vec
from otolith.core.errors import InputError

ROUNDING: Final = 1e-6  # share of a range; what is outside by less is at its end


class Sent(NamedTuple):
    """The poses and leg lengths that a session may send."""

    low: Vec  # (6,) [m, rad] ends of the axes, relative to neutral
    high: Vec  # (6,)
    stroke: tuple[float, float]  # [m], of cranks [rad]


def check_span(
    what: str, span: tuple[float, float], needs: tuple[float, float], unit: str, remedy: str
) -> None:
    """Refuse a device whose span does not hold what it needs.

    Parameters
    ----------
    span, needs : ends in any order, and in the lower and higher order, both in `unit`.
    remedy : what the user may do.

    Raises
    ------
    InputError : the span is narrower.
    """
    low, high = sorted(span)
    room = ROUNDING * (high - low)
    if not (low - room <= needs[0] and needs[1] <= high + room):
        bound = f"at least {needs[0]:.4g} to {needs[1]:.4g} {unit}, where the platform may be sent; {remedy}"
        raise InputError(what, f"{low:.4g} to {high:.4g} {unit}", bound)
