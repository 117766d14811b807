"""The composition root: every algorithm in a few lines, from the same parts, so that differences show.

The thesis's four models (section 3.1) differ in their guess alone; `hybrid-learned`, `-law` and `-table` in
what they know of the working set. `implicit-sensed` is the thesis's third recommendation (chapter 8): the
implicit MPC with the sensed force and rate tracked instead of the physical force. `linear-mpc` is of the kind
of Beghi, Bruschetta & Maran (2012), with Telban's organs in a linear prediction and limits on place and speed
in the driver's frame, split as Garrett & Best (2013) do into problems that do not know of each other. What
their papers leave open is chosen here: horizon, lag and engine are those of the implicit MPC, so that the
difference is the model and not the effort. (The papers themselves were not at hand; the description is the
thesis's, section 2.4.2.)
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, Dof, pairs_of
from otolith.cueing.hints.stored import Kind, Refused, StoredHint
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.explicit import Explicit, ExplicitLaw
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_platform, explicit_problem
from otolith.cueing.mpc.guess import FromExplicit, Guess, HeldPlan, Hint, MissingHint, NoGuess
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.prediction import Oracle
from otolith.cueing.several import Several
from otolith.cueing.washout.tuning import Tuning, load_tuning
from otolith.interfaces import Cueing
from otolith.mpqp import Law, Progress, enumerate_regions
from otolith.perception import Vestibular
from otolith.platforms import Platform

LINEAR_WASHOUT: Final = {"position": 5.0, "velocity": 5.0}  # constant, in the manner of Table 5.3


@dataclass(frozen=True, kw_only=True)
class Design:
    """Everything a cueing algorithm is made from, apart from which algorithm it is."""

    platform: Platform
    dofs: tuple[Dof, ...] = (SURGE_PITCH,)  # what is cued
    explicit: ExplicitSettings = field(default_factory=ExplicitSettings)
    mpc: MpcSettings = field(default_factory=MpcSettings)
    entry: Entry = Entry.REFERENCE
    liveliness: float = 0.5  # of `predictive`, 0 to 1: how much travel is spent on what is felt
    washout: Tuning | None = None  # of the conventional washouts; none: the one shipped for the platform
    stored_laws: tuple[Law, ...] = ()  # from a file; enumerated on first use when there is none
    hint: StoredHint | Refused | None = None  # offline knowledge, from a file
    progress: Callable[[Progress], None] | None = None  # is called with how the enumeration goes

    def __post_init__(self) -> None:
        if not 0.0 <= self.liveliness <= 1.0:
            raise InputError("liveliness", self.liveliness, "between 0 and 1")

    @property
    def preview(self) -> int:
        """Periods of the future that the loop has to hand to the algorithm: none but for an oracle."""
        oracle = self.mpc.prediction
        return math.ceil(oracle.time / self.mpc.period) if isinstance(oracle, Oracle) else 0

    @property
    def pairs(self) -> tuple[Dof, ...]:
        """The axis pairs among `dofs`."""
        return pairs_of(self.dofs)

    @property
    def tuning(self) -> Tuning:
        """Tuning of the conventional washouts; errors as `otolith.cueing.washout.tuning.load_tuning`."""
        return self.washout or load_tuning(self.platform.name)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The explicit law of each degree of freedom; enumerated once.

        Raises
        ------
        InputError : none of the stored laws belongs to this platform, degree of freedom and settings.
        """
        seen = explicit_platform(self.platform, self.dofs)
        problems = [explicit_problem(dof, seen.limits(dof), seen.braking, self.explicit) for dof in self.dofs]
        if not self.stored_laws:
            return tuple(enumerate_regions(problem, progress=self.progress) for problem in problems)
        stored = {law.problem.digest: law for law in self.stored_laws}
        for dof, problem in zip(self.dofs, problems, strict=True):
            if problem.digest not in stored:
                raise InputError(
                    "the stored law's model",
                    ", ".join(digest[:12] for digest in stored),
                    f"{problem.digest[:12]}, {dof.name} of platform {self.platform.name} as chosen",
                )
        return tuple(stored[problem.digest] for problem in problems)

    def laws_at_work(self) -> list[ExplicitLaw]:
        """A fresh evaluator of each law, with its own memory of the last region."""
        return [ExplicitLaw(law, dof, self.explicit) for dof, law in zip(self.dofs, self.laws, strict=True)]


