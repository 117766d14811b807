"""Pages that compare several algorithms on one or several scenarios: the ranking, its rule, its reasons."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Final

from otolith.loop import Run
from otolith.metrics.measure import Summary
from otolith.report import tables, texts
from otolith.report.html import (
    DRAWN,
    diagrams,
    facts,
    points_each,
    record,
    settings_text,
    verdict,
)
from otolith.report.motion import motion_comparison
from otolith.report.overview import false_cue_panels, overview_panels, trade_panel, use_panel
from otolith.report.page import Part, page, table
from otolith.report.panels import Panel, changes_panel, require_one_scenario
from otolith.report.ranking import ByCueing, Criterion, Standing, criterion_named, standings
from otolith.report.reasons import why
from otolith.report.series import labels

RMSE: Final = criterion_named("rmse")


def render_comparison(
    runs: Sequence[Run],
    summaries: Sequence[Summary] | Mapping[str, Summary],
    *,
    by: Criterion = RMSE,
    date: str = "",
    best: Run | None = None,
) -> str:
    """Return the page of several algorithms on one scenario.

    Parameters
    ----------
    summaries : key figures of each run, in the order of `runs`, or by the name of the cueing.
    by : the criterion of the ranking.
    best : the best that is possible on this scenario, drawn with them.

    Raises
    ------
    ValueError : there is no run, the runs are not of one scenario, or a summary is missing.
    """
    require_one_scenario(runs)
    if isinstance(summaries, Mapping):
        summaries = [summaries[run.cueing] for run in runs if run.cueing in summaries]
    if len(runs) != len(summaries):
        raise ValueError(f"{len(runs)} runs need as many summaries, got {len(summaries)}")
    by_name = dict(zip(labels(runs), summaries, strict=True))
    first = runs[0]
    scenarios = {first.scenario: by_name}
    ranked = standings(scenarios, by)
    groups = _diagrams_of(runs, best)
    trade, effort = trade_panel(by_name, by), changes_panel(runs)
    points = points_each([panel for _, _, panels in groups for panel in panels])
    parts = [
        Part("Who is best, and why", _why(scenarios, ranked, by) + diagrams("ranking", [trade])),
        Part("Side by side", tables.headline(list(by_name), summaries) + _verdicts(runs, summaries)),
        *(
            Part(title, diagrams(key, panels, points=points), folded=k > 0)
            for k, (key, title, panels) in enumerate(groups)
        ),
        Part("The solver’s effort", diagrams("effort", [effort]), folded=True),
        Part("The rule and the ranking", ranking_table(ranked, scenarios, by), folded=True),
        Part("All key figures", tables.side_by_side(list(by_name), summaries), folded=True),
        Part("How it was made", facts(runs, date) + settings_text(_records(runs)), folded=True),
    ]
    lead = f'<p class="lead">Compared: {_strong(by_name)}.</p>'
    return page(first.scenario, "Comparison", lead, parts, scripts=DRAWN)


def render_contest(
    contest: Mapping[str, tuple[Sequence[Run], ByCueing]],
    *,
    by: Criterion = RMSE,
    date: str = "",
    best: Mapping[str, Run | None] | None = None,
) -> str:
    """Return the page of several algorithms on several scenarios.

    Parameters
    ----------
    contest : runs and summaries by the name of the scenario; every scenario has the same algorithms.
    by : the criterion of the ranking.
    best : the best that is possible on each scenario, by its name, drawn with them.
    """
    summaries = {scenario: of_one for scenario, (_, of_one) in contest.items()}
    ranked = standings(summaries, by)
    everything = [run for runs, _ in contest.values() for run in runs]
    groups = {
        scenario: _diagrams_of(runs, (best or {}).get(scenario)) for scenario, (runs, _) in contest.items()
    }
    points = points_each([p for of_one in groups.values() for _, _, panels in of_one for p in panels])
    trades = [trade_panel(of_one, by, of=scenario) for scenario, of_one in summaries.items()]
    glance = "".join(diagrams(f"s{number}", [panel]) for number, panel in enumerate(trades))
    glance += diagrams("all", overview_panels(summaries))
    parts = [
        Part("Who is best, and why", _why(summaries, ranked, by) + ranking_table(ranked, summaries, by)),
        Part("At a glance", f'<div class="small">{glance}</div>'),
    ]
    for number, (scenario, (runs, of_one)) in enumerate(contest.items()):
        ordered = [of_one[run.cueing] for run in runs]
        body = tables.headline(list(of_one), ordered) + _verdicts(runs, ordered)
        body += "".join(
            f'<h3 class="dof">{escape(title)}</h3>{diagrams(f"s{number}-{key}", panels, points=points)}'
            for key, title, panels in groups[scenario]
        )
        every = tables.side_by_side(list(of_one), ordered)
        body += f"<details><summary>All key figures</summary>{every}</details>"
        parts.append(Part(scenario, body, folded=True))
    made = facts(everything, date) + settings_text(_records(everything[: len(ranked)]))
    parts.append(Part("How it was made", made, folded=True))
    lead = f'<p class="lead">Compared: {_strong([one.cueing for one in ranked])} on {_strong(contest)}.</p>'
    title = f"{len(ranked)} algorithms on {len(contest)} scenarios"
    return page(title, "Comparison", lead, parts, scripts=DRAWN)


def _why(scenarios: Mapping[str, ByCueing], ranked: Sequence[Standing], by: Criterion) -> str:
    """Return the reasons for the ranking, as a list."""
    return (
        f'<ul class="why">{"".join(f"<li>{escape(text)}</li>" for text in why(scenarios, ranked, by))}</ul>'
    )


def ranking_table(ranked: Sequence[Standing], scenarios: Mapping[str, ByCueing], by: Criterion) -> str:
    """Return a table of the ranking, with rank and value per scenario, and the rule below it."""
    several, summaries = len(scenarios) > 1, list(scenarios.values())
    heads = ["Cueing", *(["Mean rank", "Wins"] if several else []), *scenarios]
    rows = []
    for one in ranked:
        cells = [f"<td>{one.mean_rank:.2f}</td>", f"<td>{one.wins}</td>"] if several else []
        for k, (rank, value, broken) in enumerate(zip(one.ranks, one.values, one.broken, strict=True)):
            shared = sum(other.ranks[k] == rank for other in ranked) > 1
            note = f"hard limits passed {tables.number(broken)}×, " if broken else ""
            note += f"rank {rank}{', tied' if shared else ''}{_beside_the_best(summaries[k][one.cueing], by)}"
            kind = " class=out" if broken else (" class=best" if rank == 1 else "")
            cells.append(f"<td{kind}>{tables.number(by.shown(value))}<small>{note}</small></td>")
        rows.append((escape(one.cueing), cells))
    rule = (
        f'<p class="note">{escape(by.label)} in each cell, {by.better} is better. '
        f"{texts.RULE}{texts.RULE_OVERALL if several else ''}</p>"
    )
    return f'<div class="wide">{table("models", heads, rows)}</div>{rule}'


def _beside_the_best(summary: Summary, by: Criterion) -> str:
    """Return how far a tracking error is from the best that is possible; empty if that is not known."""
    times = summary.get("optimum", {}).get("times")
    return f", {times:.2f} × the best" if times and by.measure.name in ("rmse", "rate_rmse") else ""


def _diagrams_of(runs: Sequence[Run], best: Run | None) -> list[tuple[str, str, list[Panel]]]:
    """Return name, title and panels of each degree of freedom that all runs share, and of the reach."""
    shared = [dof for dof in runs[0].dofs if all(dof in run.dofs for run in runs)]
    found = [
        (dof, texts.DOFS[dof], [*motion_comparison(runs, dof, best), *false_cue_panels(runs, dof)])
        for dof in shared
    ]
    return [*found, ("reach", "The platform’s reach", [use_panel(runs)])]


def _verdicts(runs: Sequence[Run], summaries: Sequence[Summary]) -> str:
    every = zip(labels(runs), runs, summaries, strict=True)
    return "".join(verdict(run, summary, name) for name, run, summary in every)


def _records(runs: Sequence[Run]) -> dict[str, object]:
    return {name: record(run) for name, run in zip(labels(runs), runs, strict=True)}


def _strong(names: Mapping[str, object] | Sequence[str]) -> str:
    return ", ".join(f"<strong>{escape(name)}</strong>" for name in names)
