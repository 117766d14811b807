"""Options that `run` and `compare` share, and how they become a design and a scenario."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from rich.console import Console

from otolith import files, registry
from otolith.cli.reading import (
    Axes,
    Columns,
    Events,
    Header,
    MappingFile,
    Offsets,
    Units,
    as_record,
    assignments,
    recorded_drive,
)
from otolith.core.errors import CorruptFile, InputError, one_of
from otolith.core.frames import DOFS, PAIRS, Dof, dofs_named, pairs_of
from otolith.cueing.design import Design
from otolith.cueing.hints.stored import Refused, StaleHint, StoredHint
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows, parse_braking_rows
from otolith.cueing.mpc.settings import BLOCKS, HORIZON, MpcSettings, parse_entry
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant, preset
from otolith.perception import sense
from otolith.platforms import Platform
from otolith.scenarios import Scenario, log_scenario, scenario
from otolith.scenarios.perceived import perceived

SOFTENED: Final = (
    "tilt_rate",
    "tilt",
    "velocity",
    "position",
    "acceleration",
    "tilt_acceleration",
    "braking_position",
    "braking_tilt",
    "circle",
)  # rows that may be given a slack; commands never

CUEING_HELP: Final = "A name of 'otolith list cueing', or your own: module:attribute, file.py:attribute."
PlatformName = Annotated[str, typer.Option(help="A shipped platform's name or a platform file (.toml).")]
Dofs = Annotated[str, typer.Option(help="Axis pairs to cue: " + ", ".join(PAIRS) + ", or both with a comma.")]
Horizon = Annotated[
    int | None, typer.Option(help="Steps of the implicit MPC (default: 50, or those of --blocks).")
]
Blocks = Annotated[
    str | None,
    typer.Option(
        metavar="STEPS,...",
        help="Hold the implicit MPC's inputs over blocks, e.g. " + ",".join(map(str, BLOCKS)) + ".",
    ),
]
Washout = Annotated[
    str, typer.Option(help="Washout weights of the implicit MPC: printed, thesis-fit or none.")
]
Weights = Annotated[
    list[str] | None,
    typer.Option(metavar="STATE=W", help="Constant washout weights instead, e.g. position=0.9; repeatable."),
]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What the user chose; every field is one option of the command line."""

    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="A name of 'otolith list scenarios', or a formula."),
    ] = None
    log: Annotated[
        Path | None, typer.Option(help="A recorded drive instead of a scenario: CSV, ERG, MDF, ROS bag, lap.")
    ] = None
    column: Columns = None
    header: Header = None
    units: Units = None
    axes: Axes = None
    events: Events = None
    offsets: Offsets = None
    mapping: MappingFile = None
    lowpass: Annotated[float | None, typer.Option(metavar="HZ", help="Low-pass a log at this frequency.")] = (
        None
    )
    causal: Annotated[
        bool, typer.Option("--causal", help="Filter a log causally, as live (default: zero-phase).")
    ] = False
    through: Annotated[
        str | None,
        typer.Option(
            metavar="ORGAN", help="Cue what this otolith passes on (otolith list perception), as eq. 6.4."
        ),
    ] = None
    scale: Annotated[float, typer.Option(help="Scale the reference by this factor.")] = 1.0
    literal: Annotated[
        bool, typer.Option("--literal", help="Steps from 1 s to 4 s as printed, instead of 1 s to 5 s.")
    ] = False
    platform: PlatformName = "thesis"
    plant: Annotated[
        str | None,
        typer.Option(help="A name of 'otolith list plants' (default: what the algorithm assumes)."),
    ] = None
    dofs: Annotated[str, typer.Option(help="What to cue, with commas: " + ", ".join(DOFS) + ".")] = (
        "surge-pitch"
    )
    solver: Annotated[str, typer.Option(help="QP engine of the implicit MPC: structured or dense.")] = (
        "structured"
    )
    horizon: Horizon = None
    blocks: Blocks = None
    preview: Annotated[
        bool, typer.Option("--preview", help="Tell the controller the future reference (default: held).")
    ] = False
    washout: Washout = "thesis-fit"
    weight: Weights = None
    braking: Annotated[
        str | None,
        typer.Option(
            help="Braking rows: stopping, leading, position (the thesis's), printed or none "
            "(default: implicit stopping, explicit none)."
        ),
    ] = None
    soft: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ROW=PENALTY",
            help="Soften rows of the implicit MPC with a slack (eq. 6.2), e.g. tilt_rate=100; repeatable.",
        ),
    ] = None
    guess_entry: Annotated[
        str, typer.Option(help="How a guess enters: reference (eq. 3.1), primal or working-set.")
    ] = "reference"
    hint: Annotated[
        Path | None, typer.Option(help="Offline knowledge for hybrid-learned, -law and -table.")
    ] = None
    law: Annotated[Path | None, typer.Option(help="A stored explicit law, instead of enumerating one.")] = (
        None
    )
    given: frozenset[str] = frozenset()  # names of all options that the user wrote, these and others

    def design(self) -> Design:
        """Turn the options into a design; every wrong value is refused before work starts."""
        rows = parse_braking_rows(self.braking) if self.braking is not None else None
        platform, dofs = files.read_platform(self.platform), dofs_named(self.dofs.split(","))
        for dof in dofs:
            platform.limits(dof)  # refuses what the platform does not have
        weights = washout_weights(self.washout, self.weight or [])
        settings = replace(
            implicit_settings(self.horizon, self.blocks, weights),
            braking=rows or BrakingRows.STOPPING,
            engine=registry.lookup(registry.SOLVERS, "--solver", self.solver).load(),
            soft=soft_rows(self.soft or []),
        )
        return Design(
            platform=platform,
            dofs=dofs,
            explicit=ExplicitSettings(braking=rows or BrakingRows.NONE),
            mpc=settings,
            entry=parse_entry(self.guess_entry),
            stored_laws=files.read_laws(self.law) if self.law is not None else (),
            hint=None if self.hint is None else hint_for(self.hint, platform, pairs_of(dofs), settings),
        )

    def reference(self, design: Design, console: Console) -> Scenario:
        """The scenario along the cued axes; a log is resampled to the implicit controller's period.

        That period whatever the algorithm, so that all are judged against one and the same reference.
        """
        if isinstance(design.hint, Refused):
            warn(console, f"hint refused, running without it: {design.hint.reason}")
        if self.log is None and self.scenario is not None:
            along = [scenario(self.scenario, literal=self.literal, axis=dof.along) for dof in design.dofs]
            return self._sensed(functools.reduce(Scenario.beside, along)).scaled(self.scale)
        if self.log is None or self.scenario is not None:
            found = "given twice" if self.log is not None else "absent"
            raise InputError("the reference", found, "either a scenario's name or --log FILE")
        log = recorded_drive(self.log, asdict(self))
        for note in log.notes:
            warn(console, note)
        period = design.mpc.period
        recorded = log_scenario(log, period=period, lowpass_hz=self.lowpass, causal=self.causal)
        return self._sensed(recorded).scaled(self.scale)

    def _sensed(self, reference: Scenario) -> Scenario:
        """The reference as the organ of `--through` passes it on, from rest under its first value."""
        if self.through is None:
            return reference
        otoliths = {k: e for k, e in registry.PERCEPTION.items() if k.startswith("otolith-")}
        name = self.through if self.through in otoliths else f"otolith-{self.through}"
        organ = registry.lookup(otoliths, "--through", name).load()()
        return perceived(reference, lambda f, dt: sense(organ, f, dt, before=f[0]), name=name)

    def as_settings(self, design: Design, cueing: str) -> dict[str, Any]:
        """Plain JSON values for the record of a run: enough to repeat it, and why a hint was refused.

        Options that this cueing algorithm does not read are left out.
        """
        ignored = {"given", *registry.unread(cueing)}
        chosen = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in asdict(self).items()
            if value is not None and name not in ignored
        }
        if self.log is not None:
            chosen["reading"] = as_record(chosen)
        return chosen | ({"hint_refused": design.hint.reason} if isinstance(design.hint, Refused) else {})


