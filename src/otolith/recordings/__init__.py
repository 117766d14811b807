"""Recorded drives: files of many formats are read, checked against physics, and played back as scenarios."""

from otolith.recordings.logs import Log, log_from, parse_log, sampled_log
from otolith.recordings.playback import log_scenario

__all__ = ["Log", "log_from", "log_scenario", "parse_log", "sampled_log"]
