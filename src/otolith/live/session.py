"""A session: its settings with all that they name, and the two cores that are made of it.

It travels to the processes once, at their start, and stands in the log, so that a replay makes the same cores
again (`to_record`, `session_from_record`).
"""

import json
import math
import platform as machine
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import numpy as np

from otolith import files, registry
from otolith.core.errors import CorruptFile, InputError, damage_reported, one_of
from otolith.core.frames import dofs_named
from otolith.cueing.design import Design, reweigh
from otolith.cueing.hints.stored import Refused
from otolith.cueing.washout.tuning import Corners, Tuning, tunings
from otolith.experiment import StoredFile, hint_for
from otolith.interfaces import PlatformState, Reference
from otolith.live.controller import Controller, Wanted, plain
from otolith.live.core.bounds import bounds_of, widened
from otolith.live.core.device import Device
from otolith.live.core.gate import Gate
from otolith.live.core.health import Health
from otolith.live.core.parameters import Parameters, Tuned
from otolith.live.devices.driver import Driver
from otolith.live.devices.generic import Generic
from otolith.live.devices.moog import Moog
from otolith.live.devices.reach import Sent
from otolith.live.devices.template import Axis, Template
from otolith.live.output import Output
from otolith.live.settings import Settings, TemplateTable, narrowed
from otolith.live.wire.axes import AxisMap, axes_from
from otolith.live.wire.source import Source
from otolith.live.wire.sources import source_named
from otolith.platforms import Platform, catalog
from otolith.platforms.machines import check_machine

PERIOD: Final = 0.01  # [s] of the algorithms that are run live
LIBRARIES: Final = ("numpy", "numba", "scipy", "daqp", "ruckig")  # on which a decision's bits depend


