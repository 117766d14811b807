"""`otolith run` and `otolith compare`: close the loop, judge it, write the results."""

import functools
import re
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer
from matplotlib.figure import Figure
from rich.console import Console

from otolith import __version__, files, metrics, registry
from otolith.cli.options import Choices, takes_choices
from otolith.cli.output import print_json, progress_bar, sentence
from otolith.report import comparison_figure, cueing_figure, render, render_comparison, save_figure
from otolith.simulate import Run, simulate

_FOUR_MODELS = ["implicit", "implicit-trajectory", "hybrid-first", "hybrid-all"]  # section 3.1

Out = Annotated[Path | None, typer.Option(help="Folder for the results (default: out/SCENARIO-CUEING).")]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]


@takes_choices
def run(
    choices: Choices,
    cueing: Annotated[str, typer.Option(help="A name of 'otolith list cueing'.")] = "hybrid-all",
    out: Out = None,
    json: Json = False,
) -> None:
    """Cue one scenario, or a recorded drive, and write run.h5, summary.json, report.html and figures."""
    console = Console(stderr=True)
    (result,) = _simulate_all(choices, [cueing], console)
    summary = metrics.summarise(result)
    folder = out or Path("out") / f"{_file_name(result.scenario)}-{cueing}"
    files.write_run(result, folder / "run.h5")
    page = render(result, summary, date=_today())
    _write(folder, summary, page, {pair: cueing_figure(result, pair) for pair in result.pairs})
    _tell(summary if json else None, [summary], folder, console)


@takes_choices
def compare(
    choices: Choices,
    cueing: Annotated[
        list[str] | None, typer.Option(help="An algorithm; repeat to compare (default: the thesis's four).")
    ] = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Cue one scenario, or a recorded drive, with several algorithms and put their results side by side."""
    console = Console(stderr=True)
    runs = _simulate_all(choices, list(dict.fromkeys(cueing or _FOUR_MODELS)), console)
    summaries = metrics.compare(runs)
    folder = out or Path("out") / f"{_file_name(runs[0].scenario)}-compared"
    for result in runs:
        files.write_run(result, folder / f"{result.cueing}.h5")
    page = render_comparison(runs, summaries, date=_today())
    _write(folder, summaries, page, {pair: comparison_figure(runs, pair) for pair in runs[0].pairs})
    _tell(summaries if json else None, list(summaries.values()), folder, console)


def _simulate_all(choices: Choices, names: list[str], console: Console) -> list[Run]:
    """Check everything the user said, then close the loop once per algorithm."""
    makers = [registry.lookup(registry.CUEING, "--cueing", name) for name in names]
    plants = [choices.plant or maker.plant for maker in makers]
    plant_makers = [registry.lookup(registry.PLANTS, "--plant", plant) for plant in plants]
    status = console.status("preparing")
    design = choices.design(status.update)
    scenario = choices.reference(design, console)
    runs = []
    for name, maker, plant, plant_maker in zip(names, makers, plants, plant_makers, strict=True):
        status.update(f"preparing {name}; kernels are compiled on first use (10 to 30 s), then cached")
        with status:
            cueing = maker.load()(design)
        with progress_bar(console, f"{name} on {scenario.name}") as progress:
            run = simulate(
                cueing,
                plant_maker.load()(design.platform),
                scenario,
                platform=design.platform,
                pairs=tuple(pair.name for pair in design.pairs),
                names=(name, plant),
                settings={"version": __version__, **choices.as_settings()},
                preview=design.implicit.horizon if choices.preview else 0,
                progress=progress,
            )
        runs.append(run)
    return runs


def _write(folder: Path, summary: dict[str, Any], page: str, figures: dict[str, Figure]) -> None:
    """Summary, page, and one figure per axis pair."""
    files.write_json(folder / "summary.json", summary)
    files.write_text(folder / "report.html", page)
    for pair, figure in figures.items():
        name = "figure" if len(figures) == 1 else f"figure-{pair}"
        for ending in ("pdf", "png"):
            files.write_figure(folder / f"{name}.{ending}", functools.partial(save_figure, figure))


def _tell(json_value: object | None, summaries: list[dict[str, Any]], folder: Path, console: Console) -> None:
    if json_value is not None:
        print_json(json_value)
    for summary in summaries:
        console.print(sentence(summary), highlight=False, soft_wrap=True)
    console.print(
        f"written to {folder}: report.html, figures, summary.json, run data", highlight=False, soft_wrap=True
    )


def _today() -> str:
    return datetime.now().astimezone().date().isoformat()


def _file_name(text: str) -> str:
    """A scenario's name as part of a path: nothing but letters, digits, dot, dash and underscore."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "scenario"
