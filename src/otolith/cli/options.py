"""Options that `run` and `compare` share, and how they become a design and a scenario."""

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from otolith import files, registry
from otolith.cli.reading import (
    Axes,
    Columns,
    Events,
    Header,
    MappingFile,
    Offsets,
    Units,
    assignments,
    log_settings,
)
from otolith.core.errors import InputError, one_of
from otolith.core.frames import DOFS, PAIRS, Dof, dofs_named, pairs_of
from otolith.cueing.design import Design
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows, parse_braking_rows
from otolith.cueing.mpc.settings import BLOCKS, HORIZON, MpcSettings, parse_entry
from otolith.cueing.mpc.six_axis import parse_generator
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant, preset
from otolith.cueing.prediction import Prediction, Road, parse_prediction
from otolith.cueing.washout.tuning import Corners
from otolith.experiment import Experiment, Wanted, hint_for
from otolith.recordings.settings import PLAIN

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
)  # constraints that may be softened; commands never

# Fields of `RunOptions` that describe an algorithm which runs without Python, and what it moves.
DESIGN: Final = (
    "platform",
    "plant",
    "dofs",
    "solver",
    "period",
    "horizon",
    "blocks",
    "control_weight",
    "prediction",
    "liveliness",
    "high_pass",
    "low_pass",
    "washout",
    "weight",
    "braking",
    "soft",
)

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
class RunOptions:
    """The user's choices; every field is one option of the command line."""

    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="A name of 'otolith list scenarios', or a formula."),
    ] = None
    log: Annotated[
        Path | None, typer.Option(help="A recorded drive instead of a scenario: CSV, ERG, MDF, ROS bag, lap.")
    ] = None
    road: Annotated[
        Path | None,
        typer.Option(help="An earlier drive of the log's road: its forces are foreseen (--prediction road)."),
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
    solver: Annotated[
        str, typer.Option(help="QP engine of the implicit MPC: structured, dense or blocked.")
    ] = "structured"
    period: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Time between two decisions of an MPC [s] (0.01).")
    ] = None
    horizon: Horizon = None
    blocks: Blocks = None
    control_weight: Annotated[
        float | None, typer.Option(help="Weight R of the implicit MPC's commands (default: 0.001).")
    ] = None
    prediction: Annotated[
        str | None,
        typer.Option(
            metavar="NAME:PARAMETER=VALUE,...",
            help="What an MPC assumes of the future: hold, decay, adaptive, road or oracle "
            "(default: predictive adaptive, all others hold; with --road, road).",
        ),
    ] = None
    liveliness: Annotated[
        float, typer.Option(help="Of predictive, 0 to 1: how much travel it spends on what is felt.")
    ] = 0.5
    second_blocks: Annotated[
        str | None,
        typer.Option(
            metavar="STEPS,...",
            help="Of lnl and nll: steps of each block of the second QP, as in 1,1,2,7,12 (default: as the "
            "first).",
        ),
    ] = None
    generator: Annotated[
        str,
        typer.Option(
            help="Of six-axis-nmpc: references as wanted (plain), or as perceived, with all other states at "
            "zero (khusro)."
        ),
    ] = "plain"
    high_pass: Annotated[
        float, typer.Option(help="Of classical: factor of the high-passes' corner frequencies, 0.5 to 2.")
    ] = 1.0
    low_pass: Annotated[
        float, typer.Option(help="Of classical: factor of the tilt's corner frequency, 0.5 to 2.")
    ] = 1.0
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
    given: frozenset[str] = frozenset()  # names of all options that the user gave, these and others

    def design(self) -> Design:
        """Turn the options into a design; every invalid value is refused before work starts."""
        rows = parse_braking_rows(self.braking) if self.braking is not None else None
        platform, dofs = files.read_platform(self.platform), dofs_named(self.dofs.split(","))
        for dof in dofs:
            platform.limits(dof)  # refuses a degree of freedom that the platform lacks
        weights = washout_weights(self.washout, self.weight or [])
        settings = replace(
            implicit_settings(self.horizon, self.blocks, weights),
            braking=rows or BrakingRows.STOPPING,
            engine=registry.lookup(registry.SOLVERS, "--solver", self.solver).load(),
            soft=soft_rows(self.soft or []),
            prediction=self._prediction(),
            **self._plain(),
        )
        return Design(
            platform=platform,
            dofs=dofs,
            explicit=ExplicitSettings(braking=rows or BrakingRows.NONE),
            mpc=settings,
            liveliness=self.liveliness,
            corners=Corners(high_pass=self.high_pass, low_pass=self.low_pass),
            second_blocks=()
            if self.second_blocks is None
            else block_lengths(self.second_blocks, "--second-blocks"),
            generator=parse_generator(self.generator),
            entry=parse_entry(self.guess_entry),
            stored_laws=files.read_laws(self.law) if self.law is not None else (),
            hint=None if self.hint is None else hint_for(self.hint, platform, pairs_of(dofs), settings),
        )

    def _plain(self) -> dict[str, Any]:
        """Return the settings of the MPC that are plain numbers, as far as they are given."""
        given = {"period": self.period, "control_weight": self.control_weight}
        return {name: value for name, value in given.items() if value is not None}

    def _prediction(self) -> Prediction | None:
        """Return the named prediction; without a name, `Road` if an earlier drive is given."""
        if self.prediction is not None:
            return parse_prediction(self.prediction)
        return Road() if self.road is not None else None

    def as_typed(self) -> list[tuple[str, ...]]:
        """Return the options that differ from their defaults, as they are typed, each with its value."""
        typed: list[tuple[str, ...]] = []
        for one in fields(self):
            value, option = getattr(self, one.name), f"--{one.name.replace('_', '-')}"
            if one.name in ("scenario", "given") or value == one.default:
                continue
            if value is True:
                typed.append((option,))
            else:
                typed += [(option, str(item)) for item in (value if isinstance(value, list) else [value])]
        return typed

    def wanted(self) -> Wanted:
        """Return the description of what should be felt."""
        chosen = asdict(self)
        return Wanted(
            scenario=self.scenario,
            log=self.log,
            road=self.road,
            reading=PLAIN if self.log is None else log_settings(chosen),
            lowpass_hz=self.lowpass,
            causal=self.causal,
            literal=self.literal,
            through=self.through,
            scale=self.scale,
        )

    def experiment(self, cueing: str, design: Design) -> Experiment:
        """Return the closed loop of one algorithm, for a design made of these options."""
        return Experiment(
            wanted=self.wanted(),
            design=design,
            cueing=cueing,
            plant=self.plant,
            law=self.law,
            hint=self.hint,
        )


