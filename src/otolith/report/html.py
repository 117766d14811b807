"""One run as one HTML page that needs nothing else, no network, no files; and what every page is made of."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files

from plotly.offline import get_plotlyjs

from otolith.metrics import breaches, failures
from otolith.report import tables, texts
from otolith.report.motion import motion_panels
from otolith.report.panels import Panel, effort_panels
from otolith.report.plots import height, plot_json
from otolith.report.series import MAX_POINTS, decimated
from otolith.report.tables import Summary, number
from otolith.report.view import frames_of, platform_view
from otolith.simulate import Run

LEGGED = "hexapod"  # how the names of plants with legs begin, see otolith.registry
MOVING = (
    "Drag the picture to turn it. Legs turn from blue, short, over green to red, long; the dot is the head."
)


def render(run: Run, summary: Summary, *, date: str = "") -> str:
    """Page of one run.

    Parameters
    ----------
    summary : key figures, plain JSON values by name, nested as liked; see `otolith.metrics.summarise`.
    date : when the run was made, as it should read.
    """
    sections = [section("Key figures", verdict(run, summary) + tables.key_figures(summary))]
    sections += [section(texts.DOFS[dof], diagrams(dof, motion_panels(run, dof))) for dof in run.dofs]
    if run.plant.startswith(LEGGED):
        view = platform_view(run.platform.six_legs(), *frames_of(run))
        sections.append(section("The platform in motion", f'<p class="note">{MOVING}</p>{view}'))
    sections.append(section("The solver’s effort", diagrams("effort", effort_panels(run))))
    sections.append(section("Settings", settings_text(record(run))))
    lead = (
        f"Cued by <strong>{escape(run.cueing)}</strong> on platform "
        f"<strong>{escape(run.platform.name)}</strong>."
    )
    return page(run.scenario, "Run report", lead, facts(run, date) + decimation([run]), sections)


def page(title: str, kind: str, lead: str, facts: str, sections: Sequence[str]) -> str:
    """A whole page; everything but the title is HTML."""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)} – Otolith</title>
<style>{_asset("page.css")}{_asset("platform.css")}</style>
</head>
<body>
<header>
<p class="kind">Otolith <span>{escape(kind)}</span></p>
<h1>{escape(title)}</h1>
<p class="lead">{lead}</p>
{facts}
</header>
<main>
<noscript><p class="warn">The diagrams need JavaScript; the figures in the tables do not.</p></noscript>
{"".join(sections)}
</main>
<footer>Made by Otolith. SI units, with degrees in the diagrams. This page is complete in itself.</footer>
<script>{get_plotlyjs()}</script>
<script>{_asset("page.js")}</script>
</body>
</html>
"""


@cache
def _asset(name: str) -> str:
    return (files("otolith.report") / "assets" / name).read_text(encoding="utf-8")


def facts(run: Run, date: str) -> str:
    """What a run was made with, as a list."""
    steps = len(run.command_time)
    known = {
        "platform": run.platform.name,
        "plant": run.plant,
        "degrees of freedom": f"{2 * len(run.pairs) + len(run.singles)} ({', '.join(run.dofs)})",
        "duration": f"{steps * run.period:.4g} s, {number(steps)} steps",
        "controller period": f"{1e3 * run.period:.4g} ms",
        "plant period": f"{1e3 * run.plant_period:.4g} ms",
        "date": date,
    }
    entries = (f"<div><dt>{k}</dt><dd>{escape(v)}</dd></div>" for k, v in known.items() if v)
    return f'<dl class="facts">{"".join(entries)}</dl>'


def section(title: str, body: str) -> str:
    """A titled part of a page."""
    return f"<section><h2>{escape(title)}</h2>{body}</section>\n"


def diagrams(prefix: str, panels: Sequence[Panel]) -> str:
    """Interactive diagrams below each other; the prefix makes their names unique on the page."""
    return "".join(_diagram(f"{prefix}-{panel.key}", panel) for panel in panels)


def _diagram(name: str, panel: Panel) -> str:
    linked = " data-linked" if panel.over_time else ""
    return (
        f"<figure><figcaption><h3>{escape(panel.title)}</h3><p>{texts.PANELS[panel.key]}</p></figcaption>"
        f'<div class="plot" style="min-height: {height(panel)}px" id="{escape(name)}"{linked} role="img" '
        f'aria-label="{escape(panel.title)}"></div>'
        f'<script type="application/json" data-plot="{escape(name)}">{plot_json(panel)}</script></figure>\n'
    )


def verdict(run: Run, summary: Summary, name: str = "") -> str:
    """Whether to trust the run, in one sentence: statuses and limits."""
    who = f"<strong>{escape(name)}</strong>: " if name else ""
    said = "; ".join([*failures(summary), *breaches(summary)])
    if said:
        return f'<p class="warn">{who}{escape(said[0].upper() + said[1:])}.</p>'
    made = "are optimal" if run.residual.any() else "were made"
    kept = "; all limits were kept at every node" if "limits" in summary else ""
    return f'<p class="good">{who}All {number(len(run.status))} decisions {made}{kept}.</p>'


def decimation(runs: Sequence[Run]) -> str:
    """Whether some of the samples are not drawn, in words."""
    if not any(decimated(run) for run in runs):
        return ""
    longest = max(len(run.time) for run in runs)
    return (
        f'<p class="note">A curve has up to {number(longest)} samples, of which at most {number(MAX_POINTS)} '
        "are drawn, chosen so that the lowest and the highest of every stretch are kept. "
        "Key figures are of all samples.</p>"
    )


def record(run: Run) -> dict[str, object]:
    """What is needed to repeat a run."""
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "platform": run.platform.name,
        "plant": run.plant,
        "dofs": ",".join(run.dofs),
        "settings": run.settings,
    }


def settings_text(settings: Mapping[str, object]) -> str:
    """Settings as they stand in a file."""
    text = json.dumps(settings, indent=2, ensure_ascii=False, default=str)
    return f"<p>What was chosen, so that it can be run again.</p><pre>{escape(text)}</pre>"
