"""The quick subset: numbers that would drift with a law, a braking row, a model or a filter."""

import json

import pytest

from otolith.core.errors import InputError
from otolith_thesis import CHAPTERS, ITEMS, QUICK, Outcome, chosen, reproduce


@pytest.fixture(scope="module")
def quick() -> dict[str, Outcome]:
    fractions: list[float] = []
    found = reproduce(list(QUICK), processes=1, progress=lambda _, fraction: fractions.append(fraction))
    assert fractions == sorted(fractions)
    return {outcome.name: outcome for outcome in found}


def _ours(outcome: Outcome) -> dict[tuple[str, str], float]:
    return {(number.row, number.column): number.ours for number in outcome.numbers}


def test_explicit_numbers_have_not_drifted(quick: dict[str, Outcome]) -> None:
    """Table C.2 and Table 5.8; the numbers themselves are judged in the report."""
    c_2 = _ours(quick["table-c.2"])
    assert c_2["sine-2", "rmse_without"] == pytest.approx(1.5883, abs=5e-4)
    assert c_2["sine-2", "rmse_with"] == pytest.approx(1.1792, abs=5e-4)
    assert c_2["step-1", "rmse_with"] == pytest.approx(0.3081, abs=5e-4)
    assert list(_ours(quick["table-5.8"]).values()) == [21025, 777923]
    assert quick["table-c.2"].counts() == {"agrees": 10, "within 10 %": 3, "same order": 1, "differs": 0}


def test_implicit_numbers_have_not_drifted(quick: dict[str, Outcome]) -> None:
    """Errors to four digits; changes of the working set to 5 %, since a tie may fall otherwise elsewhere.

    Both are the cells of Tables 5.5, 5.7 (implicit) and 5.9, 5.11, 5.12 (hybrid-all) for these signals.
    """
    expected = {
        ("figure-c.7", "longitudinal"): (0.1190, 0.0994, 1.076),  # sine-1
        ("figure-c.6", "longitudinal"): (0.3139, 0.1107, 2.109),  # step-1
        ("figure-5.11", "longitudinal"): (0.0057, 0.0161, 0.622),  # sine-0.5, hybrid-all
        ("figure-5.11", "lateral"): (0.0057, 0.0170, 0.622),
    }
    for (name, direction), (rmse, travel, changes) in expected.items():
        (run,) = (row for row in quick[name].grids[0].rows if row[0] == direction)
        assert run[1:3] == pytest.approx((rmse, travel), abs=1e-4), name
        assert run[3] == pytest.approx(changes, rel=0.05), name
        assert run[6] == 0, name


def test_perception_agrees_digit_for_digit_where_nothing_is_exchanged(quick: dict[str, Outcome]) -> None:
    assert quick["table-b.4"].counts()["agrees"] == 12
    assert quick["study-table-b.2"].claims[0].holds is False


def test_braking_needs_two_not_one(quick: dict[str, Outcome]) -> None:
    printed, ours = quick["study-braking-bound"].claims
    assert not printed.holds
    assert ours.holds
    overshoots = {row[0]: max(row[2:5]) for row in quick["study-braking-bound"].grids[0].rows}  # type: ignore[type-var]
    at = {round(float(ratio), 2): far for ratio, far in overshoots.items()}  # type: ignore[arg-type]
    assert at[2.22] == pytest.approx(0.500, abs=5e-4)
    assert at[2.0] == pytest.approx(0.500, abs=5e-4)
    assert at[1.43] == pytest.approx(0.507, abs=5e-4)
    assert at[1.05] == pytest.approx(0.537, abs=1e-3)
    drift, kept = quick["study-braking-rows"].claims
    assert (drift.holds, kept.holds) == (False, True)


def test_printed_equations_fail_where_the_text_contradicts_them(quick: dict[str, Outcome]) -> None:
    assert [quick[name].claims[0].holds for name in ("study-filters", "study-table-6.1")] == [False, False]
    first, last = quick["study-arithmetic"].grids[0].rows[-2:]
    assert first[3] == pytest.approx(14.14, abs=0.01)
    assert last[3] == pytest.approx(12.46, abs=0.01)


def test_everything_becomes_json(quick: dict[str, Outcome]) -> None:
    for outcome in quick.values():
        values = json.loads(json.dumps(outcome.as_json(), allow_nan=False))
        assert values["agree"] <= values["total"] == len(outcome.numbers)
        assert values["conclusion_holds"] == all(claim["holds"] for claim in values["claims"])


def test_chapters_all_and_single_names_choose_in_the_order_of_the_thesis() -> None:
    assert chosen(["all"]) == list(ITEMS)
    assert chosen(["table-5.9", "table-5.5"]) == ["table-5.5", "table-5.9"]
    assert set(chosen(["quick"])) == set(QUICK)
    assert sum(len(chosen([chapter])) for chapter in CHAPTERS) == len(ITEMS)
    with pytest.raises(InputError, match=r"table-5\.5"):
        chosen(["table-5.55"])


def test_reasons_are_studies_that_exist(quick: dict[str, Outcome]) -> None:
    for outcome in quick.values():
        assert all(name in ITEMS for name in outcome.reasons)
