"""The thesis's statements about its tables of models, tested on its numbers and on ours."""

from collections.abc import Callable
from typing import Final

import numpy as np

from otolith_thesis.loop import MODELS
from otolith_thesis.outcome import Claim

Values = dict[str, dict[str, float]]  # by scenario, then by model
HYBRIDS: Final = MODELS[1:]
Asked = tuple[str, bool, str]  # a statement, whether it holds, and the deciding figures
Claims = Callable[[Values], list[Asked]]


def both(in_print: Values, ours: Values, claims: Claims) -> tuple[Claim, ...]:
    """Test each statement on our numbers, and add the figures for the printed numbers."""
    return tuple(
        Claim(text=text, holds=holds, figures=f"ours: {figures}; in print: {printed}")
        for (text, holds, figures), (_, _, printed) in zip(claims(ours), claims(in_print), strict=True)
    )


def _means(values: Values) -> dict[str, float]:
    """Return the mean over the signals by model, the smallest first."""
    mean = {model: float(np.mean([row[model] for row in values.values()])) for model in MODELS}
    return dict(sorted(mean.items(), key=lambda item: item[1]))


def _listed(means: dict[str, float]) -> str:
    return ", ".join(f"{model} {mean:.2f}" for model, mean in means.items())


def _hybrids_first(values: Values) -> Asked:
    means = _means(values)
    return (
        "Over all signals the two hybrids need fewer than both implicit models",
        set(list(means)[:2]) == {"hybrid-first", "hybrid-all"},
        _listed(means),
    )


def fewest(values: Values) -> list[Asked]:
    """Test the statements on Tables 5.5 and 5.9 (sections 5.2.4, 5.3.2)."""
    n = len(values)
    least = sum(min(row, key=row.__getitem__) == "hybrid-all" for row in values.values())
    most = sum(max(row, key=row.__getitem__) == "implicit" for row in values.values())
    return [
        (
            "The hybrid with all inputs needs the fewest iterations on every signal",
            least == n,
            f"on {least} of {n}",
        ),
        ("The implicit MPC without a guess needs the most on every signal", most == n, f"on {most} of {n}"),
        _hybrids_first(values),
    ]


def least_mean(values: Values) -> list[Asked]:
    """Test the statements on Table C.4 (section C.4.1)."""
    means = _means(values)
    first = next(iter(means))
    return [
        (
            "Over all signals the hybrid with the first input needs the fewest iterations",
            first == "hybrid-first",
            _listed(means),
        ),
        _hybrids_first(values),
    ]


def savings(values: Values) -> list[Asked]:
    """Test the statements on Table C.5 (section C.4.1)."""
    mean = {model: float(np.mean([row[model] for row in values.values()])) for model in HYBRIDS}
    figures = ", ".join(f"{model} {value:.1f} %" for model, value in mean.items())
    return [
        ("On average every guess saves iterations", min(mean.values()) > 0.0, figures),
        (
            "On average the hybrid with all inputs saves the most",
            mean["hybrid-all"] == max(*mean.values(), 0.0),
            figures,
        ),
    ]


def savings_and_trend(values: Values) -> list[Asked]:
    """Test the statements on Tables 5.6 and 5.10 (sections 5.2.4, 5.3.2)."""
    return [*savings(values), _trend(values, "sine-0.5", "sine-1")]


def _trend(values: Values, small: str, large: str) -> Asked:
    saved = {scenario: values[scenario]["hybrid-all"] for scenario in (small, large)}
    return (
        "The hybrid with all inputs saves less on the larger of the two slow sines",
        saved[large] < saved[small],
        ", ".join(f"{scenario} {value:.1f} %" for scenario, value in saved.items()),
    )


def tracking(values: Values) -> list[Asked]:
    """Test the statements on Tables 5.7, 5.11, 5.12 and C.6."""
    best = {min(row, key=row.__getitem__) for row in values.values()}
    worst = max(
        (abs(row[m] / row["implicit"] - 1.0), scenario, m) for scenario, row in values.items() for m in MODELS
    )
    far = [
        abs(row[m] - row["implicit"]) for scenario, row in values.items() for m in MODELS if m != "implicit"
    ]
    grows = values["sine-0.5"]["implicit"] < values["sine-1"]["implicit"]
    grows &= values["step-1"]["implicit"] < values["step-2"]["implicit"]
    return [
        (
            "No model tracks better than the others on all signals",
            len(best) > 1,
            f"{len(best)} models are best on one or more signals",
        ),
        (
            "The guess changes the tracking hardly (at most 0.02 m/s²)",
            max(far) <= 0.02,
            f"at most {max(far):.4f} m/s²; relatively {100 * worst[0]:.0f} % on {worst[1]} by {worst[2]}",
        ),
        (
            "The error grows with the amplitude",
            grows,
            f"sines {values['sine-0.5']['implicit']:.4f}, {values['sine-1']['implicit']:.4f}; "
            f"steps {values['step-1']['implicit']:.4f}, {values['step-2']['implicit']:.4f} m/s²",
        ),
    ]
