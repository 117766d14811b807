"""Recorded drives: files of many formats are read, checked against physics, and played back as scenarios."""

from typing import TYPE_CHECKING

from otolith.core.lazy import on_first_use

if TYPE_CHECKING:
    from otolith.recordings.logs import Log, log_from, parse_log, sampled_log
    from otolith.recordings.playback import log_scenario
else:
    __getattr__ = on_first_use(
        __name__,
        {
            "Log": "logs",
            "log_from": "logs",
            "log_scenario": "playback",
            "parse_log": "logs",
            "sampled_log": "logs",
        },
    )

__all__ = ["Log", "log_from", "log_scenario", "parse_log", "sampled_log"]
