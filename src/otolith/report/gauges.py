"""Key figures of a run as a row of cards, on the scales that `otolith.metrics` defines."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from otolith.metrics import MEASURES, Reading, Scale
from otolith.metrics.measure import Summary

DOCS: Final = "docs/metrics.md"


@dataclass(frozen=True, slots=True)
class Gauge:
    """One figure on its scale."""

    scale: Scale
    reading: Reading
    section: str  # heading of `DOCS` that defines it


def gauges(summary: Summary) -> Sequence[Gauge]:
    """Return a gauge for each measure that has a scale and is in the summary."""
    scaled = [(measure, measure.scale) for measure in MEASURES.values() if measure.scale is not None]
    read = [(measure.section, scale, scale.read(summary)) for measure, scale in scaled]
    return [Gauge(scale, reading, section) for section, scale, reading in read if reading is not None]


def gauges_html(summary: Summary) -> str:
    """Return the gauges as a row of cards."""
    return f'<div class="gauges">{"".join(map(_card, gauges(summary)))}</div>'


def _card(gauge: Gauge) -> str:
    scale, reading = gauge.scale, gauge.reading
    place = 100.0 * min(1.0, max(0.0, reading.share)) if math.isfinite(reading.share) else 100.0
    beyond = " beyond" if not reading.share <= 1.0 else ""
    left, right = (escape(end) for end in scale.ends)
    return (
        f'<div class="gauge"><h3>{escape(scale.title)}</h3><p class="value">{escape(reading.value)}</p>'
        f'<div class="scale{beyond}" role="img" aria-label="{place:.0f} % of the way from {left} to {right}">'
        f'<i style="width: {place:.1f}%"></i></div>'
        f'<p class="ends"><span>{left}</span><span>{right}</span></p>'
        f"<details><summary>What it says</summary><p>{escape(reading.words)}</p>"
        f"<p>{DOCS}, “{escape(gauge.section)}”</p></details></div>"
    )
