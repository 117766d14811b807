"""Settings of a trial as files and commands that others use."""

import csv
import io
import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from otolith.cueing.design import Design
from otolith.studies.definition import Study
from otolith.studies.jobs import JUDGING, TRAINING
from otolith.studies.results import State, Trial, excesses, values
from otolith.studies.settings import Settings, options, tuning_of


def command(study: Study, settings: Settings, reference: str, tuning: str = "") -> str:
    """Return the command that cues a reference with settings.

    Parameters
    ----------
    reference : a scenario, or options that name a drive.
    tuning : path of the tuning's file, if `tuning_text` gives one.
    """
    platform = shlex.quote(study.platform)
    words = ["otolith run", reference, f"--cueing {study.cueing} --platform {platform}"]
    words += [f"--dofs {study.dofs}"] if study.dofs != "surge-pitch" else []
    words += [f"--plant {study.plant}"] if study.plant else []
    words += options({**study.fixed, **settings})
    return " ".join([*words, *([f"--tuning {shlex.quote(tuning)}"] if tuning else [])])


def reference_of(study: Study) -> str:
    """Return the first reference as `otolith run` takes it, which runs the whole of a drive."""
    first = (study.judging or study.training)[0]
    words = [first.scenario or f"--log {shlex.quote(str(first.log))}"]
    words += [f"--lowpass {first.lowpass_hz:g}"] if first.lowpass_hz is not None else []
    words += ["--causal"] if first.causal else []
    words += [f"--through {first.through}"] if first.through is not None else []
    words += [f"--scale {first.scale!r}"] if first.scale != 1.0 else []
    return " ".join(words)


def from_here(study: Study, folder: str) -> Study:
    """Return the study with its paths relative to the current folder, for commands that are shown."""

    def path(name: str) -> str:
        return os.path.relpath(Path(folder) / name)

    sets = {
        kind: tuple(
            one if one.log is None else one.model_copy(update={"log": path(one.log)})
            for one in getattr(study, kind)
        )
        for kind in (TRAINING, JUDGING)
    }
    platform = path(study.platform) if study.platform.endswith(".toml") else study.platform
    return study.model_copy(update={**sets, "platform": platform})


def tuning_text(design: Design, settings: Settings, about: str) -> str:
    """Return the tuning of washouts with settings as a TOML file; empty if they set nothing of one."""
    tuning = tuning_of(design, settings)
    if tuning is None:
        return ""
    fields = {name: value for name, value in tuning.model_dump().items() if value is not None}
    return toml(fields | {"description": about})


def settings_text(study: Study, settings: Settings, about: str, reference: str) -> str:
    """Return settings as a TOML file, with the command that uses them."""
    header = f"# {about}\n#\n#     {command(study, settings, reference)}\n\n"
    return header + toml({"cueing": study.cueing, "settings": {**study.fixed, **settings}})


def table(study: Study, trials: Sequence[Trial]) -> str:
    """Return all trials as a CSV table: settings, objectives and by how much constraints are passed."""
    file = io.StringIO()
    objectives = [f"{one.measure} ({one.over})" for one in study.objectives]
    constraints = [f"{one.measure} ({one.over}) beyond {one.most:g}" for one in study.constraints]
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["trial", "state", *study.parameters, *objectives, *constraints])
    for trial in trials:
        row: list[Any] = ["" for _ in (*objectives, *constraints)]
        if trial.state is State.DONE:
            row = [*values(study, trial.training), *excesses(study, trial.training).values()]
        given = [trial.settings[name] for name in study.parameters]
        writer.writerow([trial.number, trial.state.value, *given, *row])
    return file.getvalue()


def toml(fields: Mapping[str, Any], path: str = "") -> str:
    """Return nested tables of numbers and words as TOML."""
    plain = {name: one for name, one in fields.items() if not isinstance(one, Mapping)}
    lines = [f"[{path}]"] if path and plain else []
    lines += [f"{_key(name)} = {_value(one)}" for name, one in plain.items()]
    text = "\n".join(lines) + "\n" if lines else ""
    for name, one in fields.items():
        if isinstance(one, Mapping):
            below = toml(one, f"{path}.{_key(name)}" if path else _key(name))
            text += ("\n" if text else "") + below
    return text


def _key(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else f'"{name}"'


def _value(value: float | int | str) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(value)
