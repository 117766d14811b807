"""Programs of algorithms: what goes in and out, and the kernels behind it, translated to C."""

from collections.abc import Sequence
from enum import StrEnum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith import registry
from otolith.compiled import offered
from otolith.core.errors import InputError
from otolith.core.methods import Bound
from otolith.cueing.design import Design, mpcs_of
from otolith.export.header import Part, header
from otolith.export.program import MOTION, Port, Program, check_name, per_axis
from otolith.export.step import Decision, Moved, decide_once, move_once
from otolith.export.translate.render import Rendered
from otolith.export.translate.unit import translated
from otolith.export.translate.values import NotTranslated
from otolith.interfaces import Cueing, Plant, PlatformState
from otolith.loop.closed import Loop
from otolith.loop.run import steps_of_period

PLANT_PERIOD: Final = 1e-3  # [s]
STATUS: Final = (
    "the status: 0 decided by the algorithm; else the fallback, which brakes: 1 without a certified answer, "
    "2 because the platform could not have stopped after it, 3 because an input is not plausible"
)


class Kind(StrEnum):
    """What a program does in one step."""

    COMMAND = "command"  # decides accelerations from what is wanted and where the platform is
    PLATFORM = "platform"  # moves as a platform would: the algorithm and the plant, in a closed loop


def program_of(design: Design, cueing: str, name: str, kind: Kind, *, plant: str | None = None) -> Program:
    """Return an algorithm as a program.

    Parameters
    ----------
    cueing, plant : names in the registry; by default, the plant that the algorithm's model describes.
    name : of the program in C.

    Raises
    ------
    InputError : the name is no C identifier, the algorithm or the plant needs Python, or a period is no whole
        number of steps of the plant.
    """
    check_name(name)
    entry = registry.cueing_named(cueing)
    if not entry.alone:
        bound = "one that decides without Python, such as predictive, implicit or classical"
        raise InputError("--cueing", repr(cueing), bound)
    plant = plant or entry.plant
    moves = registry.make_plant(plant, design.platform)
    _refuse(design)
    algorithm = registry.make_cueing(cueing, design, dead_time=moves.dead_time)
    for mpc in mpcs_of(algorithm):
        mpc.unaided()
    what = f"{cueing} for {', '.join(dof.name for dof in design.dofs)} of platform {design.platform.name}"
    if kind is Kind.COMMAND:
        return _command(algorithm, name, f"motion cueing, {what}")
    return _platform(
        algorithm, moves, name, f"motion cueing, {what}, on plant {plant}", sensed=_senses(moves)
    )


def _refuse(design: Design) -> None:
    """Refuse what a program has no input or no output for."""
    if design.preview:
        raise InputError(
            "--prediction", "one that knows the future", "one that foresees: hold, decay, adaptive"
        )
    if any(dof.is_base for dof in design.dofs) or design.platform.base is not None:
        raise InputError(
            "the platform", f"{design.platform.name}, on a base that moves", "one without a base"
        )


def _command(algorithm: Cueing, name: str, title: str) -> Program:
    """Return a program that decides."""
    algorithm.reset(PlatformState())
    method = _method(algorithm, "the algorithm")
    decision = decision_of(method)
    about = (
        "A step decides the accelerations that the platform should have during the coming period, from what "
        "the driver should feel and from where the platform is."
    )
    command = per_axis("command", "/s2", "acceleration of {} during the period")
    return _program(
        (decide_once, decision),
        (name, title, about, algorithm.period),
        [(_WANTED, (decision.wanted, 0, 6)), *zip(MOTION, _rows(decision.measured), strict=True)],
        [(command, (decision.command, 0, 6)), *_outcome(decision.result)],
    )


def decision_of(algorithm: Bound) -> Decision:
    """Return what the kernel of one decision takes; the algorithm's method must be kept alive."""
    return Decision(
        algorithm.method,
        wanted=np.zeros(6),
        measured=np.zeros((3, 6)),
        preview=np.zeros((0, 3)),
        command=np.zeros(6),
        result=np.zeros(5),
    )


