"""The page of a study: what was tried, the settings that no others beat, and presets with their commands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.report import palette
from otolith.report.html import DRAWN, diagrams
from otolith.report.page import Part, page, table
from otolith.report.panels import Axis, Curve, Panel

_KEPT: Final = (palette.VERMILION, palette.GREEN, palette.PURPLE, palette.ORANGE)


@dataclass(frozen=True, kw_only=True)
class Best:
    """One trial that no other beats."""

    number: int
    values: tuple[float, ...]  # of the objectives, on what was trained on
    judged: tuple[float, ...] | None  # on what was held out, if it is known
    settings: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Found:
    """What a study found, as its page shows it."""

    name: str
    description: str
    objectives: Mapping[str, str]  # what each is in words, with its unit, by name
    tried: Mat  # (n, k) values of all trials that keep the constraints
    best: tuple[Best, ...]  # in order of the first objective
    presets: Mapping[str, int]  # number of the trial of each
    commands: Mapping[str, str]  # that make the settings of each preset
    said: str  # how many trials there were, and whether the loop was checked


def render_study(found: Found) -> str:
    """Return the page; every other objective is drawn against the first."""
    panels = [_panel(found, k) for k in range(1, len(found.objectives))]
    parts = [
        Part("What costs what", diagrams("front", panels)),
        Part("Presets", _presets(found)),
        Part("Settings that no others beat", _values(found)),
        Part("Their settings", _settings(found), folded=True),
    ]
    lead = f'<p class="lead">{escape(found.description)}</p><p class="note">{escape(found.said)}</p>'
    return page(found.name, "Study", lead, [part for part in parts if part.body], scripts=DRAWN, contents="")


def _panel(found: Found, k: int) -> Panel:
    """Return a diagram of objective k against the first."""
    names = list(found.objectives)
    first, other = names[0], names[k]
    said = f"{first}: {found.objectives[first]}; {other}: {found.objectives[other]}"
    front = np.array([one.values for one in found.best]).reshape(-1, len(found.objectives))
    places = {one.number: row for one, row in zip(found.best, front, strict=True)}
    curves = [
        _marks("tried", found.tried[:, 0], found.tried[:, k], palette.GREY, "dots"),
        _marks("no other is better", front[:, 0], front[:, k], palette.BLUE, "dots"),
    ]
    for place, (name, number) in enumerate(found.presets.items()):
        row = places[number]
        color = _KEPT[place % len(_KEPT)]
        curves.append(_marks(f"{name}: trial {number}", row[:1], row[k : k + 1], color, "marks"))
    return Panel(
        key=f"front-{k}",
        title=f"{other} against {first}",
        axes=(Axis(label=other, span=_span(found.tried[:, k])),),
        curves=tuple(curves),
        x_label=first,
        x_span=_span(found.tried[:, 0]),
        words=f"Each dot is one set of settings within all constraints, and less is better; {said}.",
    )


def _marks(label: str, x: Vec, y: Vec, color: str, kind: str) -> Curve:
    return Curve(label=label, x=x, y=y, color=color, kind="marks" if kind == "marks" else "dots")


def _span(values: Vec) -> tuple[float, float]:
    low, high = (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 1.0)
    room = 0.06 * ((high - low) or 1.0)
    return low - room, high + room


def _presets(found: Found) -> str:
    rows = [
        (escape(name), [_cell(str(number)), f"<td><code>{escape(found.commands[name])}</code></td>"])
        for name, number in found.presets.items()
    ]
    return table("figures", ["preset", "trial", "made by"], rows) if rows else ""


def _values(found: Found) -> str:
    judged = [f"{name}, judged" for name in found.objectives if any(one.judged for one in found.best)]
    rows = [
        (str(one.number), [_number(v) for v in (*one.values, *_shown(one.judged, len(judged)))])
        for one in found.best
    ]
    return table("figures", ["trial", *found.objectives, *judged], rows)


def _shown(judged: Sequence[float] | None, count: int) -> Sequence[float | None]:
    return [None] * count if judged is None else judged


def _settings(found: Found) -> str:
    names = list(found.best[0].settings) if found.best else []
    rows = [(str(one.number), [_cell(one.settings[name]) for name in names]) for one in found.best]
    return table("figures", ["trial", *names], rows)


def _number(value: float | None) -> str:
    return _cell("–" if value is None else f"{value:.4f}")


def _cell(text: str) -> str:
    return f"<td>{escape(text)}</td>"
