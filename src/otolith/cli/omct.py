"""`otolith omct`: the objective motion cueing test, for any cueing algorithm."""

from pathlib import Path
from typing import Annotated

import typer

from otolith import __version__, files, registry
from otolith.cli.figures import write_figure
from otolith.cli.options import CUEING_HELP
from otolith.cli.output import Replace, file_name, print_json, progress_bar, screen
from otolith.core.errors import InputError
from otolith.core.frames import AXES, dofs_named
from otolith.cueing.design import Design
from otolith.metrics import failures
from otolith.metrics.boundaries import parse_boundaries
from otolith.metrics.frequency_response import (
    Procedure,
    System,
    applicable,
    decisions,
    motion_cueing_test,
    sinacori_point,
)
from otolith.scenarios.cueing_tests import TESTS, Amplitudes


def omct_(
    cueing: Annotated[str, typer.Option(help=CUEING_HELP)],
    platform: Annotated[str, typer.Option(help="A shipped platform's name or a platform file.")] = "thesis",
    dofs: Annotated[
        str, typer.Option(help="surge-pitch, sway-roll, heave, yaw; several with commas.")
    ] = "surge-pitch",
    plant: Annotated[
        str | None,
        typer.Option(help="A name of 'otolith list plants' (default: what the algorithm assumes)."),
    ] = None,
    force: Annotated[
        float, typer.Option(metavar="M/S2", help="Amplitude of the driven specific force.")
    ] = 1.0,
    boundaries: Annotated[
        Path | None, typer.Option(help="Boundary curves as CSV; see the documentation for its columns.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results (default: out/omct-CUEING).")
    ] = None,
    replace: Replace = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Drive one axis at a time at twelve frequencies: modulus and phase of what is felt (ICAO 9625)."""
    if not 0.0 < force <= 20.0:
        raise InputError("--force", force, "greater than 0 and at most 20 m/s²")
    bounds = (
        {}
        if boundaries is None
        else parse_boundaries(files.read_text(boundaries, "boundaries"), boundaries.name)
    )
    folder = out or Path("out") / f"omct-{file_name(cueing)}"
    files.check_folder(folder, command="omct", force=replace)
    console = screen()
    system, names = _system(cueing, platform, dofs, plant)
    procedure = Procedure(amplitudes=Amplitudes(force=force))
    with progress_bar(console, f"{cueing}, {procedure.seconds(system):.0f} s of motion") as progress:
        responses = motion_cueing_test(system, procedure, progress=progress)
        points = {axis: sinacori_point(system, axis, procedure) for axis in AXES if axis in system.axes}
    from otolith.report import bode as report

    skipped = [test.name for test in TESTS if test not in applicable(system.axes)]
    summary = {
        **names,
        "version": __version__,
        "force_mps2": force,
        "at_1_radps": {
            axis: {"gain": point.modulus, "phase_deg": report.known(point.phase_deg)}
            for axis, point in points.items()
        },
        "tests": report.omct_json(responses, bounds),
        "not_cued": skipped,
        "status": dict(decisions(responses)),
    }
    facts = {**names, "amplitude of force": f"{force:g} m/s²", "not cued": ", ".join(skipped) or "–"}
    facts |= {"failed": "; ".join(failures(summary))} if failures(summary) else {}
    with files.whole_folder(folder, command="omct", force=replace) as made:
        files.write_json(made / "omct.json", summary)
        files.write_text(made / "report.html", report.omct_page(cueing, facts, responses, bounds))
        write_figure(made, "figure", report.omct_figure(responses, bounds))
    if json:
        print_json(summary)
    for text in failures(summary):
        console.print(text, highlight=False, soft_wrap=True)
    if skipped:
        console.print(f"not cued, hence not tested: {', '.join(skipped)}", highlight=False, soft_wrap=True)
    console.print(f"written to {folder}: report.html, figures, omct.json", highlight=False, soft_wrap=True)


def _system(cueing: str, platform: str, dofs: str, plant: str | None) -> tuple[System, dict[str, str]]:
    """Return the system under test and its names; every invalid value is refused before work starts."""
    cued = dofs_named(dofs.split(","))
    maker = registry.cueing_named(cueing)
    plant_name = plant or maker.plant
    design = Design(platform=files.read_platform(platform), dofs=cued)
    moved = registry.make_plant(plant_name, design.platform)
    system = System(
        cueing=registry.make_cueing(cueing, design, dead_time=moved.dead_time),
        plant=moved,
        platform=design.platform,
        axes={AXES[i] for dof in cued for i in dof.axes},
    )
    return system, {"cueing": cueing, "platform": design.platform.name, "plant": plant_name, "dofs": dofs}
