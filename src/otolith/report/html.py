"""The page of one run: the diagrams of what is felt, the key figures on scales, and folded details."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape
from typing import Final

from otolith.core.frames import DOFS
from otolith.loop import Run
from otolith.metrics import best_in_words, between_nodes, breaches, failures, held_back
from otolith.metrics.measure import Summary
from otolith.report import tables, texts
from otolith.report.gauges import gauges_html
from otolith.report.motion import motion_panels
from otolith.report.page import Part, page
from otolith.report.panels import Panel, effort_panels
from otolith.report.plots import height, plot_json
from otolith.report.series import MAX_POINTS, decimated
from otolith.report.tables import number
from otolith.report.view import bases_of, frames_of, platform_view

LEGGED = "hexapod"  # how the names of plants with legs begin, see otolith.registry
MOVING = (
    "Drag the picture to turn it. Legs turn from blue, short, over green to red, long; the dot is the head."
)
DRAWN: Final = ("plotly/plotly-basic.min.js", "page.js")  # scripts of a page with diagrams
LEAST: Final = 100  # least number of points of a curve: minimum and maximum of 50 stretches
BUDGET: Final = 45_000  # largest number of points of a page: 0.5 MB, next to 1.2 MB of plotly


def render(run: Run, summary: Summary, *, date: str = "", best: Run | None = None) -> str:
    """Return the page of one run.

    Parameters
    ----------
    summary : key figures by name, plain JSON values, possibly nested; see `otolith.metrics.summarise`.
    date : date of the run, as it is to be printed.
    best : the best that is possible on the same drive, drawn with it.
    """
    of_dofs = {dof: motion_panels(run, dof, best) for dof in run.dofs}
    of_effort = effort_panels(run)
    points = points_each([*(panel for panels in of_dofs.values() for panel in panels), *of_effort])
    felt = "".join(
        diagrams(dof, _named(dof, panels[:1], run), points=points) for dof, panels in of_dofs.items()
    )
    picture = f'<div class="small">{felt}</div>' if len(run.dofs) > 1 else felt
    parts = [
        Part("Wanted and felt", picture),
        Part("Key figures", gauges_html(summary)),
        Part("Limits", tables.limits(summary), folded=not breaches(summary)),
    ]
    for dof, (_, *others) in of_dofs.items():
        words = f"{texts.DOFS[dof]}: how the platform moved"
        parts.append(Part(words, diagrams(dof, others, points=points), folded=True))
    if run.plant.startswith(LEGGED):
        view = platform_view(run.platform.six_legs(), *frames_of(run), bases=bases_of(run))
        parts.append(Part("The platform in motion", f'<p class="note">{MOVING}</p>{view}', folded=True))
    parts += [
        Part("The solver’s effort", diagrams("effort", of_effort, points=points), folded=True),
        Part("All figures", tables.key_figures(summary), folded=True),
        Part("How it was made", facts([run], date) + settings_text(record(run)), folded=True),
    ]
    lead = (
        f'<p class="lead">Cued by <strong>{escape(run.cueing)}</strong> on platform '
        f"<strong>{escape(run.platform.name)}</strong>, plant <strong>{escape(run.plant)}</strong></p>"
        + verdict(run, summary)
    )
    return page(
        run.scenario,
        "Run report",
        lead,
        [part for part in parts if part.body],
        styles=("platform.css",),
        scripts=DRAWN,
        contents="",
    )


def _named(dof: str, panels: Sequence[Panel], run: Run) -> list[Panel]:
    """Add the name of the degree of freedom to the titles of panels if a run has several."""
    if len(run.dofs) == 1:
        return list(panels)
    return [replace(one, title=f"{texts.DOFS[dof]}: {one.title[0].lower()}{one.title[1:]}") for one in panels]


def points_each(panels: Iterable[Panel]) -> int:
    """Return the number of points per curve that keeps a page with many curves small."""
    curves = sum(len(panel.curves) for panel in panels)
    return min(MAX_POINTS, max(LEAST, BUDGET // max(1, curves)))


def facts(runs: Sequence[Run], date: str) -> str:
    """List the circumstances of runs of one kind, read from the first of them."""
    run = runs[0]
    steps = run.decisions
    known = {
        "platform": run.platform.name,
        "plant": run.plant,
        "degrees of freedom": f"{sum(len(DOFS[name].axes) for name in run.dofs)} ({', '.join(run.dofs)})",
        "soft limits": ", ".join(run.soft),
        "duration": f"{steps * run.period:.4g} s, {number(steps)} steps",
        "controller period": f"{1e3 * run.period:.4g} ms",
        "plant period": f"{1e3 * run.plant_period:.4g} ms",
        "date": date,
    }
    entries = (f"<div><dt>{k}</dt><dd>{escape(v)}</dd></div>" for k, v in known.items() if v)
    return f'<dl class="facts">{"".join(entries)}</dl>{decimation(runs)}'


def diagrams(prefix: str, panels: Sequence[Panel], *, points: int = MAX_POINTS) -> str:
    """Return interactive diagrams in a column; `prefix` makes their names unique on the page."""
    return "".join(_diagram(f"{prefix}-{panel.key}", panel, points) for panel in panels)


def _diagram(name: str, panel: Panel, points: int) -> str:
    linked = " data-linked" if panel.over_time else ""
    first, _, rest = (panel.words or texts.PANELS[panel.key]).partition(". ")
    more = f" <details><summary>How to read it</summary><p>{rest}</p></details>" if rest else ""
    return (
        f"<figure><figcaption><h3>{escape(panel.title)}</h3><p>{first.removesuffix('.')}.</p>{more}"
        "</figcaption>"
        f'<div class="plot" style="min-height: {height(panel)}px" id="{escape(name)}"{linked} role="img" '
        f'aria-label="{escape(panel.title)}"></div>'
        f'<script type="application/json" data-plot="{escape(name)}">'
        f"{plot_json(panel, points=points)}</script></figure>\n"
    )


def verdict(run: Run, summary: Summary, name: str = "") -> str:
    """Return a paragraph on whether to trust the run: failed decisions and passed limits."""
    who = f"<strong>{escape(name)}</strong>: " if name else ""
    failed, passed = failures(summary), breaches(summary)
    made = "are optimal" if run.residual.any() else "were made"
    parts = failed or [f"all {len(run.status):,} decisions {made}"]
    parts += passed or (["all limits were kept at every node"] if "limits" in summary else [])
    held = held_back(summary)
    text = escape("; ".join([*parts, *between_nodes(summary), *held]))
    best = best_in_words(summary)
    beside = f" {escape(best[0].upper() + best[1:])}." if best else ""
    mood = "warn" if failed or summary.get("violations") else "mild" if passed or held else "good"
    return f'<p class="{mood}">{who}{text[0].upper()}{text[1:]}.{beside}</p>'


def decimation(runs: Sequence[Run]) -> str:
    """Return a note that not all samples are drawn; empty if all are."""
    if not any(decimated(run) for run in runs):
        return ""
    longest = max(run.samples for run in runs)
    return (
        f'<p class="note">A curve has up to {number(longest)} samples, of which at most {number(MAX_POINTS)} '
        "are drawn, fewer where there are many curves, chosen so that the lowest and the highest of every "
        "stretch are kept. Figures are of all samples.</p>"
    )


def record(run: Run) -> dict[str, object]:
    """Return what is needed to repeat a run."""
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "platform": run.platform.name,
        "plant": run.plant,
        "dofs": ",".join(run.dofs),
        "settings": run.settings,
    }


def settings_text(settings: Mapping[str, object]) -> str:
    """Return the settings as formatted JSON."""
    text = json.dumps(settings, indent=2, ensure_ascii=False, default=str)
    return f"<p>What was chosen, so that it can be run again.</p><pre>{escape(text)}</pre>"
