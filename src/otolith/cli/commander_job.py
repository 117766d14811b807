"""Runs of the Commander, made of the same parts and written to the same files as those of `otolith run`."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from io import StringIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from otolith import files, registry
from otolith.cli.loop import Prepared, closed_loop, cueing_of, prepare
from otolith.cli.optimum import Yardstick
from otolith.cli.options import RunOptions
from otolith.cli.output import file_name, screen
from otolith.cli.results import write_results
from otolith.cli.run import write_contest
from otolith.commander.columns import hexapod_of
from otolith.commander.schema import Form, is_file
from otolith.commander.session import PLATFORMS, RESULTS, UPLOADS
from otolith.core.errors import InputError
from otolith.core.frames import DOFS
from otolith.cueing.design import reweigh
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.washout.tuning import Corners
from otolith.experiment import Wanted
from otolith.loop import ClosedLoop, Run
from otolith.metrics.false_cues import false_cues
from otolith.report.ranking import criterion_named

WEIGHTS: Final = ("position", "velocity", "tilt_rate")
SHADED: Final = 200  # false cues that a page shades
COURSE: Final = 1_000  # points of a map
_PLAIN: Final = (
    "scale",
    "lowpass",
    "dofs",
    "liveliness",
    "high_pass",
    "low_pass",
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
        platform = values["platform"]
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
            platform=str(_here(folder / PLATFORMS / platform)) if is_file(platform) else platform,
            weight=[f"{name}={weight:g}" for name, weight in weights if weight is not None] or None,
            given=_given(values),
            **same,
        )

    def command(self) -> str:
        """Return the command line that makes the same run."""
        several = len(self.names) > 1
        words = ["otolith", "compare" if several else "run"]
        words += [self.options.scenario] if self.options.scenario else []
        words += [_shown(word) for option in self.options.as_typed() for word in option]
        for name in self.names if several or self.names != ["predictive"] else ():
            words += ["--cueing", name]
        words += ["--tuning", self.tuning] if self.tuning else []
        return shlex.join(words)

    def prepared(self, console: Console) -> Prepared:
        """Check everything, as `otolith run` does; errors are those of `prepare`."""
        prepared = prepare([self.options], self.names, self.tuning, console)
        if any("tuning" in registry.cueing_named(name).reads for name in self.names):
            _ = prepared.design.tuning  # refused now, where the platform has none
        return prepared


def _shown(word: str) -> str:
    """Return a path from here where it lies below this folder, and any other word as it is."""
    return str(_here(Path(word))) if Path(word).is_absolute() else word


def _here(path: Path) -> Path:
    """Return a path from here where it lies below this folder."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


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
        self._values = dict(values)
        self.hexapod = hexapod_of(design.platform)
        self.map = _map_of(self._prepared.experiments[0][choices.names[0]].wanted)

    def change(self, name: str, value: float) -> None:
        """Change a parameter of all algorithms that have it, from the next decision on."""
        if name == "scale":
            for loop in self.loops:
                loop.rescale(value / self._prepared.experiments[0][loop.names[0]].wanted.scale)
            return
        option = "weight" if name.startswith("weight_") else name
        having = [loop for loop in self.loops if option in registry.cueing_named(loop.names[0]).reads]
        if not having:
            raise InputError(name, "changed, but no algorithm of this run reads it", "left as it is")
        self._values = {**self._values, name: value}
        weights = {of: one for of in WEIGHTS if (one := self._values[f"weight_{of}"]) is not None}
        design = self._prepared.design
        mpc = replace(design.mpc, washout=constant(weights)) if weights else design.mpc
        corners = Corners(high_pass=self._values["high_pass"], low_pass=self._values["low_pass"])
        changed = replace(design, mpc=mpc, liveliness=self._values["liveliness"], corners=corners)
        for loop in having:
            reweigh(loop.cueing, loop.names[0], changed)

    def finish(self, changes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Write the results as `otolith run` or, of two algorithms, as `otolith compare` does."""
        by_hand = {"by_hand": list(changes)} if changes else {}
        runs = [loop.run(settings={**loop.settings, **by_hand}) for loop in self.loops]
        yardstick = Yardstick(self._prepared, False if changes else None, self._console)
        first = runs[0]
        if len(runs) == 1:
            best = yardstick.best(0, first.cueing)
            summary = write_results(first, self.folder, command="run", force=True, best=best)
            return {"summary": summary, "second": None, "false_cues": _false_cues(first)}
        by = "rate" if all(DOFS[name].feels_rate for name in first.dofs) else "rmse"
        criterion = criterion_named(by, first.dofs)
        with files.whole_folder(self.folder, command="compare", force=True) as made:
            for run in runs:
                files.write_run(run, made / f"{file_name(run.cueing)}.h5")
            _, summaries, _ = write_contest(made, [runs], yardstick, (by, criterion))
        one, other = (summaries[first.scenario][run.cueing] for run in runs)
        return {"summary": one, "second": other, "false_cues": _false_cues(first)}


def _false_cues(run: Run) -> list[dict[str, Any]]:
    """Return the gravest false cues of a run, as spans to be shaded."""
    gravest = sorted(false_cues(run), key=lambda cue: -cue.integral)[:SHADED]
    return [
        {"axis": "xyz"[DOFS[cue.dof].felt], "kind": cue.kind, "start": cue.start, "end": cue.end}
        for cue in gravest
    ]


def _map_of(wanted: Wanted) -> dict[str, Any] | None:
    """Return the course of a recorded drive, thinned, in m; None if it has none."""
    drive = None if wanted.log is None else wanted.drive()
    if drive is None or drive.place is None:
        return None
    thin = slice(None, None, max(1, len(drive.t) // COURSE))
    series = {"time": drive.t, "x": drive.place[:, 0], "y": drive.place[:, 1]}
    return {name: np.round(one[thin], 2).tolist() for name, one in series.items()}


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
