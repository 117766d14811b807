"""`otolith export`: algorithms as programs for hosts without Python."""

from pathlib import Path
from typing import Annotated, Final

import typer

from otolith import registry
from otolith.cli.export_fmu import fmu_
from otolith.cli.export_ros2 import ros2_
from otolith.cli.options import CUEING_HELP, RunOptions, is_given
from otolith.cli.output import Force, group, print_json, screen, working
from otolith.core.errors import InputError, one_of
from otolith.core.folders import check_folder, whole_folder
from otolith.export.make import Kind, program_of
from otolith.export.program import check_name
from otolith.export.project import write_project
from otolith.export.vectors import drive, vectors

app = group("Algorithms for hosts without Python: C, an FMU, a ROS 2 package.")
app.command("fmu")(fmu_)
app.command("ros2")(ros2_)
STEPS: Final = 1000  # of the test vectors
_OF_MPC: Final = ("horizon", "blocks", "prediction", "liveliness", "braking")  # options that not all read

Cueing = Annotated[str, typer.Option(help=CUEING_HELP)]
Platform = Annotated[str, typer.Option(help="A shipped platform's name or a platform file (.toml).")]
Dofs = Annotated[str, typer.Option(help="What to cue, with commas: surge-pitch, sway-roll, heave, yaw.")]
Horizon = Annotated[int | None, typer.Option(help="Steps of the implicit MPC (default: 50).")]
Blocks = Annotated[
    str | None, typer.Option(metavar="STEPS,...", help="Hold the implicit MPC's inputs over blocks.")
]
Prediction = Annotated[
    str | None, typer.Option(help="What an MPC assumes of the future: hold, decay or adaptive.")
]
Liveliness = Annotated[float, typer.Option(help="Of predictive, 0 to 1: how much travel it spends.")]
Braking = Annotated[str | None, typer.Option(help="Braking rows: stopping, leading, position or none.")]
PlantName = Annotated[
    str | None, typer.Option(help="A name of 'otolith list plants' (default: what the algorithm assumes).")
]
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
def c_(
    context: typer.Context,
    out: Annotated[Path, typer.Option(help="Folder to write to.")],
    cueing: Cueing = "predictive",
    dofs: Dofs = "surge-pitch",
    platform: Platform = "thesis",
    plant: PlantName = None,
    kind: KindName = "command",
    name: ProgramName = "cueing",
    horizon: Horizon = None,
    blocks: Blocks = None,
    prediction: Prediction = None,
    liveliness: Liveliness = 0.5,
    braking: Braking = None,
    force: Force = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
    ] = False,
) -> None:
    """Write an algorithm as C99 in one header, with a CMake project and test vectors from Python."""
    asked = kind_named(kind)
    check_name(name)
    check_folder(out, command="export c", force=force)
    given = [option for option in _OF_MPC if is_given(context, option)]
    design = RunOptions(
        platform=platform,
        plant=plant,
        dofs=dofs,
        horizon=horizon,
        blocks=blocks,
        prediction=prediction,
        liveliness=liveliness,
        braking=braking,
    ).design()
    registry.check_options([cueing], given)
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


def kind_named(kind: str) -> Kind:
    """Return the kind of program of an option; raises `InputError`."""
    if kind not in list(Kind):
        raise InputError("--kind", repr(kind), one_of([one.value for one in Kind], kind))
    return Kind(kind)