def _platform(algorithm: Cueing, plant: Plant, name: str, title: str, *, sensed: bool) -> Program:
    """Return a program that moves as a platform."""
    decide, follow = _method(algorithm, "the algorithm"), _method(plant, "the plant", PLANT_PERIOD)
    algorithm.reset(PlatformState())
    plant.reset(PlatformState())
    every = steps_of_period(algorithm.period, PLANT_PERIOD)
    result = np.zeros((1, 5))
    loop = Loop(
        decide=decide.method,
        follow=follow.method,
        every=every,
        known=0,
        now=np.zeros((1, 6)),
        forces=np.zeros((1, 3)),
        state=np.zeros((3, 6)),
        command=np.zeros((1, 6)),
        result=result,
        seconds=np.zeros(1),
        motion=np.zeros((every, 3, 6)),
        force=np.zeros((every, 3)),
        clock=0,
        clock_of=0,
        read=np.zeros(2, dtype=np.int64),
    )
    moved = Moved(loop, sensed, np.zeros(3), result[0])
    about = (
        "A step moves the platform by one period, as its model says, so that the driver feels what is wanted "
        "as well as the platform can give it. The outputs are at the period's end."
    )
    felt = tuple(
        Port(f"felt_force_{axis}", "m/s2", f"specific force along {axis} that the driver feels")
        for axis in "xyz"
    )
    return _program(
        (move_once, moved),
        (name, title, about, algorithm.period),
        [(_WANTED, (loop.now, 0, 6))],
        [*zip(MOTION, _rows(loop.state), strict=True), (felt, (moved.force, 0, 3)), *_outcome(result)],
    )


def _program(
    entry: tuple[Any, Any],
    words: tuple[str, str, str, float],
    read: Sequence[tuple[tuple[Port, ...], Part]],
    write: Sequence[tuple[tuple[Port, ...], Part]],
) -> Program:
    (kernel, values), (name, title, about, period) = entry, words
    try:
        unit, function = translated(kernel.py_func, values)
    except NotTranslated as error:
        raise InputError(
            "what is exported", str(error), "an algorithm whose kernels can be said in C"
        ) from error
    kept = [part[0] for _, part in (*read, *write)]
    text = header(
        Rendered(unit, function, name, kept),
        title,
        about,
        returns=STATUS,
        period=period,
        inputs=[ports for ports, _ in read],
        outputs=[ports for ports, _ in write],
        read=[part for _, part in read],
        write=[part for _, part in write],
    )
    return Program(
        name=name,
        period=period,
        inputs=tuple(port for ports, _ in read for port in ports),
        outputs=tuple(port for ports, _ in write for port in ports),
        header=text,
    )


def _method(party: Any, what: str, *step: float) -> Bound:
    """Return the method of an algorithm or a plant.

    Raises
    ------
    InputError : it has none, since some part of it runs in Python.
    """
    bound = offered(party, *step)
    if bound is None:
        raise InputError(f"what {what} is made of", type(party).__name__, "kernels in all its parts")
    return bound


def _senses(plant: Plant) -> bool:
    """Return whether a plant senses the force."""
    follow, motion, force = offered(plant, PLANT_PERIOD), np.zeros((1, 3, 6)), np.zeros((1, 3))
    if follow is None:
        return False
    from otolith.loop.closed import follow_once

    follow_once(follow.method, np.zeros(6), motion, force)
    return bool(np.isfinite(force).all())


def _rows(motion: NDArray[np.float64]) -> list[Part]:
    return [(motion, 6 * row, 6 * row + 6) for row in range(3)]


_WANTED: Final = (
    *(
        Port(f"wanted_force_{axis}", "m/s2", f"specific force wanted along {axis}, without the standing 1 g")
        for axis in "xyz"
    ),
    *(Port(f"wanted_rate_{axis}", "rad/s", f"angular rate wanted about {axis}") for axis in "xyz"),
)


def _outcome(result: NDArray[np.float64]) -> list[tuple[tuple[Port, ...], Part]]:
    ports = (
        Port("status", "", "as the step returns it: 0 decided, 1 fallback, 2 refused, 3 invalid"),
        Port("solver", "", "status of the solver, 0 where there is none; see otolith.compiled.SOLVERS"),
        Port("changes", "", "working-set changes of the solver"),
        Port("residual", "", "largest violation of the optimality conditions"),
    )
    return [(ports, (result, 0, 4))]
