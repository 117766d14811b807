"""`otolith export`: algorithms as programs for hosts without Python."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Final

import typer

from otolith import files
from otolith.cli.export_fmu import Cueing, Json, fmu_
from otolith.cli.export_ros2 import ros2_
from otolith.cli.options import RunOptions, with_design_options
from otolith.cli.output import Force, group, print_json, screen, working
from otolith.core.errors import InputError, one_of
from otolith.core.folders import check_folder, whole_folder
from otolith.export.guards import (
    STEP,
    Guard,
    SetPoints,
    gating,
    program_of_guard,
    supervising,
    vectors_of_guard,
)
from otolith.export.make import Kind, program_of
from otolith.export.program import Program, check_name
from otolith.export.project import write_project
from otolith.export.vectors import Vectors, drive, vectors
from otolith.platforms.machines import check_machine
from otolith.registry import check_options

app = group("Algorithms for hosts without Python: C, an FMU, a ROS 2 package.")
app.command("fmu")(fmu_)
app.command("ros2")(ros2_)
STEPS: Final = 1000  # of the test vectors

KindName = Annotated[
    str,
    typer.Option(
        "--kind",
        help="command: decides accelerations, from what is wanted and the measured motion; platform: moves "
        "as a platform would; gate: lets set-points pass that keep all limits and can stop; supervisor: "
        "keeps the limits of six legs.",
    ),
]
ProgramName = Annotated[str, typer.Option(help="Name of the program, its struct and its files.")]
_OF_GUARDS: Final = {"platform", "period", "out", "kind", "name", "force", "json"}  # options with a meaning


@app.command("c")
@with_design_options
def c_(
    choices: RunOptions,
    *,
    out: Annotated[Path, typer.Option(help="Folder to write to.")],
    cueing: Cueing = "predictive",
    kind: KindName = "command",
    set_points: Annotated[
        str, typer.Option(help="Of --kind supervisor: pose, or legs (their lengths and speeds).")
    ] = "pose",
    name: ProgramName = "cueing",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write an algorithm or a guard as C99 in one header, with a CMake project and test vectors."""
    asked = _kind(kind)
    check_name(name)
    check_folder(out, command="export c", force=force)
    made = (
        _guard(choices, asked, set_points) if isinstance(asked, Guard) else _algorithm(choices, asked, cueing)
    )
    with working(screen(), "translating; kernels are compiled on first use, then cached"):
        program, checks = made(name)
    with whole_folder(out, command="export c", force=force) as folder:
        write_project(program, checks, folder, strict=isinstance(asked, Guard))
    what = f"the {asked}" if isinstance(asked, Guard) else cueing
    if json:
        print_json(
            {
                "name": name,
                "kind": asked.value,
                "cueing": None if isinstance(asked, Guard) else cueing,
                "period_s": program.period,
                "inputs": [port.name for port in program.inputs],
                "outputs": [port.name for port in program.outputs],
                "steps_of_vectors": len(checks.inputs),
                "folder": str(out),
            }
        )
    screen().print(
        f"{what} as {name}.h: {len(program.inputs)} inputs, {len(program.outputs)} outputs, a step per "
        f"{program.period:g} s; written to {out}",
        highlight=False,
        soft_wrap=True,
    )


def _kind(text: str) -> Kind | Guard:
    """Return the kind of program of `--kind`; raises `InputError`."""
    known: list[Kind | Guard] = [*Kind, *Guard]
    if text not in known:
        raise InputError("--kind", repr(text), one_of(known, text))
    return Guard(text) if text in list(Guard) else Kind(text)


def _algorithm(choices: RunOptions, kind: Kind, cueing: str) -> Callable[[str], tuple[Program, Vectors]]:
    """Return what makes an algorithm's program and test vectors for a name; options are refused now."""
    if "set_points" in choices.given:
        raise InputError("--set-points", f"given with --kind {kind}", "left out: supervisor alone reads it")
    design, plant = choices.design(), choices.plant
    check_options([cueing], choices.given)

    def make(name: str) -> tuple[Program, Vectors]:
        program = program_of(design, cueing, name, kind, plant=plant)
        return program, vectors(design, cueing, kind, drive(STEPS * program.period), plant=plant)

    return make


def _guard(choices: RunOptions, kind: Guard, set_points: str) -> Callable[[str], tuple[Program, Vectors]]:
    """Return what makes a guard's program and test vectors for a name; options are refused now."""
    known = _OF_GUARDS | ({"set_points"} if kind is Guard.SUPERVISOR else set())
    for option in sorted(choices.given - known):
        bound = "left out: it knows a platform, and no algorithm"
        raise InputError(f"--{option.replace('_', '-')}", f"given with --kind {kind}", bound)
    if set_points not in list(SetPoints):
        raise InputError("--set-points", repr(set_points), one_of(list(SetPoints), set_points))
    platform, period = files.read_platform(choices.platform), choices.period or STEP

    check_machine(platform, "--platform")
    legs = platform.six_legs() if kind is Guard.SUPERVISOR else None

    def make(name: str) -> tuple[Program, Vectors]:
        if legs is None:
            guard = gating(platform, period=period)
        else:
            guard = supervising(legs, platform.name, period=period, set_points=SetPoints(set_points))
        return program_of_guard(guard, name), vectors_of_guard(guard)

    return make
