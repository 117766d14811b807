"""The study of redundant simulators: its claims from made-up runs, and one run of its own."""

from typing import Any

from otolith_thesis.studies import redundant
from otolith_thesis.studies.redundant import JOINT, LINEAR, LNL, LNL_SHORT, NLL, NLL_SHORT, SIGNALS, VARIANTS


def answers(**rmse: float) -> dict[Any, Any]:
    values = {variant: rmse.get(variant, 1.0) for variant in VARIANTS}
    return {
        redundant.Carried(variant, signal): {
            "rmse": value,
            "changes": 2.0 if variant == NLL else 1.0,
            "variables": 27,
            "microseconds": 10.0,
            "broken": 0,
        }
        for variant, value in values.items()
        for signal in SIGNALS
    }


def test_its_claims_are_those_of_the_numbers() -> None:
    as_told = {JOINT: 0.1, LINEAR: 0.9, LNL: 0.5, LNL_SHORT: 0.4, NLL: 0.6, NLL_SHORT: 0.5}
    assert [claim.holds for claim in redundant.study(answers(**as_told)).claims] == [True] * 4
    against = {JOINT: 0.7, LINEAR: 0.6, LNL: 0.5, LNL_SHORT: 0.5, NLL: 0.6, NLL_SHORT: 0.5}
    found = redundant.study(answers(**against))
    assert [claim.holds for claim in found.claims] == [False, True, False, False]
    assert found.claims[0].figures == "LNL on 0 of 6 signals, NLL on 6 of 6 signals"
    assert len(found.grids[0].rows) == len(VARIANTS)


def test_a_run_keeps_all_limits_and_tells_its_effort() -> None:
    found = redundant.Carried(JOINT, "step-1").run()
    assert found["rmse"] < 0.05
    assert (found["broken"], found["variables"]) == (0, 27)
