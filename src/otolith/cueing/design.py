"""The composition root: every algorithm in a few lines from the same parts, so that differences show.

The thesis's four models (section 3.1) differ only in their guess; `hybrid-learned`, `-law` and `-table`
differ in what they know about the working set. `implicit-sensed` is the thesis's third recommendation
(chapter 8): the implicit MPC that tracks the perceived force and rate instead of the physical force.
`linear-mpc` is of the kind of Beghi, Bruschetta & Maran (2012), with Telban's organs in a linear prediction
and limits on position and speed in the driver's frame, split as in Garrett & Best (2013) into independent
problems. Details that these papers leave open are chosen here: horizon, lag and engine are those of the
implicit MPC, so that the models are compared and not the effort. (The papers themselves were not available;
the description is the thesis's, section 2.4.2.)
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, Dof, pairs_of
from otolith.cueing.ahead import Ahead
from otolith.cueing.hints.stored import Kind, Refused, StoredHint
from otolith.cueing.mpc.body import Body
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.explicit import Explicit, ExplicitLaw
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_platform, explicit_problem
from otolith.cueing.mpc.guess import FromExplicit, Guess, HeldPlan, Hint, MissingHint, NoGuess
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.six_axis import Generator, body_of, six_axis_settings
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.several import Several
from otolith.cueing.washout.classical import Classical
from otolith.cueing.washout.tuning import Corners, Tuning, load_tuning
from otolith.interfaces import Cueing
from otolith.mpqp import Law, Progress, enumerate_regions
from otolith.perception import Vestibular
from otolith.platforms import Platform
from otolith.qp.blocked import Lengths

LINEAR_WASHOUT: Final = {"position": 5.0, "velocity": 5.0}  # constant weights, as in Table 5.3


@dataclass(frozen=True, kw_only=True)
class Design:
    """Everything from which a cueing algorithm is made, except which algorithm it is."""

    platform: Platform
    dofs: tuple[Dof, ...] = (SURGE_PITCH,)  # degrees of freedom that are cued
    explicit: ExplicitSettings = field(default_factory=ExplicitSettings)
    mpc: MpcSettings = field(default_factory=MpcSettings)
    entry: Entry = Entry.REFERENCE
    liveliness: float = 0.5  # of `predictive`, 0 to 1: how much travel it uses for cueing
    # Steps of each block of the second MPC of `lnl` and `nll`; empty for those of the first
    second_blocks: Lengths = ()
    generator: Generator = Generator.PLAIN  # of the references of `six-axis-nmpc`
    washout: Tuning | None = None  # of the conventional washouts; None for the one shipped for the platform
    corners: Corners = field(default_factory=Corners)  # factors of the classical washout's corner frequencies
    stored_laws: tuple[Law, ...] = ()  # from a file; if empty, laws are enumerated on first use
    hint: StoredHint | Refused | None = None  # offline knowledge, from a file
    progress: Callable[[Progress], None] | None = None  # is called with the progress of the enumeration

    def __post_init__(self) -> None:
        if not 0.0 <= self.liveliness <= 1.0:
            raise InputError("liveliness", self.liveliness, "between 0 and 1")
        if any(length < 1 for length in self.second_blocks):
            given = ",".join(map(str, self.second_blocks))
            raise InputError("blocks of the second MPC", given, "of at least 1 step each")

    @property
    def preview(self) -> int:
        """Return how many future periods' forces the loop must give to the algorithm."""
        prediction = self.mpc.prediction
        return 0 if prediction is None else math.ceil(prediction.foresees / self.mpc.period)

    @property
    def pairs(self) -> tuple[Dof, ...]:
        """Return the axis pairs among `dofs`."""
        return pairs_of(self.dofs)

    @property
    def tuning(self) -> Tuning:
        """Return the tuning of the conventional washouts; errors are those of `load_tuning`."""
        return self.washout or load_tuning(self.platform.name)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """Return the explicit law of each degree of freedom; it is enumerated once.

        Raises
        ------
        InputError : no stored law belongs to this platform, degree of freedom and settings.
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
        """Return a new evaluator of each law, with its own memory of the last region."""
        return [ExplicitLaw(law, dof, self.explicit) for dof, law in zip(self.dofs, self.laws, strict=True)]


def predictive(design: Design) -> Cueing:
    """Make the implicit MPC with a long horizon, a learning prediction, and as little washout as possible."""
    return together(
        [
            Mpc(
                design.platform,
                dofs,
                predictive_settings(design.mpc, design.platform, dofs, design.liveliness),
            )
            for dofs in groups_of(design)
        ]
    )


def explicit(design: Design) -> Cueing:
    """Make the algorithm that uses the explicit laws alone."""
    return Explicit(explicit_platform(design.platform, design.dofs), design.dofs, design.laws_at_work())


def implicit(design: Design) -> Cueing:
    """Make model 1: no guess."""
    return _guessing(design, lambda _: NoGuess())


def implicit_trajectory(design: Design) -> Cueing:
    """Make model 2: the guess is the first control of the previous plan."""
    return _guessing(design, lambda _: HeldPlan())


def hybrid_first(design: Design) -> Cueing:
    """Make model 3: the guess is the explicit law's first input."""
    return _guessing(design, lambda pairs: FromExplicit(pairs.laws_at_work(), first_only=True))


