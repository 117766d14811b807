"""What the driver should feel: named signals, signals from parameters, recorded drives."""

from otolith.scenarios.catalog import FAMILIES, SCENARIOS, TABLE_5_1, scenario
from otolith.scenarios.logs import Log, log_from, parse_log, sampled_log
from otolith.scenarios.playback import log_scenario
from otolith.scenarios.scenario import Scenario

__all__ = [
    "FAMILIES",
    "SCENARIOS",
    "TABLE_5_1",
    "Log",
    "Scenario",
    "log_from",
    "log_scenario",
    "parse_log",
    "sampled_log",
    "scenario",
]
