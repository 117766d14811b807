"""The legs of a platform as a program: from a pose to what the drives of its six legs are told."""

from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.jit import kernel
from otolith.export.header import header
from otolith.export.program import Port, Program, per_axis
from otolith.export.translate.render import Rendered
from otolith.export.translate.unit import translated
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import Actuators, lengths_along

_POSE: Final = per_axis("pose", "", "{} from the neutral pose")


class Legs(NamedTuple):
    """A pose, and what the drives are told in it."""

    of: Actuators
    pose: Mat  # (1, 6)
    told: Mat  # (1, 6) [m] lengths of legs, or [rad] angles of cranks


@kernel
def tell_once(legs: Any) -> int:
    """Write what the drives are told; NaN where the rod of a crank does not reach. Returns 0."""
    lengths_along(legs.pose, legs.of, legs.told)
    if legs.of.radius > 0.0:
        for i in range(6):
            legs.told[0, i] /= legs.of.radius
    return 0


def legs_program(hexapod: Hexapod, name: str, period: float) -> Program:
    """Return the inverse kinematics of six legs as a program, which remembers nothing."""
    measure, word = ("m", "length of leg") if hexapod.cranks is None else ("rad", "angle of crank")
    at_rest = hexapod.positions(np.zeros(6))
    drives = tuple(
        Port(f"leg_{i + 1}", measure, f"{word} {i + 1}", start=float(at_rest[i])) for i in range(6)
    )
    legs = Legs(hexapod.actuators, np.zeros((1, 6)), np.zeros((1, 6)))
    told: Any = tell_once  # as compiled, which its type does not say
    unit, function = translated(told.py_func, legs)
    text = header(
        Rendered(unit, function, name, [legs.pose, legs.told]),
        "the legs of a motion platform",
        "A step gives, for one pose, what the drives of the six legs are told there.",
        returns="0",
        period=period,
        inputs=[_POSE],
        outputs=[drives],
        read=[(legs.pose, 0, 6)],
        write=[(legs.told, 0, 6)],
    )
    return Program(name=name, period=period, inputs=_POSE, outputs=drives, header=text)