def with_run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command every field of `RunOptions` as an option; it receives them as its first argument."""
    return _with_options(command, [f.name for f in fields(RunOptions) if f.name != "given"])


def with_design_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the fields of `RunOptions` that say how something is cued, without what is wanted."""
    return _with_options(command, DESIGN)


def _with_options(command: Callable[..., None], names: Sequence[str]) -> Callable[..., None]:
    """Give a command the named fields of `RunOptions` as options; it receives them as its first argument."""
    own = [p for p in inspect.signature(command).parameters.values() if p.name != "choices"]
    shared = [
        inspect.Parameter(f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=f.type)
        for f in fields(RunOptions)
        if f.name in names
    ]

    @functools.wraps(command)
    def with_options(*, context: typer.Context, **values: Any) -> None:
        given = frozenset(name for name in values if is_given(context, name))
        choices = RunOptions(**{p.name: values.pop(p.name) for p in shared}, given=given)
        command(choices, **values)

    context = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    parameters = [context, *shared, *(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in own)]
    with_options.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    with_options.__annotations__ = {p.name: p.annotation for p in parameters}
    return with_options


def is_given(context: typer.Context, name: str) -> bool:
    """Return whether the user gave the option of this name, even if with its default value."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def implicit_settings(
    horizon: int | None, blocks: str | None, washout: tuple[WashoutWeight, ...]
) -> MpcSettings:
    """Make settings from the texts of the options."""
    lengths = block_lengths(blocks) if blocks is not None else ()
    steps = horizon if horizon is not None else sum(lengths) or HORIZON
    return MpcSettings(horizon=steps, blocks=lengths, washout=washout)


def pairs_named(dofs: str) -> tuple[Dof, ...]:
    """Return the axis pairs of `--dofs` in the order of their axes."""
    return dofs_named(dofs.split(","), PAIRS)


def block_lengths(text: str, option: str = "--blocks") -> tuple[int, ...]:
    """Parse the numbers of steps of an option such as `--blocks`."""
    lengths = text.split(",")
    if not all(length.strip().isdecimal() for length in lengths):
        raise InputError(option, repr(text), "numbers of steps with commas, as in 1,1,2,7,12")
    return tuple(map(int, lengths))


def washout_weights(name: str, weights: list[str]) -> tuple[WashoutWeight, ...]:
    """Return the preset `name`, or constant weights from "state=value" if any are given."""
    if not weights:
        return preset(name)
    return constant(_numbers("--weight", weights))


def soft_rows(texts: list[str]) -> dict[str, float]:
    """Return penalties by row name from "row=penalty"."""
    penalties = _numbers("--soft", texts)
    for name in penalties:
        if name not in SOFTENED:
            raise InputError("--soft", repr(name), one_of(SOFTENED, name))
    return penalties


def _numbers(option: str, texts: list[str]) -> dict[str, float]:
    """Return numbers by name from "name=number"."""
    values: dict[str, float] = {}
    for name, value in assignments(option, texts).items():
        try:
            values[name] = float(value)
        except ValueError:
            raise InputError(f"{option} {name}", repr(value), "a number") from None
    return values
