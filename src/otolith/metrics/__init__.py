"""Key figures of a run. They are computed from a `Run` and know no algorithm."""

from otolith.metrics.against_best import Best, against_best, best_in_words
from otolith.metrics.catalogue import MEASURES
from otolith.metrics.effort import distribution
from otolith.metrics.false_cues import FalseCue, false_cues
from otolith.metrics.limits import Excess, excesses
from otolith.metrics.measure import Better, Column, Measure, Reading, Scale, Topic
from otolith.metrics.perceived import perceived_error, perceived_rate_rmse, perceived_rmse
from otolith.metrics.rating import mismatch_rating
from otolith.metrics.sickness import illness_percent, sickness_dose, sickness_weighting
from otolith.metrics.similarity import correlation, delay, mean_absolute_difference, scale_ratio
from otolith.metrics.summary import against_baseline, compare, summarise, with_best
from otolith.metrics.tracking import rate_rmse, tracking_rmse, travel_rms
from otolith.metrics.unwanted import neutral_crossings, turns_against, unwanted_cues
from otolith.metrics.verdict import between_nodes, breaches, failures, held_back
from otolith.metrics.workspace import WorkspaceUse, workspace_use

__all__ = [
    "MEASURES",
    "Best",
    "Better",
    "Column",
    "Excess",
    "FalseCue",
    "Measure",
    "Reading",
    "Scale",
    "Topic",
    "WorkspaceUse",
    "against_baseline",
    "against_best",
    "best_in_words",
    "between_nodes",
    "breaches",
    "compare",
    "correlation",
    "delay",
    "distribution",
    "excesses",
    "failures",
    "false_cues",
    "held_back",
    "illness_percent",
    "mean_absolute_difference",
    "mismatch_rating",
    "neutral_crossings",
    "perceived_error",
    "perceived_rate_rmse",
    "perceived_rmse",
    "rate_rmse",
    "scale_ratio",
    "sickness_dose",
    "sickness_weighting",
    "summarise",
    "tracking_rmse",
    "travel_rms",
    "turns_against",
    "unwanted_cues",
    "with_best",
    "workspace_use",
]