@dataclass(frozen=True, slots=True, kw_only=True)
class Session:
    """All that the processes of a session have to know."""

    settings: Settings
    platform: Platform  # with the limits of the session
    tuning: Tuning | None = None
    axes: AxisMap | None = None  # None: the source is in our axes
    texts: Mapping[str, str] = field(default_factory=dict)  # files of channels that the source needs
    stored: Mapping[str, StoredFile] = field(default_factory=dict)  # what was read, by what it is
    period: float = PERIOD  # [s] of the algorithm
    token: int = 0
    forbids: str = ""  # why the platform must not be armed; empty if it may be

    @property
    def source(self) -> Source:
        """Return the parser of telemetry."""
        return source_named(self.settings.input.source, self.texts.__getitem__)

    @property
    def wanted(self) -> Wanted:
        """Return what makes of a sample what should be felt."""
        return plain if self.axes is None else self.axes.wanted

    def health(self) -> Health:
        """Return a new judge of the telemetry."""
        return Health(pauses_silently=self.settings.input.pauses_silently)

    @property
    def listen(self) -> tuple[str, int]:
        """Return host and port of the telemetry."""
        return _host_and_port(self.settings.input.listen)

    @property
    def forward(self) -> tuple[str, int] | None:
        """Return host and port of who gets every packet of telemetry too; None if nobody does."""
        stated = self.settings.input.forward
        return None if stated is None else _host_and_port(stated)

    @property
    def driver(self) -> Driver:
        """Return what speaks the language of the device."""
        stated = self.settings.device
        if stated.kind == "moog":
            return Moog(
                interface=stated.interface or "",
                neutral_heave=stated.neutral_heave_m or 0.0,
                reach=stated.reach or "public",
                on_silence=stated.on_silence or "parks",
            )
        if stated.template is not None:
            return self._template(stated.template)
        return Generic(on_silence=stated.on_silence or "falls")  # the strictest: it is braked first

    def _template(self, stated: TemplateTable) -> Template:
        """Return the driver of a template; its legs or cranks are the platform's."""
        hexapod = None if self.platform.hexapod is None else self.platform.six_legs()
        return Template(
            name="template",
            frame=stated.frame,
            axes=tuple(Axis(follows=one.follows, low=one.low, high=one.high) for one in stated.axes),
            bits=stated.bits,
            form=stated.form,
            start=stated.start,
            stop=stated.stop,
            rate_hz=stated.rate_hz,
            on_silence=self.settings.device.on_silence or "falls",
            legs=None if hexapod is None else hexapod.positions,
            cranks=hexapod is not None and hexapod.cranks is not None,
        )

    @property
    def sent(self) -> Sent:
        """Return where the platform may be sent; a Moog base is at home in its park pose."""
        bounds = bounds_of(self.platform, self.platform.actuators.lag_s)
        if self.settings.device.kind != "moog":
            bounds = widened(bounds, np.array(self.park))
        sides = np.array([bounds.circle] * 2 + [math.inf] * 4)
        size = 1.0 if bounds.radius == 0.0 else bounds.radius
        stroke = (bounds.stroke[0] / size, bounds.stroke[1] / size)
        return Sent(np.maximum(bounds.low, -sides), np.minimum(bounds.high, sides), stroke)

    @property
    def device(self) -> tuple[str, int]:
        """Return host and port of the device."""
        return _host_and_port(self.settings.device.address)

    @property
    def park(self) -> tuple[float, ...]:
        """Return the pose (6,) [m, rad] where the device rests without power."""
        stated = self.settings.device
        heave = stated.template.park_heave_m if stated.template else stated.neutral_heave_m or 0.0
        return (0.0, 0.0, heave, 0.0, 0.0, 0.0)

    def gate(self, *, travel: bool = False) -> Gate:
        """Return the gate of cueing, or of the moves from and to the park pose."""
        park = np.array(self.park) if travel else None
        return Gate(self.platform, lag=self.platform.actuators.lag_s, period=self.period, park=park)

    def design(self) -> Design:
        """Return what the algorithm is made of.

        Raises
        ------
        InputError, CorruptFile : a stored law or hint is damaged, has changed, or belongs to another model.
        """
        stated = self.settings
        design = Design(
            platform=self.platform,
            dofs=dofs_named(stated.dofs.split(",")),
            washout=self.tuning,
            liveliness=stated.liveliness,
            corners=Corners(high_pass=stated.high_pass, low_pass=stated.low_pass),
            stored_laws=files.read_laws(self.stored["laws"].found("laws")) if stated.laws else (),
        )
        if stated.laws:
            _ = design.laws  # refused now if they are of another model
        if stated.hint is None:
            return design
        hint = hint_for(self.stored["hint"].found("hint"), self.platform, design.pairs, design.mpc)
        if isinstance(hint, Refused):
            raise CorruptFile(f"hint {stated.hint} is refused: {hint.reason}")
        return replace(design, hint=hint)

    def controller(self) -> Controller:
        """Return the controller's core, after everything it needs is compiled and has run once."""
        design = self.design()
        cueing = registry.make_cueing(self.settings.cueing, design)
        for force in (0.0, 0.1, -0.1):  # compiled now
            cueing.step(PlatformState(), Reference(specific_force=np.array([force, force, 0.0])))
        cueing.reset(PlatformState())

        def use(parameters: Parameters) -> None:
            if len(self.offered) > 1:
                corners = Corners(high_pass=parameters.high_pass, low_pass=parameters.low_pass)
                changed = replace(design, liveliness=parameters.liveliness, corners=corners)
                reweigh(cueing, self.settings.cueing, changed)

        use(self.parameters)
        return Controller(
            cueing,
            self.gate(),
            parse=self.source.parse,
            wanted=self.wanted,
            health=self.health(),
            tuned=Tuned(self.parameters, use),
        )

    @property
    def parameters(self) -> Parameters:
        """Return what may change while it runs, as it is at the start."""
        stated = self.settings
        return Parameters(**{one.name: getattr(stated, one.name) for one in fields(Parameters)})

    @property
    def offered(self) -> tuple[str, ...]:
        """Return the names of the parameters that its algorithm has."""
        reads = registry.cueing_named(self.settings.cueing).reads
        return ("scale", *(one.name for one in fields(Parameters) if one.name in reads - {"scale"}))

    def output(self) -> Output:
        """Return the output's core."""
        driver = self.driver
        device = Device.at(
            np.array(self.park),
            rate_hz=driver.rate_hz,
            on_silence=driver.on_silence,
            reports=driver.reports,
        )
        gates = (self.gate(), self.gate(travel=True))
        return Output(*gates, device, token=self.token, forbids=self.forbids)

    def changed(self) -> list[str]:
        """Return a sentence for every file that is no longer what was read at the start."""
        sentences = []
        for what, stored in self.stored.items():
            try:
                stored.found(what)
            except InputError as error:
                sentences.append(str(error))
        return sentences

    def to_record(self) -> dict[str, Any]:
        """Return the session as plain values."""
        return {
            "settings": self.settings.model_dump(mode="json", exclude_none=True),
            "platform": self.platform.model_dump(mode="json", exclude_none=True),
            "tuning": None if self.tuning is None else self.tuning.model_dump(mode="json", exclude_none=True),
            "axes": None if self.axes is None else self.axes.to_record(),
            "texts": dict(self.texts),
            "stored": {what: asdict(stored) for what, stored in self.stored.items()},
            "token": self.token,
            "forbids": self.forbids,
        }