def predictive(design: Design) -> Cueing:
    """The implicit MPC with a long horizon, a prediction that learns, and as little washout as will do."""
    groups = [group for group in (design.pairs, *_alone(design)) if group]
    return _together(
        [
            Mpc(
                design.platform,
                dofs,
                predictive_settings(design.mpc, design.platform, dofs, design.liveliness),
            )
            for dofs in groups
        ]
    )


def explicit(design: Design) -> Cueing:
    """The explicit laws alone."""
    return Explicit(explicit_platform(design.platform, design.dofs), design.dofs, design.laws_at_work())


def implicit(design: Design) -> Cueing:
    """Model 1: no guess."""
    return _guessing(design, lambda _: NoGuess())


def implicit_trajectory(design: Design) -> Cueing:
    """Model 2: the first control of the previous plan."""
    return _guessing(design, lambda _: HeldPlan())


def hybrid_first(design: Design) -> Cueing:
    """Model 3: the explicit law's first input."""
    return _guessing(design, lambda pairs: FromExplicit(pairs.laws_at_work(), first_only=True))


def hybrid_all(design: Design) -> Cueing:
    """Model 4: all inputs of the explicit law."""
    return _guessing(design, lambda pairs: FromExplicit(pairs.laws_at_work(), first_only=False))


def hybrid_learned(design: Design) -> Cueing:
    """The answer of model 1, found with a network's hint where that is better than the previous set."""
    return _hinted(design, Kind.LEARNED)


def hybrid_law(design: Design) -> Cueing:
    """The answer of model 1, found with the explicit law of the same constraints on a coarse grid."""
    return _hinted(design, Kind.LAW)


def hybrid_table(design: Design) -> Cueing:
    """The answer of model 1, found with the best of the working sets that were met near by in training."""
    return _hinted(design, Kind.TABLE)


def implicit_sensed(design: Design) -> Cueing:
    """The implicit MPC of what is sensed."""
    sensed = replace(design.mpc, objective=Objective(senses=Vestibular()))
    return _apart(design.platform, [design.pairs, *_alone(design)], sensed)


def linear_mpc(design: Design) -> Cueing:
    """Linear MPC of what is sensed, each degree of freedom on its own."""
    settings = replace(
        design.mpc,
        objective=Objective(senses=Vestibular()),
        washout=constant(LINEAR_WASHOUT),
        braking=BrakingRows.LEADING,
        linear=True,
    )
    several = len(design.pairs) > 1  # a circle is no linear constraint: each pair gets a side of its square
    platform = design.platform.boxed() if several else design.platform
    return _apart(platform, [*((pair,) for pair in design.pairs), *_alone(design)], settings)


def _guessing(design: Design, guess: Callable[[Design], Guess]) -> Cueing:
    """The implicit MPC, with a guess of the pairs' controls."""
    of_pairs = design if design.dofs == design.pairs else replace(design, dofs=design.pairs)
    first = {"guess": guess(of_pairs), "entry": design.entry}
    return _apart(design.platform, [design.pairs, *_alone(design)], design.mpc, first=first)


def _hinted(design: Design, kind: Kind) -> Cueing:
    """The implicit MPC, with a hint of the pairs' working set.

    A hint that was refused is missing at every decision, which their outcomes say.

    Raises
    ------
    InputError : there is no hint.
    StaleHint : it belongs to another platform, other pairs or settings.
    """
    if design.hint is None:
        raise InputError("--hint", "absent", "a file of 'otolith hint build' for this platform and settings")
    hint: Hint = MissingHint()
    if isinstance(design.hint, StoredHint):
        hint = design.hint.at_work(kind, design.platform, design.pairs, design.mpc)
    return _apart(design.platform, [design.pairs, *_alone(design)], design.mpc, first={"hint": hint})


def _alone(design: Design) -> list[tuple[Dof, ...]]:
    """Heave and yaw, which nothing couples to other axes but what is small of the second order."""
    return [(dof,) for dof in design.dofs if not dof.is_pair]


def _apart(
    platform: Platform,
    groups: Sequence[tuple[Dof, ...]],
    settings: MpcSettings,
    *,
    first: dict[str, Any] | None = None,
) -> Cueing:
    """One MPC per group of degrees of freedom, as one algorithm; `first`: arguments of the pairs' MPC."""
    made = [
        Mpc(platform, dofs, settings, **(first or {} if dofs[0].is_pair else {})) for dofs in groups if dofs
    ]
    return _together(made)


def _together(parts: Sequence[Cueing]) -> Cueing:
    """Algorithms that share no axis, as one."""
    return parts[0] if len(parts) == 1 else Several(parts)
