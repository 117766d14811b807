"""A closed loop as a value: what is wanted, what decides, and what moves; a run's file stores it.

`otolith run`, `compare` and `rerun` make their runs here, and so does `otolith.Experiment` in Python. A run
that was made in one way can be repeated, bit for bit, in the other.
"""

import functools
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from otolith import __version__, files, registry
from otolith.core.errors import CorruptFile, InputError, damage_reported
from otolith.core.frames import Dof, pairs_of
from otolith.cueing.design import Design
from otolith.cueing.hints.stored import Refused, StaleHint, StoredHint
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.optimum import NAME as OPTIMUM
from otolith.cueing.optimum import Optimum, measure_of
from otolith.cueing.optimum import optimum as best_motion
from otolith.cueing.prediction import Road
from otolith.loop import Keeper, Run, simulate
from otolith.loop.keep import kept
from otolith.loop.run import DECIDED, SAMPLED
from otolith.perception import sense
from otolith.platforms import Platform
from otolith.record import design_from_record, design_to_record
from otolith.recordings.settings import PLAIN, LogSettings
from otolith.scenarios import Scenario, scenario
from otolith.scenarios.perceived import perceived

if TYPE_CHECKING:  # what reads recorded drives is imported on use: most runs have none
    from otolith.recordings import Log

