"""The certified sets of a platform: they are found, checked, and tried for all axes that it can cue.

It is proved, exactly but for rounding, that from every state of an axis' set a command leads into the set at
the next node, and so on for ever. Surge and sway of a platform with a limit circle can do so together.
Nothing is proved about legs, or about a platform that does not follow as its file states.
"""

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from otolith.core.frames import AXES, DOFS, Dof
from otolith.cueing.mpc.axis_sets import axes_on, axis_sets
from otolith.cueing.mpc.rows import BrakingRows
from otolith.platforms import Platform
from otolith.safety.invariant.axis import LEAST_LAG, Axis
from otolith.safety.invariant.certificate import AxisCertificate, Judgement, check
from otolith.safety.invariant.trial import Trial, drive

CIRCLE: Final = "circle"  # name of the joint trial of surge and sway
OnProgress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class TerminalSets:
    """The sets of all axes that a platform can cue with their certificates, by the axes' names.

    Raises
    ------
    ValueError : the sets are not those of the platform's axes.
    """

    platform: Platform
    braking: BrakingRows  # rows that the sets keep
    lag: float  # T [s]
    period: float  # Δ [s]
    axes: Mapping[str, AxisCertificate]

    def __post_init__(self) -> None:
        if set(self.axes) != set(self.described()):
            raise ValueError(f"it has sets of {', '.join(self.axes)}, not of the axes that its platform cues")

    @classmethod
    def of(cls, platform: Platform, braking: BrakingRows, *, period: float) -> Self:
        """Find the sets of a platform's axes; errors are those of `axis_sets`."""
        lag = max(platform.actuators.lag_s, LEAST_LAG)
        found = {
            AXES[i]: AxisCertificate.of(one)
            for dof in _cued(platform)
            for i, one in zip(
                dof.axes, axis_sets(platform, dof, braking, lag=lag, period=period), strict=True
            )
        }
        return cls(platform=platform, braking=braking, lag=lag, period=period, axes=found)

    def attributes(self) -> dict[str, Any]:
        """Return everything but the arrays, for a file."""
        of_platform = {"platform": self.platform.model_dump_json(), "platform_sha256": self.digest}
        return of_platform | {"braking": self.braking.value, "lag": self.lag, "period": self.period}

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of all certificates by name; each name starts with that of its axis."""
        return {
            f"{axis}/{name}": array
            for axis, certificate in self.axes.items()
            for name, array in certificate.to_arrays().items()
        }

    @classmethod
    def restored(cls, attributes: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the sets of a file, from the values of `attributes` and `to_arrays`.

        Raises
        ------
        CorruptFile : an array of a certificate is missing or damaged.
        KeyError, ValueError : an attribute is missing or damaged.
        """
        groups: dict[str, dict[str, NDArray[Any]]] = {}
        for name, array in arrays.items():
            axis, _, own = name.partition("/")
            groups.setdefault(axis, {})[own] = array
        sets = cls(
            platform=Platform.model_validate_json(attributes["platform"]),
            braking=BrakingRows(attributes["braking"]),
            lag=float(attributes["lag"]),
            period=float(attributes["period"]),
            axes={axis: AxisCertificate.from_arrays(group) for axis, group in groups.items()},
        )
        if sets.digest != attributes["platform_sha256"]:
            raise ValueError("the platform does not have the SHA-256 that the file states")
        if not (0.0 < sets.period < math.inf and LEAST_LAG <= sets.lag < math.inf):
            raise ValueError(f"the file states a lag of {sets.lag:g} s and periods of {sets.period:g} s")
        return sets

    @property
    def digest(self) -> str:
        """Return the SHA-256 of the platform to which the sets belong."""
        return digest(self.platform)

    def ahead(self, axis: str) -> float:
        """Return τ [s] of an axis' wedge."""
        return float(self.axes[axis].forms[-1, 1]) - self.lag

    def described(self) -> dict[str, Axis]:
        """Return the axes as the platform's file describes them."""
        return {
            AXES[i]: axis
            for dof in _cued(self.platform)
            for i, axis in zip(
                dof.axes,
                axes_on(self.platform, dof, self.braking, lag=self.lag, period=self.period),
                strict=True,
            )
        }

    def check(self) -> dict[str, Judgement]:
        """Judge every certificate by the platform's file alone.

        Surge and sway are judged together. Both need the same wedge, so that the circle limits their z. If
        their wedges differ, all commands of both are refused.
        """
        described = self.described()
        judged = {name: check(self.axes[name], axis) for name, axis in described.items()}
        shared = self.in_circle()
        if len({tuple(self.axes[name].forms[-1]) for name in shared}) > 1:
            judged |= {name: replace(judged[name], refused=judged[name].vertices) for name in shared}
        return judged

    def in_circle(self) -> tuple[str, ...]:
        """Return the names of the axes that share the platform's circle."""
        return tuple(name for name, axis in self.described().items() if axis.shares_circle)

    def tried(
        self, *, states: int, steps: int, seed: int, progress: OnProgress = lambda *_: None
    ) -> dict[str, Trial]:
        """Let adversaries drive every axis, and surge and sway together if they share a circle."""
        described, rng = self.described(), np.random.default_rng(seed)
        groups: dict[str, tuple[str, ...]] = {name: (name,) for name in described}
        groups |= {CIRCLE: shared} if (shared := self.in_circle()) else {}
        found: dict[str, Trial] = {}
        for name, members in groups.items():
            progress(f"{name}: {states} states, {steps} periods each", len(found) / len(groups))
            found[name] = drive(
                [(described[one], self.axes[one]) for one in members],
                circle=(self.platform.circle or math.inf) if name == CIRCLE else math.inf,
                states=states,
                steps=steps,
                rng=rng,
            )
        return found


def digest(platform: Platform) -> str:
    """Return the SHA-256 of everything in a platform's file."""
    return hashlib.sha256(platform.model_dump_json().encode()).hexdigest()


def _cued(platform: Platform) -> list[Dof]:
    return [dof for dof in DOFS.values() if platform.can_cue(dof)]
