"""`otolith tune`: find constant washout weights by optimisation."""

from typing import Annotated, Final

import typer
from rich.table import Table

from otolith import files
from otolith.cli.output import Jobs, described_bar, print_json, screen
from otolith.core.jobs import number_of_jobs
from otolith.scenarios import scenario
from otolith.tuning import TRAVEL_PRICE, Tuned, tune

WORTH: Final = 3000.0  # [s] of drives to cue that are worth the start of a process
TABLE_5_3: Final = (
    "sine-0.5",
    "sine-1",
    "sine-2",
    "combined",
    "step-0.5",
    "step-1",
    "step-2",
    "step-sine-0.5",
    "step-sine-1",
)


def tune_(
    scenarios: Annotated[
        list[str] | None, typer.Argument(metavar="SCENARIO", help="Default: those of Table 5.3.")
    ] = None,
    on: Annotated[str, typer.Option(metavar="STATE,...", help="States to weigh.")] = "velocity,position",
    platform: Annotated[str, typer.Option(help="A shipped platform's name or a file (.toml).")] = "thesis",
    evaluations: Annotated[int, typer.Option(help="How often all scenarios are cued, at most.")] = 40,
    price: Annotated[float, typer.Option(help="Price of RMS travel in reaches.")] = TRAVEL_PRICE,
    jobs: Jobs = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Find constant washout weights of the implicit MPC that track the scenarios with little travel."""
    console = screen()
    described = files.read_platform(platform)
    chosen = [scenario(name) for name in scenarios or TABLE_5_3]
    seconds = evaluations * sum(one.duration for one in chosen)
    processes = number_of_jobs(jobs, most=int(seconds / WORTH))
    with described_bar(console, "preparing") as progress:
        found = tune(
            described,
            [state.strip() for state in on.split(",")],
            chosen,
            evaluations=evaluations,
            price=price,
            jobs=processes,
            progress=lambda count, J: progress(
                f"{count} of at most {evaluations}: J = {J:.4f}", min(count / evaluations, 1.0)
            ),
        )
    if json:
        print_json(found.as_json())
    else:
        screen(stderr=False, wide=True).print(_grid(found))
    options = " ".join(f"--weight {state}={value:.4g}" for state, value in found.weights.items())
    console.print(f"J = {found.objective:.4f}; otolith run … {options}", highlight=False, soft_wrap=True)


def _grid(found: Tuned) -> Table:
    grid = Table("scenario", "RMSE [m/s²]", "travel RMS [m]", title_justify="left")
    for name, (rmse, travel) in found.by_scenario.items():
        grid.add_row(name, f"{rmse:.4f}", f"{travel:.4f}")
    return grid
