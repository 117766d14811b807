"""Cueing on a platform that is carried by a base: which of the two moves the driver.

`joint` decides for both in one problem: the base's commands are more columns of B, and the weights and lags
of both decide who does what. `lnl` and `nll` decide for one after the other, as Soyer, Olaru & Fang (2021)
do in the thesis's description (section 2.4.2): the first MPC follows the force wanted as if it were alone,
and the second follows what the first one's plan leaves of it, over a horizon that may be shorter. In `lnl`
the base is first, whose model is linear; in `nll` the platform. `split` is the fixed first-order split of
Bruschetta, Maran & Beghi (2017): one MPC plans the motion of the driver as if one carrier made it, and a
low-pass at 2 Hz gives the base its part. (The papers themselves were not available.)

All four are `predictive` where no base moves, bit for bit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.core.frames import Dof
from otolith.cueing.design import Design, groups_of, predictive, together
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.named import Prediction
from otolith.cueing.split import Split, as_one
from otolith.interfaces import Cueing, Predictor, Reference
from otolith.qp.blocked import Lengths


def joint(design: Design) -> Cueing:
    """Make `predictive` over all carriers at once."""
    return together([_mpc(design, (*dofs, *design.platform.bases(dofs))) for dofs in groups_of(design)])


def lnl(design: Design) -> Cueing:
    """Make an MPC of the base, and one of the platform for what the base leaves."""
    _refuse_lost(design)
    return together([part for dofs in groups_of(design) for part in _in_turn(design, dofs, base_first=True)])


def nll(design: Design) -> Cueing:
    """Make an MPC of the platform, and one of the base for what the platform leaves."""
    _refuse_lost(design)
    return together([part for dofs in groups_of(design) for part in _in_turn(design, dofs, base_first=False)])


def split(design: Design) -> Cueing:
    """Make `predictive` for a single carrier with the reach of both, and the split of its commands."""
    platform = design.platform
    if not platform.bases(design.dofs):
        return predictive(design)
    inner = predictive(replace(design, platform=as_one(platform, design.dofs)))
    return Split(inner, platform, design.dofs)


def _refuse_lost(design: Design) -> None:
    """Refuse blocks of a second MPC where no base is moved, so that there is none."""
    if design.second_blocks and not design.platform.bases(design.dofs):
        names = ",".join(dof.name for dof in design.dofs)
        bound = f"left out: no base of platform {design.platform.name} moves along {names}"
        raise InputError("--second-blocks", "given", bound)


def _in_turn(design: Design, dofs: tuple[Dof, ...], *, base_first: bool) -> Sequence[Cueing]:
    """Return the two MPCs of degrees of freedom and of what carries them, the first one first."""
    base = design.platform.bases(dofs)
    if not base:
        return [_mpc(design, dofs)]
    order = (base, dofs) if base_first else (dofs, base)
    first = _mpc(design, order[0])
    rest = _Rest(of=design.mpc.prediction or Adaptive(), first=first)
    return [first, _mpc(design, order[1], prediction=rest, blocks=design.second_blocks)]


def _mpc(
    design: Design, dofs: tuple[Dof, ...], *, prediction: Prediction | None = None, blocks: Lengths = ()
) -> Mpc:
    settings = predictive_settings(design.mpc, design.platform, dofs, design.liveliness)
    if blocks:
        if sum(blocks) > settings.horizon:
            bound = f"at most the first one's {settings.horizon} steps"
            raise InputError("horizon of the second MPC", f"{sum(blocks)} steps", bound)
        settings = replace(settings, horizon=sum(blocks), blocks=blocks)
    return Mpc(design.platform, dofs, replace(settings, prediction=prediction or settings.prediction))


@dataclass(frozen=True, eq=False)
class _Rest:
    """The prediction of the second MPC: what the first one's plan leaves of what will be wanted."""

    of: Prediction
    first: Mpc

    @property
    def foresees(self) -> float:
        """Return how far ahead the loop must give forces [s]."""
        return self.of.foresees

    def begin(self) -> Predictor:
        """Return a predictor with a memory of its own."""
        return _Remaining(self.of.begin(), self.first)


class _Remaining:
    """Predicts what will be wanted less what the first MPC, which has just decided, will make felt."""

    def __init__(self, inner: Predictor, first: Mpc) -> None:
        self._inner, self._first = inner, first

    def reset(self) -> None:
        """Discard the past."""
        self._inner.reset()

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return what will be left at the ends of the next n periods of dt [s], (n, 6).

        The plan starts at the time of the state, which may be `reference.age` later than the reference.
        """
        coming = self._inner.ahead(reference, dt, n)
        column, felt = self._first.will_be_felt()
        at = np.arange(n) - reference.age / dt
        for c, j in enumerate(column):
            coming[:, j] -= np.interp(at, np.arange(len(felt)), felt[:, c])
        return coming
