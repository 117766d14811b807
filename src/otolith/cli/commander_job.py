"""Runs of the Commander, made of the same parts and written to the same files as those of `otolith run`."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from io import StringIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from otolith import files
from otolith.cli.loop import Prepared, closed_loop, cueing_of, prepare
from otolith.cli.optimum import Yardstick
from otolith.cli.options import RunOptions
from otolith.cli.output import screen
from otolith.cli.results import write_results
from otolith.commander.schema import Form
from otolith.commander.session import RESULTS, UPLOADS
from otolith.core.errors import InputError
from otolith.loop import ClosedLoop, Run
from otolith.platforms import Platform

WEIGHTS: Final = ("position", "velocity", "tilt_rate")
NO_OPTIMUM: Final = "it was changed by hand while it ran, so that the best of its drive is no measure of it"
_PLAIN: Final = (
    "scale",
    "lowpass",
    "platform",
    "dofs",
    "liveliness",
    "horizon",
    "washout",
    "guess_entry",
    "solver",
)
_OR_NONE: Final = ("through", "plant", "prediction", "blocks", "braking")  # empty in the form: none given


class Choices:
    """A form's values as what `otolith run` is given.

    Raises
    ------
    InputError : algorithm B is algorithm A.
    """

    def __init__(self, values: Mapping[str, Any], folder: Path) -> None:
        weights = [(name, values[f"weight_{name}"]) for name in WEIGHTS]
        log = folder / UPLOADS / values["log"] if values["log"] else None
        self.names = [name for name in (values["cueing"], values["second"]) if name]
        if len(set(self.names)) < len(self.names):
            raise InputError("second", repr(values["second"]), "another algorithm than A, or empty")
        self.tuning = values["tuning"] or None
        same: dict[str, Any] = {name: values[name] for name in _PLAIN}
        same |= {name: values[name] or None for name in _OR_NONE}
        self.options = RunOptions(
            scenario=None if log else values["scenario"],
            log=log,
            weight=[f"{name}={weight:g}" for name, weight in weights if weight is not None] or None,
            given=_given(values),
            **same,
        )

    def command(self) -> str:
        """Return the command line that makes the same run."""
        several = len(self.names) > 1
        words = ["otolith", "compare" if several else "run"]
        words += [self.options.scenario] if self.options.scenario else []
        for one in fields(RunOptions):
            value = getattr(self.options, one.name)
            if one.name not in ("scenario", "given") and value != one.default:
                option = f"--{one.name.replace('_', '-')}"
                listed = value if isinstance(value, list) else [value]
                words += [word for item in listed for word in (option, str(item))]
        for name in self.names if several or self.names != ["predictive"] else ():
            words += ["--cueing", name]
        words += ["--tuning", self.tuning] if self.tuning else []
        return shlex.join(words)

    def prepared(self, console: Console) -> Prepared:
        """Check everything, as `otolith run` does; errors are those of `prepare`."""
        return prepare([self.options], self.names, self.tuning, console)


def _given(values: Mapping[str, Any]) -> frozenset[str]:
    """Return the options that differ from the form's defaults: those that somebody set."""
    default = Form().model_dump()
    changed = {name for name in default if values[name] != default[name]}
    weights = {"weight"} if any(values[f"weight_{name}"] is not None for name in WEIGHTS) else set()
    return frozenset((changed & {one.name for one in fields(RunOptions)}) | weights | changed & {"tuning"})


