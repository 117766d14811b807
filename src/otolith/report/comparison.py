"""Several algorithms on one scenario, or on many, as one page: who did best by which rule, and why."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Final

from otolith.report import tables, texts
from otolith.report.html import (
    decimation,
    diagrams,
    facts,
    page,
    record,
    section,
    settings_text,
    verdict,
)
from otolith.report.motion import motion_comparison
from otolith.report.overview import false_cue_panels, overview_panels, use_panel
from otolith.report.panels import Panel, changes_panel, require_one_scenario
from otolith.report.ranking import MEASURES, ByCueing, Measure, Standing, standings
from otolith.report.series import labels
from otolith.report.tables import Summary
from otolith.simulate import Run

RMSE: Final = MEASURES["rmse"]


def render_comparison(
    runs: Sequence[Run],
    summaries: Sequence[Summary] | Mapping[str, Summary],
    *,
    by: Measure = RMSE,
    date: str = "",
) -> str:
    """Page of several algorithms on one scenario.

    Parameters
    ----------
    summaries : key figures of each run, in the order of `runs`, or by the name of the cueing.
    by : what is ranked by.

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
    sections = [
        section("Ranking", ranking_table(standings({first.scenario: by_name}, by), [first.scenario], by)),
        section("Comparison", tables.headline(list(by_name), summaries) + _verdicts(runs, summaries)),
        *(section(title, diagrams(key, panels)) for key, title, panels in _diagrams_of(runs)),
        section("The solver’s effort", diagrams("effort", [changes_panel(runs)])),
        section("All key figures", tables.side_by_side(list(by_name), summaries)),
        section("Settings", settings_text(_records(runs))),
    ]
    lead = f"Compared: {_strong(by_name)}."
    return page(first.scenario, "Comparison", lead, facts(first, date) + decimation(runs), sections)


def render_contest(
    contest: Mapping[str, tuple[Sequence[Run], ByCueing]], *, by: Measure = RMSE, date: str = ""
) -> str:
    """Page of several algorithms on several scenarios.

    Parameters
    ----------
    contest : runs and summaries of every scenario, by its name; all with the same algorithms.
    by : what is ranked by.
    """
    summaries = {scenario: of_one for scenario, (_, of_one) in contest.items()}
    ranked = standings(summaries, by)
    everything = [run for runs, _ in contest.values() for run in runs]
    sections = [
        section("Ranking", ranking_table(ranked, list(contest), by)),
        section("At a glance", f'<div class="small">{diagrams("all", overview_panels(summaries))}</div>'),
    ]
    for number, (scenario, (runs, of_one)) in enumerate(contest.items()):
        ordered = [of_one[run.cueing] for run in runs]
        body = tables.headline(list(of_one), ordered) + _verdicts(runs, ordered)
        body += "".join(
            f'<h3 class="dof">{escape(title)}</h3>{diagrams(f"s{number}-{key}", panels)}'
            for key, title, panels in _diagrams_of(runs)
        )
        sections.append(section(scenario, body))
    for scenario, (_, of_one) in contest.items():
        title = f"All key figures: {scenario}"
        sections.append(section(title, tables.side_by_side(list(of_one), list(of_one.values()))))
    sections.append(section("Settings", settings_text(_records(everything[: len(ranked)]))))
    lead = f"Compared: {_strong([one.cueing for one in ranked])} on {_strong(contest)}."
    head = facts(everything[0], date) + decimation(everything)
    title = f"{len(ranked)} algorithms on {len(contest)} scenarios"
    return page(title, "Comparison", lead, head, sections)


def ranking_table(ranked: Sequence[Standing], scenarios: Sequence[str], by: Measure) -> str:
    """The order, with rank and measure per scenario, and the rule that made it."""
    several = len(scenarios) > 1
    heads = ["Cueing", *(["Mean rank", "Wins"] if several else []), *scenarios]
    rows = []
    for one in ranked:
        cells = [f"<td>{one.mean_rank:.2f}</td><td>{one.wins}</td>"] if several else []
        for rank, value, broken in zip(one.ranks, one.values, one.broken, strict=True):
            note = f"limits broken {tables.number(broken)}×" if broken else f"rank {rank}"
            kind = " class=out" if broken else (" class=best" if rank == 1 else "")
            cells.append(f"<td{kind}>{tables.number(value)}<small>{note}</small></td>")
        rows.append(f'<tr><th scope="row">{escape(one.cueing)}</th>{"".join(cells)}</tr>')
    head = "".join(f'<th scope="col">{escape(text)}</th>' for text in heads)
    rule = (
        f"<p>{escape(by.words)} [{escape(by.unit)}] in each cell, smaller is better. {texts.RULE}"
        f"{texts.RULE_OVERALL if several else ''}</p>"
    )
    table = f'<table class="models"><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table>'
    return rule + f'<div class="wide">{table}</div>'


def _diagrams_of(runs: Sequence[Run]) -> list[tuple[str, str, list[Panel]]]:
    """Name, title and panels of every degree of freedom that all runs share, and of the reach."""
    shared = [dof for dof in runs[0].dofs if all(dof in run.dofs for run in runs)]
    found = [
        (dof, texts.DOFS[dof], [*motion_comparison(runs, dof), *false_cue_panels(runs, dof)])
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
