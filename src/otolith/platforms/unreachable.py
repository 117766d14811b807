"""Why six legs cannot make a pose, each in one sentence."""

import math

from otolith.core.errors import OtolithError


class LegOutsideStroke(OtolithError):
    """A pose needs a leg longer or shorter than its actuator allows."""

    def __init__(self, leg: int, length: float, stroke: tuple[float, float]) -> None:
        low, high = stroke
        super().__init__(f"leg {leg + 1} needs {length:.4f} m, its stroke is {low:.4f} to {high:.4f} m")
        self.leg, self.length, self.stroke = leg, length, stroke


class CrankOutsideRange(OtolithError):
    """A pose needs a crank angle that its actuator does not allow."""

    def __init__(self, leg: int, angle: float, span: tuple[float, float]) -> None:
        found, low, high = (math.degrees(one) for one in (angle, *span))
        super().__init__(f"crank {leg + 1} needs {found:.2f} deg, its range is {low:g} to {high:g} deg")
        self.leg, self.angle, self.span = leg, angle, span


class RodDoesNotReach(OtolithError):
    """No angle of a crank brings its rod to the platform, or only one close to the crank's dead centre."""

    def __init__(self, leg: int, *, leverage: float = 0.0, bound: float = 0.0) -> None:
        why = "for no angle of the crank"
        if leverage > 0.0:
            found = f"n·t = {leverage:.3g}, must be above {bound:g}"
            why = f"only with the crank near its dead centre ({found})"
        super().__init__(f"the rod of crank {leg + 1} reaches the platform in this pose {why}")
        self.leg, self.leverage = leg, leverage


class NoPose(OtolithError):
    """Newton's method found no pose of the given leg lengths."""


class Singular(OtolithError):
    """In this pose the legs cannot hold the platform, or hardly."""

    def __init__(self, condition: float, bound: float) -> None:
        super().__init__(
            f"the legs' condition number is {condition:.3g} in this pose, must be below {bound:g}"
        )
        self.condition, self.bound = condition, bound


class LeansTooFar(OtolithError):
    """In this pose a leg leans further than its joint allows."""

    def __init__(self, leg: int, joint: str, lean: float, most: float) -> None:
        found, bound = math.degrees(lean), math.degrees(most)
        super().__init__(
            f"leg {leg + 1} leans {found:.1f} deg at its {joint} joint in this pose, "
            f"must be at most {bound:g} deg"
        )
        self.leg, self.joint, self.lean, self.most = leg, joint, lean, most
