"""`otolith explicit`: enumerate explicit laws, verify them, show them, and export them as C."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from otolith import files
from otolith.cli.output import group, print_json, progress_line, screen, working
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, joint_law
from otolith.cueing.mpc.rows import parse_braking_rows
from otolith.mpqp import Verification, verify
from otolith.mpqp.export_c import export_c

app = group("Explicit laws: build, verify, show, export.")
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]
LawFile = Annotated[Path, typer.Argument(metavar="LAW", help="A law written by 'otolith explicit build'.")]

# Figures of a verification that are summed over all parts, and those of which the worst counts.
_COUNTS = (
    "samples",
    "feasible",
    "unsolved",
    "missing",
    "slivers",
    "false_hits",
    "facets",
    "open_facets",
    "mirror_missing",
    "strays",
    "doubles",
)
_WORST = ("max_law_error", "max_overlap", "continuity")


@app.command()
def build(
    out: Annotated[Path, typer.Option(help="File to write the law to (.h5).")],
    dofs: Annotated[str, typer.Option(help="Axis pairs, heave, yaw; several with commas.")] = "surge-pitch",
    platform: Annotated[str, typer.Option(help="A shipped platform's name or a platform file.")] = "thesis",
    horizon: Annotated[int, typer.Option(help="Steps of the prediction.")] = 5,
    period: Annotated[float, typer.Option(help="Period of the law [s].")] = 0.1,
    block_from: Annotated[
        int | None, typer.Option(help="Move blocking: inputs are equal from this step on (1 = first).")
    ] = None,
    braking: Annotated[str, typer.Option(help="Braking rows: position, printed or none.")] = "none",
    control_weight: Annotated[float, typer.Option(help="Weight on the squared accelerations.")] = 1e-3,
    tolerance: Annotated[
        float, typer.Option(help="Least radius of a region, parameters in a unit box.")
    ] = 1e-7,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Threads (default: one per processor); the law is the same.")
    ] = None,
    json: Json = False,
) -> None:
    """Enumerate the explicit law of a set of axes; independent parts are found and solved apart."""
    settings = ExplicitSettings(
        horizon=horizon,
        period=period,
        block_from=block_from,
        braking=parse_braking_rows(braking),
        control_weight=control_weight,
    )
    if not 0.0 < tolerance < 0.1:
        raise InputError("--tolerance", tolerance, "greater than 0 and less than 0.1")
    console = screen()
    description = files.read_platform(platform)
    files.check_file(out, ".h5")
    with working(
        console, "preparing; kernels are compiled on first use (about 15 s), then cached"
    ) as progress:
        law = joint_law(
            description,
            dofs_named(dofs.split(",")),
            settings,
            tolerance=tolerance,
            progress=lambda now: progress(progress_line(now)),
            workers=workers,
        )
    files.write_laws(law.laws, out)
    seconds = sum(part.seconds for part in law.laws)
    account = {
        "regions": len(law),
        "parts": list(law.counts),
        "seconds": seconds,
        "compile_seconds": sum(part.compile_seconds for part in law.laws),
        "tolerance": tolerance,
        "bytes": law.nbytes,
    }
    if json:
        print_json(account)
    parts = " x ".join(str(count) for count in law.counts)
    each = law.nbytes / sum(law.counts)
    console.print(
        f"{parts} regions (tolerance {tolerance:g}) in {seconds:.2f} s, {each:.0f} bytes per region, "
        f"written to {out}",
        highlight=False,
        soft_wrap=True,
    )


@app.command("verify")
def verify_(
    law: LawFile,
    samples: Annotated[int, typer.Option(min=1, help="Parameters to check, per part.")] = 100_000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random parameters.")] = 0,
    json: Json = False,
) -> None:
    """Check a stored law against an independent QP; exit code 1 when anything is wrong."""
    console = screen()
    found = []
    for number, part in enumerate(files.read_laws(law)):
        with working(console, f"part {number}: {len(part)} regions at {samples} parameters"):
            found.append(verify(part, samples, np.random.default_rng(seed)))
    passed = all(one.passed for one in found)
    if json:
        print_json(_account(found, passed))
    for one in found:
        console.print(_verdict(one), highlight=False, soft_wrap=True)
    if not passed:
        sys.exit(1)


def _account(found: list[Verification], passed: bool) -> dict[str, Any]:
    parts = [asdict(one) for one in found]
    total = {key: sum(part[key] for part in parts) for key in _COUNTS}
    worst = {key: max(part[key] for part in parts) for key in _WORST}
    return {**total, **worst, "tolerance": parts[0]["tolerance"], "passed": passed, "parts": parts}


def _verdict(one: Verification) -> str:
    return (
        f"{'passed' if one.passed else 'FAILED'}: {one.regions} regions (tolerance {one.tolerance:g}), "
        f"{one.samples} samples, {one.missing} missing, {one.false_hits} false hits, "
        f"law error {one.max_law_error:.1e}, overlap {one.max_overlap}, continuity {one.continuity:.1e}"
    )


@app.command()
def show(law: LawFile, json: Json = False) -> None:
    """Show what a stored law contains."""
    parts = [
        {
            "regions": len(part),
            "variables": len(part.problem.f),
            "parameters": len(part.problem.lower),
            "constraints": len(part.problem.w),
            "tolerance": part.tolerance,
            "bytes": part.nbytes,
            "model": part.problem.digest[:12],
        }
        for part in files.read_laws(law)
    ]
    if json:
        print_json({"parts": parts})
        return
    table = Table(box=None, pad_edge=False)
    for key in parts[0]:
        table.add_column(key, justify="right")
    for part in parts:
        table.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v) for v in part.values()))
    screen(stderr=False).print(table)


@app.command()
def export(
    law: LawFile,
    out: Annotated[Path, typer.Option(help="Folder for the .c and .h files.")],
    name: Annotated[str, typer.Option(help="Prefix of the C functions and files.")] = "law",
    outputs: Annotated[
        int | None, typer.Option(help="Only the first so many variables (default: all).")
    ] = None,
) -> None:
    """Write a stored law as dependency-free C, one .c and .h pair per part."""
    laws = files.read_laws(law)
    files.check_file(out / f"{name}.c")
    for number, part in enumerate(laws):
        source = export_c(part, name if len(laws) == 1 else f"{name}_{number}", outputs=outputs)
        files.write_text(out / f"{source.name}.h", source.header)
        files.write_text(out / f"{source.name}.c", source.source)
        screen().print(f"written to {out / source.name}.c and .h", highlight=False, soft_wrap=True)
