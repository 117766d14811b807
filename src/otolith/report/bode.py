"""Results of the motion cueing test: a Bode figure for a paper, a page, and plain JSON values."""

import io
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from otolith.core.arrays import Bools, Vec
from otolith.metrics.boundaries import Boundary
from otolith.metrics.frequency_response import Response
from otolith.report.page import Part, page, table
from otolith.report.palette import BLUE, GREEN, VERMILION
from otolith.scenarios.cueing_tests import MotionTest

WIDTH: Final = 7.0  # [in] width of two columns
ROW: Final = 1.55  # [in] height of the row of one test
FONT: Final = 7.5  # [pt]

Boundaries = Mapping[str, Boundary]


def by_test(responses: Sequence[Response]) -> dict[MotionTest, list[Response]]:
    """Group responses by test, in their order."""
    found: dict[MotionTest, list[Response]] = {}
    for response in responses:
        found.setdefault(response.test, []).append(response)
    return found


def known(value: float) -> float | None:
    """Replace NaN, which JSON does not have, by None."""
    return None if math.isnan(value) else value


def omct_json(responses: Sequence[Response], boundaries: Boundaries) -> list[dict[str, Any]]:
    """Return one entry per test with a list per quantity; None where a value is undefined."""
    return [
        {
            "test": test.number,
            "name": test.name,
            "unit": test.unit,
            "omega_radps": [r.omega for r in of_test],
            "modulus": [r.modulus for r in of_test],
            "modulus_uncertainty": [r.modulus_uncertainty for r in of_test],
            "phase_deg": [known(r.phase_deg) for r in of_test],
            "phase_uncertainty_deg": [known(r.phase_uncertainty_deg) for r in of_test],
            "distortion": [known(r.distortion) for r in of_test],
            "within_boundaries": [_verdict(r, boundaries) for r in of_test],
        }
        for test, of_test in by_test(responses).items()
    ]


def omct_figure(responses: Sequence[Response], boundaries: Boundaries, *, width: float = WIDTH) -> Figure:
    """Draw modulus and phase over frequency, one row per test, with boundaries shaded if there are any."""
    tests = by_test(responses)
    figure = Figure(figsize=(width, ROW * len(tests) + 0.4), layout="constrained")
    grid = figure.subplots(len(tests), 2, squeeze=False, sharex=True)
    for (left, right), (test, of_test) in zip(grid, tests.items(), strict=True):
        boundary = boundaries.get(test.name)
        _modulus(left, test, of_test, boundary)
        _phase(right, of_test, boundary)
    for ax in grid[-1]:
        ax.set_xlabel("frequency [rad/s]", fontsize=FONT)
    return figure


def omct_page(
    title: str, facts: Mapping[str, str], responses: Sequence[Response], boundaries: Boundaries
) -> str:
    """Return a self-contained page with the figure, all numbers, and their meaning."""
    entries = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in facts.items())
    tables = "".join(_table(test, of_test, boundaries) for test, of_test in by_test(responses).items())
    parts = [
        Part("Modulus and phase", f'<div class="drawing">{_svg(omct_figure(responses, boundaries))}</div>'),
        Part("What it says", f"<p>{LEAD}</p>"),
        Part("In numbers", tables, folded=True),
        Part("How it was made", f'<dl class="facts">{entries}</dl>', folded=True),
    ]
    lines = " · ".join(
        f"{escape(k)}: <strong>{escape(v)}</strong>" for k, v in facts.items() if k != "cueing"
    )
    lead = f'<p class="lead">{lines}</p>'
    return page(title, "Objective motion cueing test", lead, parts, styles=("platform.css",))


LEAD: Final = (
    "One axis at a time is driven by a sinusoid, at twelve frequencies. The modulus says how much of it the "
    "driver feels, the phase how late (negative) or early. Bars show how far any measured period was from "
    "the mean: long ones mean that the motion had not settled. Distortion is what is felt in addition to the "
    "sinusoid; an algorithm that meets a limit distorts, and its modulus then holds for this amplitude only."
)


