"""The rule that judges a number."""

import math

import pytest

from otolith_thesis.verdict import Number, Verdict, judged


def row(*pairs: tuple[float, float], digits: int = 4) -> list[Verdict]:
    """Verdicts of one row of (published, ours)."""
    numbers = [
        Number(row="row", column=str(k), published=published, ours=ours, digits=digits)
        for k, (published, ours) in enumerate(pairs)
    ]
    return [number.verdict for number in judged(numbers)]


@pytest.mark.parametrize(
    ("published", "ours", "verdict"),
    [
        (1.0, 1.0199, Verdict.AGREES),
        (1.0, 1.021, Verdict.CLOSE),
        (1.0, 0.901, Verdict.CLOSE),
        (1.0, 0.89, Verdict.ORDER),
        (1.0, 2.0, Verdict.ORDER),
        (1.0, 2.01, Verdict.DIFFERS),
        (1.0, -1.1, Verdict.DIFFERS),
        (0.0, 0.00004, Verdict.AGREES),
        (0.0, 0.1, Verdict.DIFFERS),
        (1.0, math.nan, Verdict.DIFFERS),
    ],
)
def test_the_bounds_of_the_rule(published: float, ours: float, verdict: Verdict) -> None:
    assert row((published, ours)) == [verdict]


def test_half_of_the_last_printed_digit_is_agreement() -> None:
    assert row((0.003, 0.00304)) == [Verdict.AGREES]
    assert row((2.0, 2.4), digits=0) == [Verdict.AGREES]


def test_same_order_asks_for_the_place_in_the_row() -> None:
    assert row((1.0, 1.5), (2.0, 3.0)) == [Verdict.ORDER, Verdict.ORDER]
    assert row((1.0, 1.5), (2.0, 1.3)) == [Verdict.DIFFERS, Verdict.DIFFERS]
    assert row((1.0, 1.5), (1.01, 1.2)) == [Verdict.ORDER, Verdict.ORDER]  # tied in print


def test_a_stopped_computation_is_a_lower_bound() -> None:
    bound = Number(row="r", column="c", published=90000.0, ours=777923.0, at_least=True)
    assert judged([bound])[0].verdict is Verdict.AGREES
    short = Number(row="r", column="c", published=90000.0, ours=80000.0, at_least=True)
    assert judged([short])[0].verdict is Verdict.DIFFERS
