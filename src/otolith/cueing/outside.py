"""Cueing algorithms from outside this package: made here, and supervised while they decide.

The maker is a class or function that returns a `Cueing`. An argument named `design` receives the
`otolith.cueing.design.Design`, with the platform, what is cued and all options. Without this argument the
maker is called without arguments. Three attributes of the maker may describe its algorithms:

- `reads` : names of the options it reads, such as {"horizon"}; all other options of algorithms are refused.
- `plant` : the plant that its model describes ("ideal" by default).
- `limited` : whether it knows the platform's limits and keeps them (False by default).
"""

import inspect
import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from otolith.core.errors import InputError
from otolith.core.plugins import BrokenPlugin
from otolith.cueing.mpc.rows import plausible
from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference, Status
from otolith.safety.stopping import Stopping

_PARTS: Final = ("period", "reset", "step")
_VECTORS: Final = ("acceleration", "pose", "twist")


def make_outside(maker: Callable[..., Any], design: Any, *, name: str) -> Cueing:
    """Return the algorithm that a maker from outside makes for a design.

    Raises
    ------
    BrokenPlugin : the maker raised an error.
    InputError : the maker cannot be called in this way, or does not return a cueing algorithm.
    """
    try:
        arguments = {"design": design} if "design" in inspect.signature(maker).parameters else {}
        inspect.signature(maker).bind(**arguments)
    except (TypeError, ValueError):
        bound = "a class or function that takes an argument 'design', or none"
        raise InputError("--cueing", repr(name), bound) from None
    try:
        made = maker(**arguments)
        missing = [part for part in _PARTS if not hasattr(made, part)]
    except Exception as error:
        raise BrokenPlugin(f"--cueing {name}", "could not be made", error) from error
    if missing:
        raise InputError(
            f"--cueing {name}", f"without {' and '.join(missing)}", "a cueing algorithm: period, reset, step"
        )
    return Watched(made, design, name=name)


class Watched:
    """An algorithm from outside, whose author's mistakes become one sentence that states where they are.

    The shipped algorithms never raise in `step`, which cannot be assumed of others. A state or a reference
    with implausible numbers never reaches them: the fallback of `otolith.safety.stopping` brakes instead.
    """

    def __init__(self, inner: Cueing, design: Any, *, name: str) -> None:
        self._inner, self._name = inner, name
        self.soft: frozenset[str] = frozenset(getattr(inner, "soft", ()))
        period = inner.period
        if not (isinstance(period, int | float) and math.isfinite(period) and period > 0.0):
            raise InputError(f"period of --cueing {name}", repr(period), "a number of seconds greater than 0")
        self.period: float = float(period)
        self._stopping = Stopping(design.platform, design.dofs, lag=0.0, period=self.period)

    def reset(self, state: PlatformState) -> None:
        """Discard the past; errors are those of `step`."""
        self._stopping.reset(state)
        try:
            self._inner.reset(state)
        except Exception as error:
            raise BrokenPlugin(f"--cueing {self._name}", "failed in reset", error) from error

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide one command; brake if the state or the reference is implausible.

        Raises
        ------
        BrokenPlugin : the algorithm raised an error.
        InputError : the algorithm returned something other than a command, or a vector of another shape or
            with numbers that are not finite.
        """
        wanted = (reference.specific_force, reference.angular_rate)
        if not (self._stopping.observe(state) and all(map(plausible, wanted))):
            return self._stopping.rest(Outcome(status=Status.INVALID))
        try:
            command = self._inner.step(state, reference)
        except Exception as error:
            raise BrokenPlugin(f"--cueing {self._name}", "failed in step", error) from error
        if not (isinstance(command, Command) and isinstance(command.outcome, Outcome)):
            bound = "an otolith.Command with an otolith.Outcome"
            raise InputError(f"what step of --cueing {self._name} returned", type(command).__name__, bound)
        for part in _VECTORS:
            value = getattr(command, part)
            if not (isinstance(value, np.ndarray) and value.shape == (6,) and np.isfinite(value).all()):
                raise InputError(
                    f"{part} of a command of --cueing {self._name}",
                    value,
                    "six finite numbers, an array (6,)",
                )
        return command
