"""`otolith export ros2`: an algorithm as a package with a node for ROS 2."""

from pathlib import Path
from typing import Annotated

import typer

from otolith.cli.export_fmu import Cueing, Json
from otolith.cli.options import RunOptions, with_design_options
from otolith.cli.output import Force, print_json, screen, working
from otolith.core.disk import write_text
from otolith.core.folders import check_folder, whole_folder
from otolith.export.legs import legs_program
from otolith.export.make import Kind, program_of
from otolith.export.ros2 import check_package_name, ros2_package
from otolith.registry import check_options

_COMMAND = "export ros2"


@with_design_options
def ros2_(
    choices: RunOptions,
    *,
    out: Annotated[Path, typer.Option(help="Folder to write; its name becomes that of the package.")],
    cueing: Cueing = "predictive",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write an algorithm as a ROS 2 package: a node from wanted motion to poses and leg set-points."""
    name = out.resolve().name
    check_package_name(name)
    check_folder(out, command=_COMMAND, force=force)
    design = choices.design()
    check_options([cueing], choices.given)
    described = design.platform
    with working(screen(), "translating; kernels are compiled on first use, then cached"):
        program = program_of(design, cueing, name, Kind.PLATFORM, plant=choices.plant)
        hexapod = None if described.hexapod is None else described.six_legs()
        legs = None if hexapod is None else legs_program(hexapod, f"{name}_legs", program.period)
        unit = "rad" if hexapod is not None and hexapod.cranks is not None else "m"
        package = ros2_package(program, legs, leg_unit=unit)
    with whole_folder(out, command=_COMMAND, force=force) as folder:
        for path, text in package.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            write_text(folder / path, text)
    if json:
        print_json(
            {
                "folder": str(out),
                "package": name,
                "cueing": cueing,
                "period_s": program.period,
                "legs": None if legs is None else unit,
                "files": sorted(package),
            }
        )
    moved = "with its legs" if legs is not None else "without legs, since the platform's file has none"
    screen().print(
        f"{cueing} as the ROS 2 package {name}, {moved}, a decision per {program.period:g} s; written to "
        f"{out}",
        highlight=False,
        soft_wrap=True,
    )
