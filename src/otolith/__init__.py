"""Otolith: motion cueing for driving simulators.

Otolith turns what a vehicle's driver would feel into what a motion platform should do, and measures how well
this succeeds. This module offers all that a first tour needs. Its names are imported on first use, so `import
otolith` itself takes no time.

Examples
--------
>>> import otolith
>>> design = otolith.Design(platform=otolith.platform("thesis"))
>>> wanted = otolith.Wanted(scenario="sine-1")
>>> run = otolith.Experiment(wanted=wanted, cueing="classical", design=design).run()
>>> print(otolith.summarise(run)["rmse"])
"""

from typing import TYPE_CHECKING, Final

from otolith.core.lazy import on_first_use

if TYPE_CHECKING:
    from otolith.core.errors import InputError as InputError
    from otolith.core.errors import OtolithError as OtolithError
    from otolith.core.frames import HEAVE as HEAVE
    from otolith.core.frames import SURGE_PITCH as SURGE_PITCH
    from otolith.core.frames import SWAY_ROLL as SWAY_ROLL
    from otolith.core.frames import YAW as YAW
    from otolith.core.frames import Dof as Dof
    from otolith.cueing.design import Design as Design
    from otolith.cueing.mpc.settings import MpcSettings as MpcSettings
    from otolith.experiment import Experiment as Experiment
    from otolith.experiment import Wanted as Wanted
    from otolith.files import read_log as read_log
    from otolith.files import read_platform as platform
    from otolith.files import read_run as read_run
    from otolith.files import read_tuning as read_tuning
    from otolith.files import write_run as write_run
    from otolith.files import write_text as write_text
    from otolith.interfaces import Command as Command
    from otolith.interfaces import Cueing as Cueing
    from otolith.interfaces import Outcome as Outcome
    from otolith.interfaces import Plant as Plant
    from otolith.interfaces import PlatformState as PlatformState
    from otolith.interfaces import Reference as Reference
    from otolith.interfaces import Status as Status
    from otolith.loop import Run as Run
    from otolith.loop import simulate as simulate
    from otolith.metrics import compare as compare
    from otolith.metrics import summarise as summarise
    from otolith.platforms import Platform as Platform
    from otolith.platforms import parse_platform as parse_platform
    from otolith.recordings import log_scenario as log_scenario
    from otolith.registry import make_cueing as make_cueing
    from otolith.registry import make_plant as make_plant
    from otolith.report import comparison_figure as comparison_figure
    from otolith.report import cueing_figure as cueing_figure
    from otolith.report import render as report_page
    from otolith.report import save_figure as save_figure
    from otolith.report.notebook import Comparison as Comparison
    from otolith.scenarios import Scenario as Scenario
    from otolith.scenarios import scenario as scenario

__version__: str  # found on first use, as the names below

# Where each name is defined, as "module:name". The imports above state the same for type checkers; a test
# compares the two.
_WHERE: Final = {
    "Command": "interfaces:Command",
    "Comparison": "report.notebook:Comparison",
    "Cueing": "interfaces:Cueing",
    "Design": "cueing.design:Design",
    "Dof": "core.frames:Dof",
    "Experiment": "experiment:Experiment",
    "HEAVE": "core.frames:HEAVE",
    "InputError": "core.errors:InputError",
    "MpcSettings": "cueing.mpc.settings:MpcSettings",
    "OtolithError": "core.errors:OtolithError",
    "Outcome": "interfaces:Outcome",
    "Plant": "interfaces:Plant",
    "Platform": "platforms:Platform",
    "PlatformState": "interfaces:PlatformState",
    "Reference": "interfaces:Reference",
    "Run": "loop:Run",
    "SURGE_PITCH": "core.frames:SURGE_PITCH",
    "SWAY_ROLL": "core.frames:SWAY_ROLL",
    "Scenario": "scenarios:Scenario",
    "Status": "interfaces:Status",
    "Wanted": "experiment:Wanted",
    "YAW": "core.frames:YAW",
    "compare": "metrics:compare",
    "comparison_figure": "report:comparison_figure",
    "cueing_figure": "report:cueing_figure",
    "log_scenario": "recordings:log_scenario",
    "make_cueing": "registry:make_cueing",
    "make_plant": "registry:make_plant",
    "parse_platform": "platforms:parse_platform",
    "platform": "files:read_platform",
    "read_log": "files:read_log",
    "read_run": "files:read_run",
    "read_tuning": "files:read_tuning",
    "report_page": "report:render",
    "save_figure": "report:save_figure",
    "scenario": "scenarios:scenario",
    "simulate": "loop:simulate",
    "summarise": "metrics:summarise",
    "write_run": "files:write_run",
    "write_text": "files:write_text",
}

__all__ = [  # noqa: RUF022 (in the order of `sorted`, as `dir` and `help` show names)
    "Command",
    "Comparison",
    "Cueing",
    "Design",
    "Dof",
    "Experiment",
    "HEAVE",
    "InputError",
    "MpcSettings",
    "OtolithError",
    "Outcome",
    "Plant",
    "Platform",
    "PlatformState",
    "Reference",
    "Run",
    "SURGE_PITCH",
    "SWAY_ROLL",
    "Scenario",
    "Status",
    "Wanted",
    "YAW",
    "compare",
    "comparison_figure",
    "cueing_figure",
    "log_scenario",
    "make_cueing",
    "make_plant",
    "parse_platform",
    "platform",
    "read_log",
    "read_run",
    "read_tuning",
    "report_page",
    "save_figure",
    "scenario",
    "simulate",
    "summarise",
    "write_run",
    "write_text",
]


if not TYPE_CHECKING:
    __getattr__ = on_first_use(__name__, {**_WHERE, "__version__": "core.version:VERSION"})


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