def versions() -> dict[str, str]:
    """Return the versions of all that a decision's bits depend on."""
    made = {"otolith": version("otolith"), "python": machine.python_version(), "machine": machine.machine()}
    return made | {name: version(name) for name in LIBRARIES}


def session_from_record(record: Mapping[str, Any], source: str) -> Session:
    """Return the session of `Session.to_record`.

    Parameters
    ----------
    source : name of the log, for errors.

    Raises
    ------
    CorruptFile : the record is of another version, or damaged.
    """
    with damage_reported(f"{source} states no session of this version"):
        tuning, axes = record["tuning"], record["axes"]
        return Session(
            settings=Settings.model_validate_json(json.dumps(record["settings"])),
            platform=Platform.model_validate_json(json.dumps(record["platform"])),
            tuning=None if tuning is None else Tuning.model_validate_json(json.dumps(tuning)),
            axes=None if axes is None else axes_from(axes, source),
            texts={str(name): str(text) for name, text in record["texts"].items()},
            stored={what: StoredFile(**one) for what, one in record["stored"].items()},
            token=int(record["token"]),
            forbids=str(record["forbids"]),
        )


def session_of(
    settings: Settings, axes: AxisMap | None, *, source: str, named: Mapping[str, Path], token: int = 0
) -> Session:
    """Read all that settings name, and check it; nothing is opened before.

    Parameters
    ----------
    source : where the settings stand, for errors.
    named : files that settings and axis map are from, by what they are.

    Raises
    ------
    InputError, CorruptFile : a value or a file is refused.
    """
    platform = files.read_platform(settings.platform)
    check_machine(platform, "platform")
    platform = narrowed(platform, settings.limits, source)
    for dof in dofs_named(settings.dofs.split(",")):
        platform.limits(dof)
    if not registry.cueing_named(settings.cueing).live:
        bound = one_of(registry.LIVE, "", otherwise=": it decides in time, and leaves a base at rest")
        raise InputError(f"cueing in {source}", settings.cueing, bound)
    named = {**named, **_named(settings)}
    texts: dict[str, str] = {}

    def read(name: str) -> str:
        texts[name] = files.read_text(Path(name), "file of channels")
        return texts[name]

    source_named(settings.input.source, read)
    named |= {f"channels {name}": Path(name) for name in texts}
    session = Session(
        settings=settings,
        platform=platform,
        tuning=None if settings.tuning is None else files.read_tuning(settings.tuning),
        axes=axes,
        texts=texts,
        stored={what: StoredFile.of(path.resolve()) for what, path in named.items()},
        token=token,
    )
    session.design()
    session.driver.check_reach(session.sent)
    return session


def _named(settings: Settings) -> dict[str, Path]:
    """Return the user's own files, by what they are; what is shipped belongs to the version."""
    stated = {
        "platform": (settings.platform, catalog()),
        "tuning": (settings.tuning, tunings()),
        "laws": (settings.laws, ()),
        "hint": (settings.hint, ()),
    }
    named = {
        what: Path(name)
        for what, (name, shipped) in stated.items()
        if name is not None and name not in shipped
    }
    code = Path(settings.cueing.rpartition(":")[0])
    return {**named, "cueing": code} if code.suffix == ".py" else named


def _host_and_port(address: str) -> tuple[str, int]:
    found = urlsplit(f"//{address}")
    return found.hostname or "", found.port or 0  # both are there: the settings were checked
