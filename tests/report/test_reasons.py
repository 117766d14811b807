"""Why one is best, in words that the numbers bear out."""

from typing import Any

from otolith.report.ranking import criterion_named, standings
from otolith.report.reasons import why
from otolith.report.tables import headline

RMSE = criterion_named("rmse")


def summary(rmse: float, *, use: float = 0.5, misled: float = 0.0, broken: int = 0) -> dict[str, Any]:
    cues = {kind: {"duration_s": misled / 3.0} for kind in ("inverted", "unwanted", "missing")}
    position = {
        "name": "surge position", "soft": False, "comfort": False, "unit": "m", "low": -0.5, "high": 0.5,
        "nodes_beyond": broken, "excess": 0.18 if broken else 0.0, "excess_between_nodes": 0.0,
    }  # fmt: skip
    return {
        "rmse": rmse,
        "violations": broken,
        "status": {"optimal": 100},
        "limits": {"surge-pitch position": position},
        "workspace": {"surge": {"largest": use}},
        "false_cues": {"surge-pitch": cues},
    }


def reasons_of(**scenarios: dict[str, Any]) -> list[str]:
    return why(scenarios, standings(scenarios, RMSE), RMSE)


def test_the_lead_and_its_price_are_told() -> None:
    (text,) = reasons_of(x={"a": summary(0.1, use=0.4), "b": summary(0.15, use=0.3, misled=1.2)})
    assert text == (
        "x: a is best, tracking error (RMSE) 0.1 m/s²; b has 50 % more. "
        "a used 40 % of the reach and misled for 0.0 s, b used 30 % of the reach and misled for 1.2 s."
    )


def test_of_yaw_alone_nothing_is_said_of_false_cues_which_are_of_forces() -> None:
    a, b = ({**summary(0.1), "rate_rmse": {"yaw": error}, "false_cues": {}} for error in (0.1, 0.2))
    rate, scenarios = criterion_named("rate", ["yaw"]), {"x": {"a": a, "b": b}}
    (text,) = why(scenarios, standings(scenarios, rate), rate)
    assert text.endswith("b has 100 % more. Both used 50 % of the reach.")
    assert "Misled" not in headline(["a", "b"], [a, b])


def test_ties_are_said() -> None:
    (text,) = reasons_of(x={"a": summary(0.1), "b": summary(0.1), "c": summary(0.2)})
    first = "x: a and b tie for the first place, tracking error (RMSE) 0.1 m/s²; c has 100 % more"
    assert text.startswith(first)
    over_all, *_ = reasons_of(
        x={"a": summary(0.1), "b": summary(0.2)}, y={"a": summary(0.3), "b": summary(0.2)}
    )
    assert over_all.startswith("Over all, a and b tie with a mean rank of 1.50; a stands first")


def test_a_tie_over_all_is_decided_by_limits_before_the_measure() -> None:
    bold = {"x": summary(0.05, broken=1), "y": summary(0.1)}
    calm = {"x": summary(0.2), "y": summary(0.3)}
    over_all, *_ = reasons_of(**{name: {"bold": bold[name], "calm": calm[name]} for name in "xy"})
    assert over_all == (
        "Over all, calm and bold tie with a mean rank of 1.50; calm stands first, for it alone kept every "
        "hard limit."
    )
    third = {"x": summary(0.21), "y": summary(0.05)}
    over_all, *_ = reasons_of(**{n: {"bold": bold[n], "calm": calm[n], "third": third[n]} for n in "xy"})
    assert "third is best" in over_all


def test_a_small_lead_is_called_small() -> None:
    (text,) = reasons_of(x={"a": summary(0.1), "b": summary(0.1005)})
    assert "b has only 0.5 % more" in text


def test_who_would_be_better_but_broke_a_limit_is_named_with_the_limit() -> None:
    (text,) = reasons_of(x={"bold": summary(0.05, use=1.4, broken=7), "calm": summary(0.1)})
    assert text.startswith("x: calm is best")
    assert "bold comes next" in text
    assert (
        "bold has a smaller one, 0.05, and is ruled out: hard limit broken: surge position by up to 0.18 m "
        "beyond ±0.5 m, at 7 of 100 nodes."
    ) in text


def test_that_all_broke_a_limit_is_said() -> None:
    (text,) = reasons_of(x={"a": summary(0.1, broken=1), "b": summary(0.2, broken=2)})
    assert text.endswith("All of them passed a hard limit.")


def test_the_best_over_all_is_named_with_its_wins() -> None:
    over_all, *each = reasons_of(
        x={"a": summary(0.1), "b": summary(0.2)}, y={"a": summary(0.1), "b": summary(0.2)}
    )
    assert over_all == "Over all, a is best, with a mean rank of 1.00 and 2 wins."
    assert len(each) == 2
