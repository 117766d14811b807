"""Every key figure of a run, one entry each, in the order of a summary.

Summaries, the table of a comparison, `otolith compare --by`, gauges, pages and the table of docs/metrics.md
are made from these entries or tested against them, so a new key figure is one more entry here.
"""

import math
from functools import partial
from typing import Final

from otolith.metrics import effort, scales, similarity, unwanted, values
from otolith.metrics.against_best import best_in_words, times_or_words
from otolith.metrics.axes import by_axis, by_force, by_rate
from otolith.metrics.false_cues import misleading_time
from otolith.metrics.measure import FORCES, RATES, Better, Column, Measure, Topic, root_sum_square
from otolith.metrics.perceived import perceived_rate_rmse, perceived_rmse
from otolith.metrics.tracking import rate_rmse, tracking_rmse, travel_rms

_SPREAD: Final = {
    "mean": ("mean", ""),
    "median": ("median", ""),
    "p99": ("99th percentile", ""),
    "max": ("max", ""),
}

_FELT: Final = (
    Measure(
        name="rmse",
        words="Tracking error of specific force (RMSE)",
        unit="m/s²",
        of=values.rmse,
        better=Better.LOWER,
        needs=FORCES,
        columns=(
            Column(
                "Error",
                words="Tracking error (RMSE)",
                by="rmse",
                says="How far the felt force was from the wanted one, in the mean of squares",
            ),
        ),
        line=lambda value: f"RMSE {value:.4f} m/s²",
        scale=scales.TRACKING_ERROR,
        section="Tracking error",
    ),
    Measure(
        name="rmse_per_pair",
        words="Tracking error per axis pair (RMSE)",
        unit="m/s²",
        of=lambda run: by_force(run, tracking_rmse(run)),
        better=Better.LOWER,
        needs=FORCES,
        section="Tracking error",
    ),
    Measure(
        name="wanted_rms",
        words="Size of what was wanted (RMS)",
        unit="m/s², rad/s",
        of=values.wanted_rms,
        section="Tracking error",
    ),
    Measure(
        name="optimum",
        words="Against the best that is possible",
        unit="",
        of=None,
        better=Better.LOWER,
        columns=(Column("Times the best", times_or_words),),
        scale=scales.TIMES_THE_BEST,
        in_words=best_in_words,
        section="The best that is possible",
    ),
    Measure(
        name="rate_rmse",
        words="Tracking error of angular rate (RMSE)",
        unit="rad/s",
        of=lambda run: by_rate(run, rate_rmse(run)),
        better=Better.LOWER,
        needs=RATES,
        optional=True,
        columns=(
            Column(
                "Yaw rate error",
                root_sum_square,
                words="Yaw rate error (RMSE)",
                by="rate",
                says="How far the felt yaw rate was from the wanted one, in the mean of squares",
            ),
        ),
        line=lambda errors: ", ".join(
            f"{axis} rate RMSE {math.degrees(error):.3f} deg/s" for axis, error in errors.items()
        ),
        section="Tracking error",
    ),
    Measure(
        name="perceived_rate_rmse",
        words="Tracking error after the semicircular canals (RMSE)",
        unit="rad/s",
        of=lambda run: by_rate(run, perceived_rate_rmse(run)),
        better=Better.LOWER,
        needs=RATES,
        optional=True,
        section="Tracking error",
    ),
    Measure(
        name="travel_rms",
        words="Travel used (RMS)",
        unit="m, rad",
        of=lambda run: by_axis(run, travel_rms(run)),
        topic=Topic.PLATFORM,
        section="Use of the reach",
    ),
    Measure(
        name="correlation",
        words="Correlation of felt and wanted",
        unit="",
        of=lambda run: values.of_signals(run, similarity.correlation_in_parts),
        better=Better.HIGHER,
        scale=scales.SAME_SHAPE,
        section="Correlation",
    ),
    Measure(
        name="delay_s",
        words="Delay",
        unit="s",
        of=lambda run: values.of_signals(
            run, lambda pairs: similarity.delay_in_parts(pairs, run.plant_period)
        ),
        section="What to trust how far",
    ),
    Measure(
        name="scale_ratio",
        words="Mean size, felt over wanted",
        unit="",
        of=lambda run: values.of_signals(run, similarity.scale_in_parts),
        section="What to trust how far",
    ),
    Measure(
        name="mean_absolute_difference",
        words="Mean absolute difference",
        unit="m/s²",
        of=lambda run: values.of_forces(run, similarity.difference_in_parts),
        better=Better.LOWER,
        needs=FORCES,
        section="What to trust how far",
    ),
    Measure(
        name="perceived_rmse",
        words="Tracking error after the otoliths (RMSE)",
        unit="m/s²",
        of=lambda run: by_force(run, perceived_rmse(run)),
        better=Better.LOWER,
        needs=FORCES,
        columns=(
            Column(
                "",  # the table is wide enough: it stands among all figures
                root_sum_square,
                words="Perceived error (RMSE)",
                by="perceived",
                says="The error after the inner ear: the difference that can be sensed",
            ),
        ),
        section="Tracking error",
    ),
    Measure(
        name="false_cues",
        words="False cues by kind",
        unit="",
        of=values.false_cues_by_kind,
        better=Better.LOWER,
        needs=FORCES,
        columns=(
            Column(
                "Misled",
                misleading_time,
                words="Time with misleading cues",
                unit="s",
                by="false-cues",
                says="How long cues were inverted, unwanted or missing",
            ),
        ),
        scale=scales.MISLED,
        parts={
            "duration_s": ("duration", "s"),
            "peak": ("peak", "m/s²"),
            "integral": ("integral", "m/s"),
        },
        section="False cues",
    ),
    Measure(
        name="unwanted_cues",
        words="Unwanted cues: lag and rebound",
        unit="",
        of=unwanted.unwanted_totals,
        better=Better.LOWER,
        needs=FORCES,
        columns=(
            Column(
                "Lag", partial(unwanted.seconds, "lag"), words="Time with lagging cues", unit="s", by="lag"
            ),
            Column(
                "Rebound",
                partial(unwanted.seconds, "rebound"),
                words="Time with cues that rebound",
                unit="s",
                by="rebound",
            ),
        ),
        parts={"duration_s": ("duration", "s"), "peak": ("peak", "m/s²"), "mean": ("mean", "m/s²")},
        section="Lag and rebound",
    ),
    Measure(
        name="turns_against",
        words="Felt force turns against what is wanted",
        unit="",
        of=unwanted.turns_against,
        better=Better.LOWER,
        needs=FORCES,
        section="Lag and rebound",
    ),
    Measure(
        name="mismatch_rating",
        words="Predicted mismatch rating",
        unit="m/s²",
        of=values.mean_and_largest_rating,
        better=Better.LOWER,
        needs=FORCES,
        parts=_SPREAD,
        section="What to trust how far",
    ),
    Measure(
        name="sickness_dose",
        words="Motion sickness dose",
        unit="m/s^1.5",
        of=values.sickness_doses,
        better=Better.LOWER,
        needs=FORCES,
        section="What to trust how far",
    ),
)