# Fields of a run that may differ when it is repeated. The scenario of a log and an algorithm from outside are
# named after files.
FREE: Final = ("step_time", "settings", "scenario", "cueing")


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredFile:
    """A file from which a run was made: its path and its SHA-256."""

    path: str
    sha256: str

    @classmethod
    def of(cls, path: Path) -> "StoredFile":
        """Describe the file at a path, or all files of a folder (a ROS bag is one)."""
        parts = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
        total = hashlib.sha256()
        for part in parts:
            try:
                with part.open("rb") as file:
                    total.update(hashlib.file_digest(file, "sha256").digest())
            except OSError as error:
                raise InputError(f"file {part}", f"not readable ({error.strerror})", "readable") from error
        return cls(path=str(path), sha256=total.hexdigest())

    def found(self, what: str, instead: Path | None = None) -> Path:
        """Return the path of the file, or its new path, if its content is unchanged.

        Raises
        ------
        InputError : there is no such file, or its content has changed.
        """
        path = instead or Path(self.path)
        if not path.exists():
            raise InputError(f"{what} {path}", "no longer there", f"an existing file; --{what} names it anew")
        now = StoredFile.of(path).sha256
        if now != self.sha256:
            bound = f"{self.sha256[:12]}…, as when the run was made"
            raise InputError(f"SHA-256 of {what} {path}", f"{now[:12]}…", bound)
        return path


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What the driver should feel, as plain values: a scenario or a drive, and its treatment."""

    scenario: str | None = None  # a name or a formula, see `otolith.scenarios.scenario`
    log: Path | None = None  # a recorded drive instead
    road: Path | None = None  # an earlier drive along the same road, whose forces are foreseen
    reading: LogSettings = PLAIN  # how the logs are to be read
    lowpass_hz: float | None = None
    causal: bool = False
    literal: bool = False  # whether steps end as the thesis prints
    through: str | None = None  # an otolith of the registry that filters the reference
    scale: float = 1.0

    def drive(self) -> "Log":
        """Read the recorded drive with the settings in `reading`.

        Raises
        ------
        InputError : there is no recorded drive, or the log is refused.
        """
        if self.log is None:
            bound = "one of 'otolith run --log', or given --log"
            raise InputError("the run", "not of a recorded drive", bound)
        return self._read(self.log)

    def _read(self, path: Path) -> "Log":
        plain = replace(self.reading, needs=())
        return files.read_log(path, self.reading.columns, needs=self.reading.needs, settings=plain)

    def along(self, design: Design, *, note: Callable[[str], None] = lambda _: None) -> Scenario:
        """Return the scenario along the axes that a design cues; a log is resampled.

        The sampling period is that of the implicit MPC for every algorithm, so that all are judged against
        the same reference.

        Parameters
        ----------
        note : is called with a sentence for everything that was assumed or repaired in a log.
        """
        self._check_road(design)
        if self.log is None and self.scenario is not None:
            named = [scenario(self.scenario, literal=self.literal, axis=dof.along) for dof in design.dofs]
            return self._sensed(functools.reduce(Scenario.combined_with, named)).scaled(self.scale)
        if self.log is None or self.scenario is not None:
            found = "given twice" if self.log is not None else "absent"
            raise InputError("the reference", found, "either a scenario's name or --log FILE")
        log = self.drive()
        for sentence in log.notes:
            note(sentence)
        return self._foreseeing(log, design.mpc.period).scaled(self.scale)

    def _check_road(self, design: Design) -> None:
        """Refuse an earlier drive that no prediction reads, and a prediction that lacks its earlier drive."""
        asked = isinstance(design.mpc.prediction, Road)
        if asked and self.road is None:
            raise InputError("--prediction road", "given alone", "given with --road FILE, an earlier drive")
        if self.road is not None and self.log is None:
            raise InputError("--road", "given without --log", "given with --log FILE, a drive of that road")
        if self.road is not None and not asked:
            raise InputError("--road", "given", "left out, or given with --prediction road")

    def _foreseeing(self, log: "Log", period: float) -> Scenario:
        """Return the drive as a scenario, which foresees what an earlier drive of the road felt."""
        present = self._played(log, period)
        if self.road is None:
            return present
        from otolith.recordings.foresight import foresight

        then = self._read(self.road)
        felt_then = self._played(then, period).specific_force
        seen = foresight(log, then, period=period, force=present.specific_force, forces_then=felt_then)
        return replace(present, foreseen=seen)

    def _played(self, log: "Log", period: float) -> Scenario:
        """Return a drive as a scenario, treated in every way but the scale."""
        from otolith.recordings import log_scenario

        plain = log_scenario(log, period=period, lowpass_hz=self.lowpass_hz, causal=self.causal)
        return self._sensed(plain)

    def _sensed(self, reference: Scenario) -> Scenario:
        """Return the reference filtered by the organ `through`, from steady state at its first value."""
        if self.through is None:
            return reference
        otoliths = {k: e for k, e in registry.PERCEPTION.items() if k.startswith("otolith-")}
        name = self.through if self.through in otoliths else f"otolith-{self.through}"
        organ = registry.lookup(otoliths, "--through", name).load()()
        return perceived(reference, lambda f, dt: sense(organ, f, dt, before=f[0]), name=name)

    def record(self) -> dict[str, Any]:
        """Return plain values, with the SHA-256 of the log."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        reading = asdict(self.reading) | {"needs": list(self.reading.needs)}
        drives = {
            name: None if path is None else asdict(StoredFile.of(path))
            for name, path in (("log", self.log), ("road", self.road))
        }
        return values | {"reading": reading if self.log is not None else None, **drives}

    @classmethod
    def from_record(
        cls,
        record: Mapping[str, Any],
        *,
        log: Path | None = None,
        road: Path | None = None,
        check: bool = True,
    ) -> "Wanted":
        """Restore from a record.

        Parameters
        ----------
        log, road : new paths of the drives.
        check : whether their content must be unchanged.
        """
        values = dict(record)
        values["reading"] = PLAIN if values["reading"] is None else LogSettings(**values["reading"])
        for name, moved in (("log", log), ("road", road)):
            if values[name] is not None:
                stored = StoredFile(**values[name])
                values[name] = stored.found(name, moved) if check else moved or Path(stored.path)
            elif name == "log":
                values[name] = moved
        return cls(**values)


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One closed loop, ready to run: what is wanted, the design, the names of algorithm and plant.

    Examples
    --------
    >>> platform = otolith.platform("thesis")
    >>> wanted, design = otolith.Wanted(scenario="sine-1"), otolith.Design(platform=platform)
    >>> run = otolith.Experiment(wanted=wanted, cueing="classical", design=design).run()
    """

    wanted: Wanted
    design: Design
    cueing: str = "predictive"  # of the registry, "module:attribute" or "file.py:attribute"; or "optimum"
    plant: str | None = None  # a name of the registry; None for the plant that the algorithm assumes
    law: Path | None = None  # the file of `design.stored_laws`
    hint: Path | None = None  # the file of `design.hint`

    @property
    def plant_name(self) -> str:
        """Return the name of the plant; errors are those of `otolith.registry.cueing_named`."""
        if self.cueing == OPTIMUM:
            return self.plant or "ideal"
        return self.plant or registry.cueing_named(self.cueing).plant

    def run(self, *, progress: Callable[[float], None] = lambda _: None, keep: Keeper | None = None) -> Run:
        """Simulate the closed loop.

        Parameters
        ----------
        progress : is called with the fraction done.
        keep : keeps the record, e.g. in a file (`otolith.files.run_file`); by default, it stays in memory.

        Raises
        ------
        OtolithError : a value is refused, or an algorithm from outside failed.
        """
        if self.cueing == OPTIMUM:
            return kept(self.optimum().run, keep)
        reference = self.wanted.along(self.design)
        plant = registry.make_plant(self.plant_name, self.design.platform)
        cueing = registry.make_cueing(self.cueing, self.design, dead_time=plant.dead_time)
        return simulate(
            cueing,
            plant,
            reference,
            platform=self.design.platform,
            dofs=tuple(dof.name for dof in self.design.dofs),
            names=(self.cueing, self.plant_name),
            settings=self.record(),
            preview=self.design.preview,
            progress=progress,
            keep=keep,
        )

    def optimum(self, reference: Scenario | None = None) -> Optimum:
        """Return the best that is possible on this drive, whatever the algorithm; `summarise` takes it.

        It is of the ideal platform, without lag if the plant has none. Errors are those of
        `otolith.cueing.optimum.optimum`.

        Parameters
        ----------
        reference : the scenario that `wanted` gives along the design's axes, if it is known already.
        """
        own = replace(self.wanted, road=None)  # what is foreseen does not matter to it
        best = replace(self, wanted=own, cueing=OPTIMUM, plant=measure_of(self.plant_name))
        return best_motion(
            self.design.platform,
            self.design.dofs,
            reference or self.wanted.along(self.design),
            plant=best.plant_name,
            settings=best.record(),
        )

    def record(self) -> dict[str, Any]:
        """Return plain JSON values that, with what a `Run` stores itself, repeat the run."""
        known = None if self.cueing == OPTIMUM else registry.cueing_named(self.cueing)
        reads = frozenset() if known is None else known.reads
        outside = known is not None and known.outside
        hint = self.design.hint
        return {
            "version": __version__,
            "wanted": self.wanted.record(),
            "design": design_to_record(self.design, None if outside else reads),
            "law": _stored(self.law, asked=bool(self.design.stored_laws) and "law" in reads),
            "hint": _stored(self.hint, asked=hint is not None and "hint" in reads),
            **({"hint_refused": hint.reason} if isinstance(hint, Refused) else {}),
        }

    @classmethod
    def of(
        cls,
        run: Run,
        *,
        cueing: str | None = None,
        log: Path | None = None,
        road: Path | None = None,
        law: Path | None = None,
        hint: Path | None = None,
    ) -> "Experiment":
        """Return the experiment that made a run; paths are given if files have moved.

        An algorithm from outside must be named again in `cueing`, because a file is data and starts no code.

        Raises
        ------
        InputError : the run was made of objects that its file does not contain, or a file is missing or
            changed.
        CorruptFile : the settings of the run are of another version, or damaged.
        """
        settings = run.settings
        if "wanted" not in settings:
            bound = "one that 'otolith run' or otolith.Experiment made"
            raise InputError("the run", "made of objects that its file does not hold", bound)
        if "by_hand" in settings:
            bound = "one that ran from its start to its end as it was set"
            raise InputError("the run", "changed or stopped by hand while it ran", bound)
        if cueing is None and ":" in run.cueing:
            bound = f"given: the run names {run.cueing}, and no file starts code by itself"
            raise InputError("--cueing", "absent", bound)
        paths = {
            "law": _named("law", settings.get("law"), law),
            "hint": _named("hint", settings.get("hint"), hint),
        }
        with damage_reported("the settings of the run are not of this version"):
            design = design_from_record(settings["design"], run.platform, run.dofs)
            wanted = Wanted.from_record(settings["wanted"], log=log, road=road)
        if paths["law"] is not None:
            design = replace(design, stored_laws=files.read_laws(paths["law"]))
        if paths["hint"] is not None:
            known = hint_for(paths["hint"], run.platform, pairs_of(design.dofs), design.mpc)
            design = replace(design, hint=known)
        name = cueing or run.cueing
        return cls(wanted=wanted, design=design, cueing=name, plant=run.plant, **paths)


def hint_for(
    path: Path, platform: Platform, pairs: tuple[Dof, ...], settings: MpcSettings
) -> StoredHint | Refused:
    """Return a stored hint, or why it cannot be used; without a hint answers are the same but take longer."""
    try:
        hint = files.read_hint(path)
        hint.check(platform, pairs, settings)
    except (CorruptFile, StaleHint) as error:
        return Refused(str(error))
    return hint


def differences(run: Run, again: Run) -> list[str]:
    """Return the fields in which two runs differ by any bit, except times, settings and names."""
    names = [one.name for one in fields(Run) if one.name not in FREE]
    series = {*SAMPLED, *DECIDED}
    if run.samples != again.samples or run.decisions != again.decisions:
        return [name for name in names if name in series or getattr(run, name) != getattr(again, name)]
    equal = dict.fromkeys(names, True)
    for one, other in zip(run.parts(), again.parts(), strict=True):
        for name in names:
            equal[name] = equal[name] and _equal(getattr(one, name), getattr(other, name))
    return [name for name in names if not equal[name]]


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return bool(a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes())
    return bool(a == b)


def _stored(path: Path | None, *, asked: bool) -> dict[str, str] | None:
    """Return the record of a file that was read; the path is empty if it is unknown."""
    if not asked:
        return None
    return asdict(StoredFile(path="", sha256="") if path is None else StoredFile.of(path))


def _named(what: str, record: Mapping[str, str] | None, instead: Path | None) -> Path | None:
    """Return the path of a file from which a run was made; None if it was made without one."""
    if record is None:
        return None
    stored = StoredFile(**record)
    if stored.path:
        return stored.found(what, instead)
    if instead is None:
        raise InputError(f"--{what}", "absent", f"the file of the {what}, which the run does not name")
    return instead
