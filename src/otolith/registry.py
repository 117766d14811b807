"""The registry: one line per algorithm, plant, solver and format, with its name and where it is made.

Options of the command line, tables in the documentation, legends and conformance tests all read it. Entries
are imported on use, so an optional dependency costs nothing when it is absent. Installed packages add entries
of their own by entry points; see CONTRIBUTING.md.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from otolith.core import plugins
from otolith.core.errors import InputError, MissingExtra, one_of

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from otolith.cueing.design import Design
    from otolith.interfaces import Cueing, Plant
    from otolith.platforms import Platform


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of the registry: where an object is made, one line of description, and what it needs."""

    target: str  # "module:attribute"
    description: str
    extra: str = ""  # optional dependency group (extra) that it needs
    needs: tuple[str, ...] = ()  # modules of that extra
    plant: str = "ideal"  # cueing algorithms only: entry of PLANTS that the algorithm's model describes
    limited: bool = True  # cueing algorithms only: whether it knows and keeps the platform's limits
    live: bool = True  # cueing algorithms only: whether it decides in time and leaves the base at rest
    alone: bool = True  # cueing algorithms only: whether kernels decide without Python, as a program must
    reads: frozenset[str] = frozenset()  # cueing algorithms only: the options below that it reads
    outside: bool = False  # whether it comes from outside this package
    declared: "EntryPoint | None" = None  # the entry point by which an installed package declares it

    def load(self) -> Any:
        """Import and return the target.

        Raises
        ------
        MissingExtra : a declared optional dependency is not installed; other import errors are not caught.
        BrokenPlugin, InputError : an entry from outside this package cannot be imported.
        """
        if self.declared is not None:
            return plugins.load_entry_point(self.declared)
        if self.outside:
            return plugins.load_target("--cueing", self.target)
        module, attribute = self.target.split(":")
        try:
            return getattr(import_module(module), attribute)
        except ModuleNotFoundError as error:
            if error.name in self.needs:
                hint = f"pip install 'otolith[{self.extra}]'"
                raise MissingExtra(
                    f"{attribute} needs {error.name}, which is not installed: {hint}"
                ) from error
            raise


class Table(Mapping[str, Entry]):
    """Entries by name: Otolith's own, then those that installed packages declare in an entry-point group.

    Otolith's own names take precedence. Installed packages are searched only when a name is not Otolith's
    own, or when all names are listed.
    """

    def __init__(self, group: str, own: Mapping[str, Entry]) -> None:
        self.group, self.own = group, own

    def __getitem__(self, name: str) -> Entry:
        return self.own[name] if name in self.own else self._declared()[name]

    def __iter__(self) -> Iterator[str]:
        return iter({**self.own, **self._declared()})

    def __len__(self) -> int:
        return len({**self.own, **self._declared()})

    def shadowed(self) -> dict[str, str]:
        """Return Otolith's own names that other distributions declare, too, each with that distribution."""
        found = plugins.declared(self.group)
        return {name: plugins.distribution(found[name]) for name in self.own if name in found}

    def _declared(self) -> dict[str, Entry]:
        found = plugins.declared(self.group)
        return {
            name: Entry(one.value, f"from {plugins.distribution(one)}", outside=True, declared=one)
            for name, one in found.items()
        }


# Options of the command line that only some cueing algorithms read. All other options concern the reference,
# the platform or the results, and apply to every algorithm.
_LAW: Final = frozenset({"braking", "law"})
_SENSED: Final = frozenset(
    {
        "solver",
        "period",
        "horizon",
        "blocks",
        "control_weight",
        "prediction",
        "road",
        "washout",
        "weight",
        "braking",
    }
)
_PREDICTIVE: Final = frozenset({"solver", "period", "prediction", "road", "liveliness", "braking", "soft"})
_IN_TURN: Final = _PREDICTIVE | {"second_blocks"}
_SIX_AXIS: Final = frozenset({"prediction", "road", "liveliness", "braking"})
_NONLINEAR: Final = _SIX_AXIS | {"generator"}
_LINEAR: Final = _SENSED - {
    "washout",
    "weight",
    "braking",
}  # it has its own washout and terminal rows instead
_IMPLICIT: Final = _SENSED | {"soft"}
_GUESSING: Final = _IMPLICIT | {"guess_entry"}
_HYBRID: Final = _GUESSING | {"law"}
_HINTED: Final = _IMPLICIT | {"hint"}
_WASHOUT: Final = frozenset({"tuning"})
_CLASSICAL: Final = _WASHOUT | {"high_pass", "low_pass"}

