"""What may change while a session runs: how much is cued, and knobs that an algorithm has.

A change is a number that the algorithm uses from its next decision on, so nothing is compiled for it. It
comes about gradually: no value moves faster than `SLEW`, whoever asks for it, and in whatever state. The gate
judges every plan as before.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Final, Self

SLEW: Final = 0.2  # [1/s] of every parameter; the ranges are 0 to 1, and 0.5 to 2 of factors
LONGEST_STEP: Final = 0.1  # [s] for which values move at once; a machine that slept makes no jump of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """The values: scale and liveliness between 0 and 1, factors of corner frequencies between 0.5 and 2."""

    scale: float = 1.0  # of forces and rates
    liveliness: float = 0.5  # of predictive
    high_pass: float = 1.0  # of classical
    low_pass: float = 1.0  # of classical

    def toward(self, asked: Self, most: float) -> Self:
        """Return the values that are nearest to those asked for, and differ from these by at most `most`."""
        values = {one.name: (getattr(self, one.name), getattr(asked, one.name)) for one in fields(self)}
        return type(self)(
            **{name: now + min(most, max(-most, to - now)) for name, (now, to) in values.items()}
        )


class Tuned:
    """Parameters on their way to what was asked for.

    Parameters
    ----------
    use : is called with new values before the decision that they are for; it has to be quick, and must not
        compile anything.
    """

    def __init__(
        self, now: Parameters | None = None, use: Callable[[Parameters], None] = lambda _: None
    ) -> None:
        self.now = self.asked = Parameters() if now is None else now
        self._use = use

    def step(self, dt: float, asked: Parameters | None) -> None:
        """Go on by dt [s], towards new values if there are any."""
        self.asked = self.asked if asked is None else asked
        if self.now != self.asked:
            self.now = self.now.toward(self.asked, SLEW * min(dt, LONGEST_STEP))
            self._use(self.now)