def hybrid_all(design: Design) -> Cueing:
    """Make model 4: the guess is all inputs of the explicit law."""
    return _guessing(design, lambda pairs: FromExplicit(pairs.laws_at_work(), first_only=False))


def hybrid_learned(design: Design) -> Cueing:
    """Make model 1 with a network's hint of the working set, used if it is better than the previous set."""
    return _hinted(design, Kind.LEARNED)


def hybrid_law(design: Design) -> Cueing:
    """Make model 1 with a hint from the explicit law of the same constraints on a coarse grid."""
    return _hinted(design, Kind.LAW)


def hybrid_table(design: Design) -> Cueing:
    """Make model 1 with a hint from the working sets that occurred nearby in training."""
    return _hinted(design, Kind.TABLE)


def implicit_sensed(design: Design) -> Cueing:
    """Make the implicit MPC that tracks what is perceived."""
    sensed = replace(design.mpc, objective=Objective(senses=Vestibular()))
    return _apart(design.platform, [design.pairs, *_alone(design)], sensed)


def linear_mpc(design: Design) -> Cueing:
    """Make the linear MPC that tracks what is perceived, one independent problem per degree of freedom."""
    settings = replace(
        design.mpc,
        objective=Objective(senses=Vestibular()),
        washout=constant(LINEAR_WASHOUT),
        braking=BrakingRows.LEADING,
        linear=True,
    )
    # A circle is not linear, so each pair gets a side of the inscribed square
    several = len(design.pairs) > 1
    platform = design.platform.boxed() if several else design.platform
    return _apart(platform, [*((pair,) for pair in design.pairs), *_alone(design)], settings)


def six_axis(design: Design) -> Cueing:
    """Make one MPC over all axes, with the limits of the legs as rows; errors are those of `body_of`."""
    body = _body(design, design.dofs)
    return Mpc(design.platform, design.dofs, six_axis_settings(design.mpc), body=body)


def _body(design: Design, dofs: tuple[Dof, ...], generator: Generator = Generator.PLAIN) -> Body:
    """Return the platform as one body; errors are those of `body_of`."""
    period, lag = design.mpc.period, design.mpc.lag_on(design.platform)
    return body_of(design.platform, dofs, design.liveliness, period=period, lag=lag, generator=generator)