# Cueing algorithms: callables Design -> Cueing.
CUEING: Final = Table(
    "otolith.cueing",
    {
        "predictive": Entry(
            "otolith.cueing.design:predictive",
            "implicit MPC that foresees: 1.5 s in blocks, learning prediction; the default",
            reads=_PREDICTIVE,
        ),
        "explicit": Entry(
            "otolith.cueing.design:explicit",
            "the explicit law alone, 10 Hz (section 5.2.1)",
            plant="ideal-no-lag",
            alone=False,
            reads=_LAW,
        ),
        "implicit": Entry(
            "otolith.cueing.design:implicit",
            "implicit MPC without a guess (model 1)",
            reads=_IMPLICIT,
        ),
        "implicit-trajectory": Entry(
            "otolith.cueing.design:implicit_trajectory",
            "guess: first control of the previous plan (model 2)",
            alone=False,
            reads=_GUESSING,
        ),
        "hybrid-first": Entry(
            "otolith.cueing.design:hybrid_first",
            "guess: first input of the explicit law (model 3)",
            alone=False,
            reads=_HYBRID,
        ),
        "hybrid-all": Entry(
            "otolith.cueing.design:hybrid_all",
            "guess: all inputs of the explicit law (model 4)",
            alone=False,
            reads=_HYBRID,
        ),
        "hybrid-learned": Entry(
            "otolith.cueing.design:hybrid_learned",
            "as implicit, sooner: a network names the active limits",
            alone=False,
            reads=_HINTED,
        ),
        "hybrid-law": Entry(
            "otolith.cueing.design:hybrid_law",
            "as implicit: a coarse explicit law of the same limits names them",
            alone=False,
            reads=_HINTED,
        ),
        "hybrid-table": Entry(
            "otolith.cueing.design:hybrid_table",
            "as implicit: what was active near by in training",
            alone=False,
            reads=_HINTED,
        ),
        "implicit-sensed": Entry(
            "otolith.cueing.design:implicit_sensed",
            "implicit MPC of sensed force and rate (thesis, chapter 8)",
            reads=_SENSED,
        ),
        "linear-mpc": Entry(
            "otolith.cueing.design:linear_mpc",
            "linear MPC with perception, decoupled (Beghi; Garrett & Best)",
            reads=_LINEAR,
        ),
        "joint": Entry(
            "otolith.cueing.carriers:joint",
            "predictive, moving the platform and the base that carries it in one QP",
            live=False,
            reads=_PREDICTIVE,
        ),
        "lnl": Entry(
            "otolith.cueing.carriers:lnl",
            "base first, then the platform for what it leaves: two QPs (Soyer)",
            live=False,
            reads=_IN_TURN,
        ),
        "nll": Entry(
            "otolith.cueing.carriers:nll",
            "platform first, then its base for what it leaves: two QPs (Soyer)",
            live=False,
            reads=_IN_TURN,
        ),
        "split": Entry(
            "otolith.cueing.carriers:split",
            "one QP, and a fixed 2 Hz split between platform and base (Bruschetta)",
            live=False,
            reads=_PREDICTIVE,
        ),
        "six-axis": Entry(
            "otolith.cueing.design:six_axis",
            "one MPC over all axes of a hexapod, with its legs' limits as rows",
            reads=_SIX_AXIS,
        ),
        "six-axis-nmpc": Entry(
            "otolith.cueing.design:six_axis_nmpc",
            "the same solved to the end by IPOPT: a reference, 0.1 s and more per decision",
            live=False,
            extra="check",
            needs=("casadi",),
            alone=False,
            reads=_NONLINEAR,
        ),
        "classical": Entry(
            "otolith.cueing.washout.classical:classical",
            "washout: high-pass travel, low-pass tilt (section 2.2.1)",
            limited=False,
            reads=_CLASSICAL,
        ),
        "optimal": Entry(
            "otolith.cueing.washout.optimal:optimal",
            "washout: LQ filter with a vestibular model (section 2.2.2)",
            limited=False,
            reads=_WASHOUT,
        ),
        "optimal-nonlinear": Entry(
            "otolith.cueing.washout.optimal:optimal_nonlinear",
            "the same, faster the farther the platform is (Telban & Cardullo)",
            limited=False,
            reads=_WASHOUT,
        ),
        "adaptive": Entry(
            "otolith.cueing.washout.adaptive:adaptive",
            "washout: gains that descend a cost (section 2.2.3)",
            limited=False,
            reads=_WASHOUT,
        ),
    },
)