def takes_choices(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command every field of `Choices` as an option; it receives them as one value, first."""
    own = [p for p in inspect.signature(command).parameters.values() if p.name != "choices"]
    shared = [
        inspect.Parameter(f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=f.type)
        for f in fields(Choices)
        if f.name != "given"
    ]

    @functools.wraps(command)
    def with_options(*, context: typer.Context, **values: Any) -> None:
        given = frozenset(name for name in values if is_given(context, name))
        choices = Choices(**{p.name: values.pop(p.name) for p in shared}, given=given)
        command(choices, **values)

    context = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    parameters = [context, *shared, *(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in own)]
    with_options.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    with_options.__annotations__ = {p.name: p.annotation for p in parameters}
    return with_options


def is_given(context: typer.Context, name: str) -> bool:
    """Whether the user wrote the option of this name; its value may be the default's all the same."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def warn(console: Console, note: str) -> None:
    """Tell what the user should know and need not act on."""
    console.print(f"note: {note}", style="yellow", markup=False, highlight=False, soft_wrap=True)


def hint_for(
    path: Path, platform: Platform, pairs: tuple[Dof, ...], settings: MpcSettings
) -> StoredHint | Refused:
    """A stored hint, or why it cannot be used: without one the answers are the same, only later."""
    try:
        hint = files.read_hint(path)
        hint.check(platform, pairs, settings)
    except (CorruptFile, StaleHint) as error:
        return Refused(str(error))
    return hint


def implicit_settings(
    horizon: int | None, blocks: str | None, washout: tuple[WashoutWeight, ...]
) -> MpcSettings:
    """Settings from the texts of the options."""
    lengths = block_lengths(blocks) if blocks is not None else ()
    steps = horizon if horizon is not None else sum(lengths) or HORIZON
    return MpcSettings(horizon=steps, blocks=lengths, washout=washout)


def pairs_named(dofs: str) -> tuple[Dof, ...]:
    """The axis pairs of `--dofs`, in the order of their axes, whatever the order of the words."""
    return dofs_named(dofs.split(","), PAIRS)


def block_lengths(text: str) -> tuple[int, ...]:
    """The numbers of steps of `--blocks`."""
    lengths = text.split(",")
    if not all(length.strip().isdecimal() for length in lengths):
        raise InputError("--blocks", repr(text), "numbers of steps with commas, as in 1,1,2,7,12")
    return tuple(map(int, lengths))


def washout_weights(name: str, weights: list[str]) -> tuple[WashoutWeight, ...]:
    """The preset `name`, or the constant weights "state=value" where any are given."""
    if not weights:
        return preset(name)
    return constant(_numbers("--weight", weights))


def soft_rows(texts: list[str]) -> dict[str, float]:
    """Penalties by row name from "row=penalty"."""
    penalties = _numbers("--soft", texts)
    for name in penalties:
        if name not in SOFTENED:
            raise InputError("--soft", repr(name), one_of(SOFTENED, name))
    return penalties


def _numbers(option: str, texts: list[str]) -> dict[str, float]:
    """Numbers by name from "name=number"."""
    values: dict[str, float] = {}
    for name, value in assignments(option, texts).items():
        try:
            values[name] = float(value)
        except ValueError:
            raise InputError(f"{option} {name}", repr(value), "a number") from None
    return values
