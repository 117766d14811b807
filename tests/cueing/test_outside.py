"""Algorithms of others: how they are made, and that their mistakes are told, not passed on."""

from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.plugins import BrokenPlugin
from otolith.cueing.design import Design
from otolith.cueing.outside import make_outside
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.platforms import load

DESIGN = Design(platform=load("thesis"))
STILL = Command(
    acceleration=np.zeros(6),
    pose=np.zeros(6),
    twist=np.zeros(6),
    plan=np.zeros((1, 6)),
    outcome=Outcome(status=Status.DECIDED),
)


class Stays:
    """Commands what it is told to, or raises it."""

    period: Any = 0.01

    def __init__(self, answer: Any = STILL) -> None:
        self.answer = answer

    def reset(self, state: PlatformState) -> None:
        """Nothing to forget."""

    def step(self, state: PlatformState, reference: Reference) -> Any:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def step(answer: Any, reference: Reference | None = None) -> Command:
    made = make_outside(lambda: Stays(answer), DESIGN, name="mine:It")
    made.reset(PlatformState())
    return made.step(PlatformState(), reference or Reference(specific_force=np.zeros(3)))


def test_a_maker_gets_the_design_if_it_asks_for_it() -> None:
    seen: list[Any] = []

    def asks(design: Design, gain: float = 2.0) -> Stays:
        seen.append(design)
        return Stays()

    make_outside(asks, DESIGN, name="mine:asks")
    make_outside(Stays, DESIGN, name="mine:Stays")
    assert seen == [DESIGN]


def test_its_command_passes_as_it_is() -> None:
    assert step(STILL) is STILL


def test_what_is_no_number_never_reaches_it() -> None:
    bad = Reference(specific_force=np.array([np.nan, 0.0, 0.0]))
    command = step(ValueError("never asked"), bad)
    assert command.outcome.status is Status.INVALID
    assert not command.acceleration.any()


@pytest.mark.parametrize(("answer", "kind"), [(None, "NoneType"), ("text", "str"), (np.zeros(6), "ndarray")])
def test_what_is_no_command_is_refused(answer: Any, kind: str) -> None:
    with pytest.raises(InputError, match=f"returned is {kind}, must be an otolith.Command"):
        step(answer)


@pytest.mark.parametrize("part", ["acceleration", "pose", "twist"])
@pytest.mark.parametrize("value", [np.zeros(3), np.full(6, np.nan), [0.0] * 6, None])
def test_a_vector_that_is_none_is_refused(part: str, value: Any) -> None:
    fields = {name: getattr(STILL, name) for name in ("acceleration", "pose", "twist", "plan", "outcome")}
    with pytest.raises(InputError, match=f"^{part} of a command of --cueing mine:It"):
        step(Command(**{**fields, part: value}))


def test_what_it_raises_is_one_sentence_with_the_line() -> None:
    with pytest.raises(BrokenPlugin, match=r"^--cueing mine:It failed in step: KeyError: 'x' \(line \d+ of"):
        step(KeyError("x"))


def test_a_constructor_that_raises_or_makes_something_else_is_told() -> None:
    def raises() -> None:
        raise RuntimeError("two\nlines")

    with pytest.raises(BrokenPlugin, match="could not be made: RuntimeError: two lines"):
        make_outside(raises, DESIGN, name="mine:It")
    with pytest.raises(InputError, match="without period and reset and step"):
        make_outside(object, DESIGN, name="mine:It")
    with pytest.raises(InputError, match="takes an argument 'design', or none"):
        make_outside(lambda x: Stays(), DESIGN, name="mine:It")


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan, np.inf, "10 ms", None])
def test_a_period_that_is_none_is_refused(period: Any) -> None:
    made = Stays()
    made.period = period
    with pytest.raises(InputError, match=r"^period of --cueing mine:It"):
        make_outside(lambda: made, DESIGN, name="mine:It")