LIVE: Final = tuple(name for name, entry in CUEING.own.items() if entry.live)  # those of live sessions

_OUTSIDE: Final = Entry("otolith.cueing.outside:make_outside", "makes and watches algorithms of others")
_ON_BASE: Final = Entry("otolith.plant.carried:OnBase", "a plant carried by a base")
_AHEAD: Final = Entry("otolith.cueing.ahead:Ahead", "decides for the moment at which a command takes effect")

COMPARED: Final = ("predictive", "implicit", "linear-mpc")  # what `compare` compares unless others are named

# The four controllers of the thesis, which differ only in their guess (section 3.1).
FOUR_MODELS: Final = ("implicit", "implicit-trajectory", "hybrid-first", "hybrid-all")

# Plants: callables Platform -> Plant.
PLANTS: Final = Table(
    "otolith.plants",
    {
        "ideal": Entry("otolith.plant.ideal:ideal", "accelerations follow with the lag of eq. 4.9, 10 ms"),
        "ideal-no-lag": Entry("otolith.plant.ideal:without_lag", "accelerations follow at once (eq. 4.1)"),
        "actuator": Entry(
            "otolith.plant.actuator:actuator", "as ideal, after the dead time of the platform's file"
        ),
        "hexapod": Entry(
            "otolith.plant.hexapod:hexapod", "rigid body on six legs with servos, supervised (chapter 6)"
        ),
        "hexapod-mujoco": Entry(
            "otolith.plant.mujoco:hexapod_mujoco",
            "the same machine in MuJoCo, to check the other",
            extra="emulator",
            needs=("mujoco",),
        ),
    },
)

# QP engines: callables (StageProblem, tolerance=…, blocks=…) -> StageEngine.
SOLVERS: Final = {
    "structured": Entry("otolith.qp.engines:StructuredEngine", "stage by stage, compiled; the fast path"),
    "dense": Entry(
        "otolith.qp.engines:CondensedEngine", "condensed, dual active set (daqp); the thesis's kind"
    ),
    "blocked": Entry(
        "otolith.qp.blocked_engine:BlockedEngine",
        "condensed, compiled, with soft rows as bounds on multipliers: few blocks, many rows",
    ),
    "casadi-hpipm": Entry(
        "otolith.qp.casadi:HpipmEngine",
        "HPIPM, built anew for every problem: to check answers, hard rows only",
        extra="check",
        needs=("casadi",),
    ),
    "casadi-qpoases": Entry(
        "otolith.qp.casadi:QpOasesEngine",
        "qpOASES, built anew for every problem: to check answers, hard rows only",
        extra="check",
        needs=("casadi",),
    ),
}

# Perception models: callables () -> StateSpace, each for one organ and one axis.
PERCEPTION: Final = {
    "otolith-telban": Entry("otolith.perception.otoliths:telban", "specific force; the thesis's (eq. 6.4)"),
    "otolith-young": Entry("otolith.perception.otoliths:young", "specific force; Young & Meiry (Table B.3)"),
    "otolith-ormsby": Entry("otolith.perception.otoliths:ormsby", "specific force; Ormsby (Table B.3)"),
    "otolith-thresholds": Entry(
        "otolith.perception.otoliths:from_thresholds", "specific force; fitted to thresholds (Soyka 2011)"
    ),
    "canals-telban": Entry("otolith.perception.canals:telban", "angular rate; Telban (Table B.1)"),
    "canals-reid": Entry("otolith.perception.canals:reid", "angular rate; Reid & Nahon (Table B.1)"),
    "canals-young": Entry("otolith.perception.canals:young", "angular rate; Young & Oman (Table B.1)"),
    "canals-ormsby": Entry("otolith.perception.canals:ormsby", "angular rate; Ormsby (Table B.1)"),
    "canals-thresholds": Entry(
        "otolith.perception.canals:from_thresholds", "angular rate; fitted to thresholds (Soyka 2012)"
    ),
}