class Told(StringIO):
    """Where a console writes: every line is told as a sentence."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        super().__init__()
        self._tell = tell

    def write(self, text: str) -> int:
        """Tell the lines of a text."""
        for line in filter(None, map(str.strip, text.splitlines())):
            self._tell(line.removeprefix("note: "))
        return len(text)


def console_to(tell: Callable[[str], None]) -> Console:
    """Return a console whose lines are told."""
    return screen(file=Told(tell))


class Runs:
    """One run, or two side by side: the worker's job, see `otolith.commander.job.Job`."""

    def __init__(
        self, values: Mapping[str, Any], tell: Callable[[str], None], *, folder: Path, name: str
    ) -> None:
        choices = Choices(values, folder)
        self._console = console_to(tell)
        self._prepared = choices.prepared(self._console)
        design = self._prepared.design
        self.command, self.folder = choices.command(), folder / RESULTS / name
        self.loops: Sequence[ClosedLoop] = [
            closed_loop(self._prepared, 0, one, cueing_of(self._prepared, one, design))
            for one in choices.names
        ]
        self.hexapod, self.map = hexapod_of(design.platform), None

    def change(self, name: str, value: float) -> None:
        """Change a parameter of all algorithms that have it, from the next decision on."""
        if name == "scale":
            for loop in self.loops:
                loop.rescale(value / self._prepared.experiments[0][loop.names[0]].wanted.scale)

    def finish(self, changes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Write the results as `otolith run` or, of two algorithms, as `otolith compare` does."""
        runs = [loop.run(settings=_settings(loop, changes)) for loop in self.loops]
        yardstick = Yardstick(self._prepared, False if changes else None, self._console)
        best = [NO_OPTIMUM if changes else yardstick.best(0, run.cueing) for run in runs]
        return write_results(runs[0], self.folder, command="run", force=True, best=best[0])


def _settings(loop: ClosedLoop, changes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {**loop.settings, **({"by_hand": list(changes)} if changes else {})}


def hexapod_of(platform: Platform) -> dict[str, Any] | None:
    """Return what a page needs to draw the legs, in m; None if the platform has none."""
    if platform.hexapod is None:
        return None
    legs = platform.six_legs()
    return {
        "base": legs.anchors.tolist(),
        "platform": legs.joints.tolist(),
        "neutral": legs.lengths(np.zeros(6)).tolist(),
        "stroke": list(legs.stroke),
    }


def make_runs(folder: Path, values: Mapping[str, Any], tell: Callable[[str], None], name: str) -> Runs:
    """Make the job of the worker."""
    return Runs(values, tell, folder=folder, name=name)


class CommanderDesk:
    """What the server asks of the rest of the program."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def check(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the checks of a form, and its command line; a refused value is an InputError."""
        notes: list[str] = []
        choices = Choices(values, self._folder)
        prepared = choices.prepared(console_to(notes.append))
        (scenario,) = prepared.scenarios
        passed = {
            "input": f"{scenario.name}: {scenario.duration:g} s",
            "platform": f"{prepared.design.platform.name} has all that {choices.options.dofs} needs",
            "algorithm": " and ".join(f"{name} on plant {plant}" for name, plant in prepared.plants.items()),
        }
        checks = [{"name": name, "ok": True, "sentence": text} for name, text in passed.items()]
        checks += [{"name": "note", "ok": True, "sentence": note} for note in notes]
        return {"checks": checks, "command": choices.command()}

    def understood(self, path: Path) -> str:
        """Say what is understood of a recorded drive; one that is refused is an InputError."""
        log = files.read_log(path, {})
        return f"read as a drive, with {', '.join(log.channels)}"

    def samples(self, run: Path) -> str:
        """Return the samples of a stored run as text, comma-separated."""
        return csv_of(files.read_run(run))


def csv_of(run: Run) -> str:
    """Return time, forces, pose and twist of a run's samples; degrees where the name says so."""
    names = ["time_s", *(f"wanted_{of}_mps2" for of in "xyz"), *(f"felt_{of}_mps2" for of in "xyz")]
    names += [f"{axis}_m" for axis in ("surge", "sway", "heave")]
    names += [f"{axis}_deg" for axis in ("roll", "pitch", "yaw")]
    pose = run.pose.copy()
    pose[:, 3:] = np.degrees(pose[:, 3:])
    text = StringIO()
    data = np.column_stack([run.time, run.reference_force, run.felt_force, pose])
    np.savetxt(text, data, fmt="%.6g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()