def _modulus(ax: Axes, test: MotionTest, of_test: Sequence[Response], boundary: Boundary | None) -> None:
    felt = _felt(of_test)
    modulus = np.where(felt, [r.modulus for r in of_test], np.nan)
    error = np.array([r.modulus_uncertainty for r in of_test])
    ax.set_yscale("log")
    # an error bar down to zero has no place on a logarithmic axis
    _points(ax, of_test, modulus, np.stack([np.minimum(error, 0.9 * modulus), error]))
    low, high = (np.min(modulus[felt]), np.max((modulus + error)[felt])) if felt.any() else (0.1, 1.0)
    ax.set_ylim(low / 1.5, 1.5 * max(high, 5.0 * low))
    if boundary is not None:
        _shade(ax, boundary.omega, boundary.modulus_low, boundary.modulus_high)
    ax.yaxis.set_minor_formatter(NullFormatter())
    unit = f" [{test.unit}]" if test.unit else ""
    ax.set_ylabel(f"modulus{unit}", fontsize=FONT)
    ax.set_title(f"{test.number}  {test.name}", fontsize=FONT + 1, loc="left")


def _phase(ax: Axes, of_test: Sequence[Response], boundary: Boundary | None) -> None:
    felt = _felt(of_test)
    phase = np.array([r.phase_deg for r in of_test])
    phase[felt] = np.unwrap(phase[felt], period=360.0)
    error = np.array([r.phase_uncertainty_deg for r in of_test])
    _points(ax, of_test, phase, np.stack([error, error]))
    if not felt.any():
        ax.set_ylim(-180.0, 180.0)
    if boundary is not None:
        _shade(ax, boundary.omega, boundary.phase_low_deg, boundary.phase_high_deg)
    ax.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 1.5, 3, 4.5, 9, 10]))
    ax.set_ylabel("phase [deg]", fontsize=FONT)


def _felt(of_test: Sequence[Response]) -> Bools:
    """Return at which frequencies anything is felt; only those have a phase and a logarithm."""
    return np.isfinite([r.phase_deg for r in of_test])


def _points(ax: Axes, of_test: Sequence[Response], values: Vec, error: Vec) -> None:
    omega = [r.omega for r in of_test]
    if not _felt(of_test).any():
        ax.text(0.5, 0.5, "nothing is felt", transform=ax.transAxes, ha="center", fontsize=FONT)
        ax.set_xlim(0.9 * omega[0], 1.1 * omega[-1])
    ax.errorbar(
        omega, values, yerr=error, fmt="o-", color=BLUE, ecolor=VERMILION, ms=2.6, lw=1.0, elinewidth=1.0
    )
    ax.set_xscale("log")
    ax.grid(visible=True, which="major", color="#dddddd", linewidth=0.4)
    ax.tick_params(which="both", labelsize=FONT, width=0.5, length=2.5)


def _shade(ax: Axes, omega: Vec, low: Vec, high: Vec) -> None:
    """Shade the region inside a boundary; a side without a bound reaches to the end of the axis."""
    bottom, top = ax.get_ylim()
    finite = [*low[np.isfinite(low)], *high[np.isfinite(high)]]
    bottom, top = min([bottom, *finite]), max([top, *finite])
    ax.fill_between(omega, np.maximum(low, bottom), np.minimum(high, top), color=GREEN, alpha=0.15, lw=0)
    ax.set_ylim(bottom, top)


def _table(test: MotionTest, of_test: Sequence[Response], boundaries: Boundaries) -> str:
    unit = f" [{test.unit}]" if test.unit else ""
    heads = ["Frequency [rad/s]", f"Modulus{unit}", "Phase [deg]", "Distortion"]
    heads += ["Within boundaries"] if test.name in boundaries else []
    rows = [
        (first, [f"<td>{cell}</td>" for cell in cells])
        for first, *cells in (_row(r, boundaries) for r in of_test)
    ]
    return f'<h3>{test.number} {escape(test.name)}</h3><div class="wide">{table("models", heads, rows)}</div>'


def _row(r: Response, boundaries: Boundaries) -> list[str]:
    phase = "–" if math.isnan(r.phase_deg) else f"{r.phase_deg:.2f} ± {r.phase_uncertainty_deg:.2g}"
    distortion = "–" if math.isnan(r.distortion) else f"{100.0 * r.distortion:.2g} %"
    cells = [f"{r.omega:.3f}", f"{r.modulus:.4g} ± {r.modulus_uncertainty:.1g}", phase, distortion]
    if r.test.name in boundaries:
        cells.append({True: "yes", False: "<strong>no</strong>", None: "–"}[_verdict(r, boundaries)])
    return [cell.replace("-", "−") for cell in cells]


def _verdict(response: Response, boundaries: Boundaries) -> bool | None:
    boundary = boundaries.get(response.test.name)
    return None if boundary is None else boundary.holds(response)


def _svg(figure: Figure) -> str:
    """Return the figure as an SVG element; equal figures give equal text."""
    text = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "otolith"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]