# Formats of recorded drives that need a library: callables that return `scenarios.recorded.Channels`.
LOG_FORMATS: Final = Table(
    "otolith.formats",
    {
        "mdf": Entry("otolith.recordings.mdf:read_mdf", "ASAM MDF 3 and 4", extra="logs", needs=("asammdf",)),
        "rosbag": Entry(
            "otolith.recordings.rosbag:read_rosbag",
            "ROS 1 and 2, bags and MCAP",
            extra="logs",
            needs=("rosbags",),
        ),
    },
)


# What a library writes: callables that take a path and tables of `recordings.recorded.Signal` by name.
WRITERS: Final = {
    "mdf": Entry("otolith.recordings.mdf:write_mdf", "ASAM MDF 4", extra="logs", needs=("asammdf",)),
}


def check_options(names: Sequence[str], given: Iterable[str]) -> None:
    """Refuse an option that was given but that none of the cueing algorithms `names` reads.

    Raises
    ------
    InputError : there is such an option; the message lists the algorithms that read it.
    """
    read = frozenset().union(*(cueing_named(name).reads for name in names))
    for option in given:
        readers = [name for name, entry in CUEING.own.items() if option in entry.reads]
        if readers and option not in read:
            word = f"--{option.replace('_', '-')}"
            bound = f"left out, or used with one of {', '.join(readers)}"
            raise InputError(word, f"given, but {' and '.join(names)} would ignore it", bound)


def unread(name: str) -> frozenset[str]:
    """Return the options that `name` does not read but others do; they are left out of its record."""
    every = frozenset().union(*(entry.reads for entry in CUEING.own.values()))
    return every - cueing_named(name).reads


def cueing_named(name: str) -> Entry:
    """Find a cueing algorithm by its name or by "module:attribute"; one from outside is imported.

    An algorithm from outside states the options it reads, its plant, and whether it keeps limits in
    attributes of its maker; see `otolith.cueing.outside`.

    Raises
    ------
    OtolithError : the algorithm does not exist or cannot be imported.
    """
    found = Entry(name, name, outside=True) if ":" in name else None
    entry = found or lookup(CUEING, "--cueing", name, otherwise=", or " + plugins.IN_WORDS)
    if not entry.outside:
        return entry
    maker = entry.load()
    if not callable(maker):
        raise InputError(
            "--cueing", repr(name), f"a class or function, not a value of {type(maker).__name__}"
        )
    return replace(
        entry,
        plant=str(getattr(maker, "plant", "ideal")),
        limited=getattr(maker, "limited", False) is True,
        reads=frozenset(getattr(maker, "reads", ())),
    )


def make_cueing(name: str, design: "Design", *, dead_time: float | None = None) -> "Cueing":
    """Make the cueing algorithm `name` for a design; raises as `cueing_named` and the algorithm itself do.

    Parameters
    ----------
    dead_time : [s] the `dead_time` of the plant that will be moved (`otolith.interfaces.Plant`). With None
        the plant moves exactly as the algorithm's model; otherwise the measured state passes through an
        observer and a predictor, see `otolith.cueing.ahead`.
    """
    entry = cueing_named(name)
    if entry.outside:
        cueing: Cueing = _OUTSIDE.load()(entry.load(), design, name=name)
    else:
        cueing = entry.load()(design)
    if dead_time is not None and entry.limited:
        lag, base = design.mpc.lag_on(design.platform), design.platform.base
        below = 0.0 if base is None else base.lag_s
        cueing = _AHEAD.load()(cueing, lag=lag, dead_time=dead_time, base_lag=below)
    return cueing


def make_plant(name: str, platform: "Platform") -> "Plant":
    """Make the plant `name` for a platform, and the base below it, if there is one.

    It raises as `lookup` and the plant itself do.
    """
    plant: Plant = lookup(PLANTS, "--plant", name).load()(platform)
    if platform.base is None:
        return plant
    carried: Plant = _ON_BASE.load()(plant, platform)
    return carried


def lookup(table: Mapping[str, Entry], kind: str, name: str, *, otherwise: str = "") -> Entry:
    """Find entry `name` of one of the tables above.

    Raises
    ------
    InputError : there is no such entry; the message lists those that exist.
    """
    if name not in table:
        raise InputError(kind, repr(name), one_of(table, name, otherwise=otherwise))
    return table[name]
