"""What the driver should feel: named signals, and signals from parameters."""

from otolith.scenarios.catalog import FAMILIES, SCENARIOS, TABLE_5_1, scenario
from otolith.scenarios.scenario import Scenario

__all__ = [
    "FAMILIES",
    "SCENARIOS",
    "TABLE_5_1",
    "Scenario",
    "scenario",
]
