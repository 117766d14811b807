"""The thesis's cueing models, composed so that their difference is visible (section 3.1)."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, AxisPair
from otolith.mpc.explicit import Explicit, ExplicitLaw, ExplicitSettings, explicit_problem
from otolith.mpc.hint.stored import Kind, Refused, StoredHint
from otolith.mpc.hybrid import FromExplicit, Guess, HeldPlan, Hint, MissingHint, NoGuess
from otolith.mpc.implicit import Entry, Implicit, ImplicitSettings
from otolith.mpqp import Law, Progress, enumerate_regions
from otolith.platforms import PairLimits, Platform
from otolith.platforms.tuning import Tuning, load_tuning


def explicit_limits(platform: Platform, pairs: Sequence[AxisPair]) -> tuple[PairLimits, ...]:
    """Limits of the pairs' explicit laws; beside another pair, the reach is a square inside the circle.

    A circle is no linear constraint, so the thesis, too, takes a box inside it (0.35 m, eq. 4.17).
    """
    limits = tuple(platform.pair_limits(pair) for pair in pairs)
    if platform.circle is None or len(pairs) < 2:
        return limits
    side = platform.circle / math.sqrt(2.0)
    return tuple(
        replace(one, position=(max(one.position[0], -side), min(one.position[1], side))) for one in limits
    )


@dataclass(frozen=True, kw_only=True)
class Design:
    """Everything a cueing algorithm is made from, apart from which algorithm it is."""

    platform: Platform
    pairs: tuple[AxisPair, ...] = (SURGE_PITCH,)
    explicit: ExplicitSettings = field(default_factory=ExplicitSettings)
    implicit: ImplicitSettings = field(default_factory=ImplicitSettings)
    entry: Entry = Entry.REFERENCE
    singles: tuple[str, ...] = ()  # axes cued on their own, "heave" and "yaw", by what can
    washout: Tuning | None = None  # of the conventional washouts; none: the one shipped for the platform
    stored_laws: tuple[Law, ...] = ()  # from a file; enumerated on first use when there is none
    hint: StoredHint | Refused | None = None  # offline knowledge, from a file
    progress: Callable[[Progress], None] | None = None  # is told how the enumeration goes

    @property
    def dofs(self) -> tuple[str, ...]:
        """Names of all that is cued: the axis pairs, then the axes on their own."""
        return tuple(pair.name for pair in self.pairs) + self.singles

    @property
    def tuning(self) -> Tuning:
        """Tuning of the conventional washouts; errors as `otolith.platforms.tuning.load_tuning`."""
        return self.washout or load_tuning(self.platform.name)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The explicit law of each pair; enumerated once.

        Raises
        ------
        InputError : none of the stored laws belongs to this platform, pair and settings.
        """
        problems = [
            explicit_problem(limits, self.platform.braking, self.explicit)
            for limits in explicit_limits(self.platform, self.pairs)
        ]
        if not self.stored_laws:
            return tuple(enumerate_regions(problem, progress=self.progress) for problem in problems)
        stored = {law.problem.digest: law for law in self.stored_laws}
        for pair, problem in zip(self.pairs, problems, strict=True):
            if problem.digest not in stored:
                raise InputError(
                    "the stored law's model",
                    ", ".join(digest[:12] for digest in stored),
                    f"{problem.digest[:12]}, {pair.name} of platform {self.platform.name} as chosen",
                )
        return tuple(stored[problem.digest] for problem in problems)

    def laws_at_work(self) -> list[ExplicitLaw]:
        """A fresh evaluator of each law, with its own memory of the last region."""
        return [ExplicitLaw(law, self.explicit) for law in self.laws]

    def implicit_with(self, guess: Guess) -> Implicit:
        """The implicit MPC of this design with the given guess."""
        return Implicit(self.platform, self.pairs, settings=self.implicit, guess=guess, entry=self.entry)

    def hinted(self, kind: Kind) -> Implicit:
        """The implicit MPC of this design with a hint of the working set.

        A hint that was refused is missing at every decision, which their outcomes say.

        Raises
        ------
        InputError : there is no hint.
        StaleHint : it belongs to another platform, other pairs or settings.
        """
        if self.hint is None:
            raise InputError(
                "--hint", "absent", "a file of 'otolith hint build' for this platform and settings"
            )
        hint: Hint = MissingHint()
        if isinstance(self.hint, StoredHint):
            hint = self.hint.at_work(kind, self.platform, self.pairs, self.implicit)
        return Implicit(self.platform, self.pairs, settings=self.implicit, guess=NoGuess(), hint=hint)


def explicit(design: Design) -> Explicit:
    """The explicit laws alone."""
    limits = explicit_limits(design.platform, design.pairs)
    return Explicit(design.platform, design.pairs, limits, design.laws_at_work())


def implicit(design: Design) -> Implicit:
    """Model 1: no guess."""
    return design.implicit_with(NoGuess())


def implicit_trajectory(design: Design) -> Implicit:
    """Model 2: the first control of the previous plan."""
    return design.implicit_with(HeldPlan())


def hybrid_first(design: Design) -> Implicit:
    """Model 3: the explicit law's first input."""
    return design.implicit_with(FromExplicit(design.laws_at_work(), first_only=True))


def hybrid_all(design: Design) -> Implicit:
    """Model 4: all inputs of the explicit law."""
    return design.implicit_with(FromExplicit(design.laws_at_work(), first_only=False))


def hybrid_learned(design: Design) -> Implicit:
    """The answer of model 1, found with a network's hint where that is better than the previous set."""
    return design.hinted(Kind.LEARNED)


def hybrid_law(design: Design) -> Implicit:
    """The same with the explicit law of the same constraints on a coarse grid."""
    return design.hinted(Kind.LAW)


def hybrid_table(design: Design) -> Implicit:
    """The same with the best of the working sets that were met near by in training."""
    return design.hinted(Kind.TABLE)
