"""The thesis's cueing models, composed so that their difference is visible (section 3.1)."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, AxisPair
from otolith.mpc.explicit import Explicit, ExplicitLaw, ExplicitSettings, explicit_problem
from otolith.mpc.hybrid import FromExplicit, Guess, HeldPlan, NoGuess
from otolith.mpc.implicit import Entry, Implicit, ImplicitSettings
from otolith.mpqp import Law, Progress, enumerate_regions
from otolith.platforms import Platform


@dataclass(frozen=True, kw_only=True)
class Design:
    """Everything a cueing algorithm is made from, apart from which algorithm it is."""

    platform: Platform
    pair: AxisPair = SURGE_PITCH
    explicit: ExplicitSettings = field(default_factory=ExplicitSettings)
    implicit: ImplicitSettings = field(default_factory=ImplicitSettings)
    entry: Entry = Entry.REFERENCE
    stored_law: Law | None = None  # from a file; enumerated on first use when absent
    progress: Callable[[Progress], None] | None = None  # is told how the enumeration goes

    @cached_property
    def law(self) -> Law:
        """The explicit law of this platform, pair and settings; enumerated once.

        Raises
        ------
        InputError : the stored law belongs to another model.
        """
        problem = explicit_problem(self.platform.pair_limits(self.pair), self.platform.braking, self.explicit)
        if self.stored_law is None:
            return enumerate_regions(problem, progress=self.progress)
        if self.stored_law.problem.digest != problem.digest:
            raise InputError(
                "the stored law's model",
                self.stored_law.problem.digest[:12],
                f"{problem.digest[:12]}, the model of platform {self.platform.name} with the chosen settings",
            )
        return self.stored_law

    def law_at_work(self) -> ExplicitLaw:
        """A fresh evaluator of the law, with its own memory of the last region."""
        return ExplicitLaw(self.law, self.explicit)

    def implicit_with(self, guess: Guess) -> Implicit:
        """The implicit MPC of this design with the given guess."""
        limits = self.platform.pair_limits(self.pair)
        return Implicit(
            self.pair, limits, self.platform.braking, settings=self.implicit, guess=guess, entry=self.entry
        )


def explicit(design: Design) -> Explicit:
    """The explicit law alone."""
    return Explicit(design.pair, design.platform.pair_limits(design.pair), design.law_at_work())


def implicit(design: Design) -> Implicit:
    """Model 1: no guess."""
    return design.implicit_with(NoGuess())


def implicit_trajectory(design: Design) -> Implicit:
    """Model 2: the first control of the previous plan."""
    return design.implicit_with(HeldPlan())


def hybrid_first(design: Design) -> Implicit:
    """Model 3: the explicit law's first input."""
    return design.implicit_with(FromExplicit(design.law_at_work(), first_only=True))


def hybrid_all(design: Design) -> Implicit:
    """Model 4: all inputs of the explicit law."""
    return design.implicit_with(FromExplicit(design.law_at_work(), first_only=False))