def six_axis_nmpc(design: Design) -> Cueing:
    """Make the same with its nonlinear problem solved to the end, as a reference; far from real time."""
    from otolith.cueing.mpc.nonlinear import IpoptEngine

    body = replace(_body(design, design.dofs, design.generator), settled=math.inf)
    settings = replace(six_axis_settings(design.mpc, design.generator), engine=IpoptEngine)
    mpc = Mpc(design.platform, design.dofs, settings, body=body)
    if isinstance(mpc.engine, IpoptEngine):
        mpc.engine.attach(mpc.problem, body, mpc.program.wanted)
    return mpc


def reweigh(cueing: Cueing, name: str, design: Design) -> None:
    """Give an algorithm at work the washout weights, or the corner frequencies, of a changed design.

    They count from its next decision on.

    Parameters
    ----------
    name : of the algorithm in the registry.

    Raises
    ------
    InputError : the weights are on other states than those before.
    """
    for mpc in mpcs_of(cueing):
        settings = design.mpc
        if name.startswith("six-axis"):
            generator = design.generator if name == "six-axis-nmpc" else Generator.PLAIN
            mpc.reweigh(_body(design, mpc.problem.dofs, generator).washout)
            continue
        if name == "predictive":
            settings = predictive_settings(settings, design.platform, mpc.problem.dofs, design.liveliness)
        mpc.reweigh(settings.washout)
    if isinstance(cueing, Classical):
        cueing.retune(design)


def mpcs_of(cueing: Cueing) -> list[Mpc]:
    """Return the MPCs of which an algorithm is made."""
    if isinstance(cueing, Ahead):
        return mpcs_of(cueing.inner)
    parts = cueing.parts if isinstance(cueing, Several) else (cueing,)
    return [part for part in parts if isinstance(part, Mpc)]


def _guessing(design: Design, guess: Callable[[Design], Guess]) -> Cueing:
    """Make the implicit MPC with a guess of the pairs' controls."""
    of_pairs = design if design.dofs == design.pairs else replace(design, dofs=design.pairs)
    first = {"guess": guess(of_pairs), "entry": design.entry}
    return _apart(design.platform, [design.pairs, *_alone(design)], design.mpc, first=first)


def _hinted(design: Design, kind: Kind) -> Cueing:
    """Make the implicit MPC with a hint of the pairs' working set.

    If the hint was refused, outcomes report at every decision that it is missing.

    Raises
    ------
    InputError : there is no hint.
    StaleHint : the hint belongs to another platform, other pairs or other settings.
    """
    if design.hint is None:
        raise InputError("--hint", "absent", "a file of 'otolith hint build' for this platform and settings")
    hint: Hint = MissingHint()
    if isinstance(design.hint, StoredHint):
        hint = design.hint.at_work(kind, design.platform, design.pairs, design.mpc)
    return _apart(design.platform, [design.pairs, *_alone(design)], design.mpc, first={"hint": hint})


def _alone(design: Design) -> list[tuple[Dof, ...]]:
    """Return heave and yaw, which are coupled to other axes only in second order."""
    return [(dof,) for dof in design.dofs if not dof.is_pair]


def _apart(
    platform: Platform,
    groups: Sequence[tuple[Dof, ...]],
    settings: MpcSettings,
    *,
    first: dict[str, Any] | None = None,
) -> Cueing:
    """Make one MPC per group of degrees of freedom, combined into one algorithm.

    Parameters
    ----------
    first : arguments for the MPC of the pairs.
    """
    made = [
        Mpc(platform, dofs, settings, **(first or {} if dofs[0].is_pair else {})) for dofs in groups if dofs
    ]
    return together(made)


def groups_of(design: Design) -> list[tuple[Dof, ...]]:
    """Return the degrees of freedom that one MPC cues, for each MPC."""
    return [group for group in (design.pairs, *_alone(design)) if group]


def together(parts: Sequence[Cueing]) -> Cueing:
    """Combine algorithms that share no axis into one."""
    return parts[0] if len(parts) == 1 else Several(parts)
