"""`otolith export`: algorithms as programs for hosts without Python."""

from pathlib import Path
from typing import Annotated, Final

import typer

from otolith.cli.export_fmu import Cueing, Json, fmu_, kind_named
from otolith.cli.export_ros2 import ros2_
from otolith.cli.options import RunOptions, with_design_options
from otolith.cli.output import Force, group, print_json, screen, working
from otolith.core.folders import check_folder, whole_folder
from otolith.export.make import program_of
from otolith.export.program import check_name
from otolith.export.project import write_project
from otolith.export.vectors import drive, vectors
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
        "as a platform would.",
    ),
]
ProgramName = Annotated[str, typer.Option(help="Name of the program, its struct and its files.")]


@app.command("c")
@with_design_options
def c_(
    choices: RunOptions,
    *,
    out: Annotated[Path, typer.Option(help="Folder to write to.")],
    cueing: Cueing = "predictive",
    kind: KindName = "command",
    name: ProgramName = "cueing",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write an algorithm as C99 in one header, with a CMake project and test vectors from Python."""
    asked = kind_named(kind)
    check_name(name)
    check_folder(out, command="export c", force=force)
    design, plant = choices.design(), choices.plant
    check_options([cueing], choices.given)
    console = screen()
    with working(console, "translating; kernels are compiled on first use, then cached"):
        program = program_of(design, cueing, name, asked, plant=plant)
        checks = vectors(design, cueing, asked, drive(STEPS * program.period), plant=plant)
    with whole_folder(out, command="export c", force=force) as folder:
        write_project(program, checks, folder)
    if json:
        print_json(
            {
                "name": name,
                "kind": asked.value,
                "cueing": cueing,
                "period_s": program.period,
                "inputs": [port.name for port in program.inputs],
                "outputs": [port.name for port in program.outputs],
                "steps_of_vectors": len(checks.inputs),
                "folder": str(out),
            }
        )
    console.print(
        f"{cueing} as {name}.h: {len(program.inputs)} inputs, {len(program.outputs)} outputs, a step per "
        f"{program.period:g} s; written to {out}",
        highlight=False,
        soft_wrap=True,
    )