_DONE: Final = (
    Measure(
        name="workspace",
        words="Share of the reach used",
        unit="",
        of=values.workspace,
        topic=Topic.PLATFORM,
        columns=(
            Column(
                "Reach used",
                values.largest_use_percent,
                words="Largest use of the reach",
                unit="%",
                says="The share of the reach that was used at most; beyond 100 % the limit was passed",
            ),
        ),
        scale=scales.REACH_USED,
        parts={"largest": ("largest", ""), "rms": ("RMS", ""), "near_limit": ("time beyond 90 %", "")},
        section="Use of the reach",
    ),
    Measure(
        name="neutral_crossings",
        words="Crossings of the platform's neutral position",
        unit="",
        of=unwanted.neutral_crossings,
        topic=Topic.PLATFORM,
        section="Lag and rebound",
    ),
    Measure(
        name="changes",
        words="Working-set changes per step",
        unit="",
        of=lambda run: effort.distribution(run.changes),
        better=Better.LOWER,
        topic=Topic.SOLVER,
        columns=(
            Column("Mean changes", lambda value: value.get("mean"), against=True),
            Column("Changes, p99", lambda value: value.get("p99")),
            Column("Changes, max", lambda value: value.get("max")),
        ),
        line=lambda value: (
            f"changes {value['mean']:.2f} mean / {value['p99']:.0f} p99 / {value['max']:.0f} max"
        ),
        parts=_SPREAD,
        section="Time and changes",
    ),
    Measure(
        name="step_time_us",
        words="Time per step (thread CPU time)",
        unit="µs",
        of=lambda run: effort.distribution(run.step_time, 1e6),
        better=Better.LOWER,
        topic=Topic.DECISION,
        columns=(Column("Median step", lambda value: value.get("median")),),
        line=lambda value: f"step {value['median']:.0f} us median",
        scale=scales.SLOWEST_DECISION,
        parts=_SPREAD,
        section="Time and changes",
    ),
    Measure(
        name="residual_max",
        words="Largest optimality residual (certificate)",
        unit="",
        of=effort.largest_residual,
        better=Better.LOWER,
        topic=Topic.SOLVER,
        section="Decisions that fail",
    ),
    Measure(
        name="status",
        words="Decisions by status",
        unit="",
        of=effort.decisions_by_status,
        topic=Topic.DECISION,
        better=Better.LOWER,
        columns=(Column("Decisions failed", effort.decisions_failed),),
        section="Decisions that fail",
    ),
    Measure(
        name="guesses_missed",
        words="Guesses that could not be had",
        unit="",
        of=effort.guesses_missed,
        better=Better.LOWER,
        topic=Topic.SOLVER,
        section="Time and changes",
    ),
    Measure(
        name="violations",
        words="Nodes beyond a hard limit",
        unit="",
        of=lambda run: values.nodes_beyond(run, soft=False),
        better=Better.LOWER,
        topic=Topic.PLATFORM,
        columns=(Column("Hard limits passed"),),
        section="Limits",
    ),
    Measure(
        name="soft_exceeded",
        words="Nodes beyond a soft limit",
        unit="",
        of=lambda run: values.nodes_beyond(run, soft=True),
        better=Better.LOWER,
        topic=Topic.PLATFORM,
        section="Limits",
    ),
    Measure(
        name="limits",
        words="Limits, each in its own unit",
        unit="",
        of=values.limits,
        topic=Topic.PLATFORM,
        listed=False,  # a page has a table of its own for them
        section="Limits",
    ),
    Measure(
        name="supervisor",
        words="What the supervisor of the legs kept",
        unit="",
        of=values.supervised,
        topic=Topic.PLATFORM,
        parts={"times": ("times", ""), "seconds": ("together", "s"), "behind_m": ("farthest behind", "m")},
        section="Limits",
    ),
    Measure(
        name="changes_against_implicit_percent",
        words="Mean changes against implicit",
        unit="%",
        of=None,
        better=Better.LOWER,
        topic=Topic.SOLVER,
        section="Time and changes",
    ),
)

MEASURES: Final = {measure.name: measure for measure in (*_FELT, *_DONE)}
