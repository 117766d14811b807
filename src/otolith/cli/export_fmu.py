"""`otolith export fmu`: an algorithm as a block for simulation tools."""

from pathlib import Path
from typing import Annotated, Final, cast, get_args

import typer

from otolith import files
from otolith.cli.options import CUEING_HELP, RunOptions, with_design_options
from otolith.cli.output import print_json, screen, working
from otolith.core.disk import write_bytes
from otolith.core.errors import InputError, one_of
from otolith.export.fmu import check_model_name, fmu
from otolith.export.fmu_binary import check_compilers, installed_compiler
from otolith.export.fmu_description import Version
from otolith.export.make import Kind, program_of
from otolith.registry import check_options

Cueing = Annotated[str, typer.Option(help=CUEING_HELP)]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]
_VERSIONS: Final = get_args(Version)


@with_design_options
def fmu_(
    choices: RunOptions,
    *,
    out: Annotated[Path, typer.Option(help="File to write (.fmu); its name becomes that of the model.")],
    cueing: Cueing = "predictive",
    fmi: Annotated[str, typer.Option(help="Version of the standard: 2.0 or 3.0.")] = "2.0",
    kind: Annotated[
        str,
        typer.Option(
            help="platform: the algorithm and the platform that follows it; command: the algorithm alone, "
            "which receives the measured motion."
        ),
    ] = "platform",
    compiler: Annotated[
        list[str] | None,
        typer.Option(help="C compiler of a binary (default: the first of cc, gcc, clang); repeatable."),
    ] = None,
    sources_only: Annotated[
        bool, typer.Option("--sources-only", help="Leave the binary out: the host compiles the sources.")
    ] = False,
    json: Json = False,
) -> None:
    """Write an algorithm as an FMU for co-simulation: for Simulink, CarMaker and other hosts."""
    files.check_file(out, ".fmu")
    version, asked = _version(fmi), kind_named(kind)
    check_model_name(out.stem, version)
    if sources_only and compiler:
        raise InputError("--compiler", "given with --sources-only", "left out, since nothing is compiled")
    compilers = [] if sources_only else compiler or [installed_compiler()]
    check_compilers(compilers)
    design = choices.design()
    check_options([cueing], choices.given)
    with working(screen(), "translating and compiling; kernels are compiled on first use, then cached"):
        program = program_of(design, cueing, out.stem, asked, plant=choices.plant)
        packed = fmu(program, version, compilers, at_once=asked is Kind.COMMAND)
    write_bytes(out, packed)
    if json:
        print_json(
            {
                "file": str(out),
                "fmi": version,
                "kind": asked.value,
                "cueing": cueing,
                "period_s": program.period,
                "inputs": [port.name for port in program.inputs],
                "outputs": [port.name for port in program.outputs],
                "bytes": len(packed),
            }
        )
    screen().print(
        f"{cueing} as an FMU (FMI {version}): {len(program.inputs)} inputs, {len(program.outputs)} outputs, "
        f"a decision per {program.period:g} s, {len(packed) / 1000:.0f} kB; written to {out}",
        highlight=False,
        soft_wrap=True,
    )


def _version(text: str) -> Version:
    if text not in _VERSIONS:
        raise InputError("--fmi", repr(text), one_of(_VERSIONS, text))
    return cast(Version, text)


def kind_named(text: str) -> Kind:
    """Return the kind of program of an option; raises `InputError`."""
    if text not in list(Kind):
        raise InputError("--kind", repr(text), one_of([kind.value for kind in Kind], text))
    return Kind(text)
