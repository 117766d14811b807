"""A platform made visible: its legs, what they reach, how firmly they stand, and a run in motion."""

import io
import math
from html import escape
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.plant.dynamics import frequencies
from otolith.platforms import Platform
from otolith.platforms.fit import table_of
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.reach import CUTS, Cut, box_share, cut, reach
from otolith.platforms.together import together
from otolith.report.page import Part, page, table
from otolith.report.palette import BLUE, GREY, ORANGE, VERMILION
from otolith.report.view import FRAMES_PER_SECOND, frames_of, platform_view
from otolith.simulate import Run

WIDTH: Final = 7.16  # [in] both columns of a paper
FONT: Final = 7.0  # [pt]
SWEEP: Final = 2.4  # [s] of each axis in the tour of a platform


def _shown(axis: str) -> tuple[float, str]:
    """Factor and unit in which an axis is shown."""
    return (180.0 / np.pi, "deg") if AXES.index(axis) >= 3 else (1.0, "m")


def platform_summary(platform: Platform) -> dict[str, Any]:
    """What the legs reach and how they stand, as plain JSON values; degrees where a name says so.

    Raises
    ------
    InputError : the platform's file describes no legs.
    """
    hexapod, table = platform.six_legs(), table_of(platform)
    ranges = {}
    for axis, ends in reach(hexapod).items():
        factor, unit = _shown(axis)
        entry = {f"reach_{unit}": [factor * end for end in ends]}
        if axis in table:
            entry[f"file_{unit}"] = [factor * end for end in table[axis]]
        ranges[axis] = entry
    neutral = hexapod.lengths(np.zeros(6))
    return {
        "platform": platform.name,
        "ranges": ranges,
        "neutral_lengths_m": neutral.tolist(),
        "leg_stroke_m": list(hexapod.stroke),
        "condition_neutral": hexapod.condition(np.zeros(6)),
        "reachable_share_of_box": box_share(hexapod),
        "together": _together(platform),
        "servo_frequencies_hz": frequencies(hexapod).tolist(),
    }


def _together(platform: Platform) -> dict[str, float] | None:
    """What four axes can do in every combination; None where the file lacks a limit of theirs."""
    try:
        found = together(platform)
    except InputError:
        return None
    return {
        "reach_share": found.reach,
        "speed_share": found.speed,
        "acceleration_share": found.acceleration,
        "circle_m": found.circle,
        "tilt_deg": math.degrees(found.tilt),
        "velocity_mps": found.velocity,
        "tilt_rate_degps": math.degrees(found.tilt_rate),
        "acceleration_mps2": found.translation,
        "tilt_acceleration_degps2": math.degrees(found.tilt_acceleration),
    }


def together_sentence(summary: dict[str, Any]) -> str:
    """What four axes can do in every combination, in one sentence; empty where the file does not tell."""
    all_at_once = summary["together"]
    if all_at_once is None:
        return ""
    return (
        "Surge, sway, roll and pitch in every combination: {circle_m:.3f} m around neutral with "
        "±{tilt_deg:.2f} deg, {velocity_mps:.3f} m/s, {tilt_rate_degps:.1f} deg/s, "
        "{acceleration_mps2:.2f} m/s², {tilt_acceleration_degps2:.0f} deg/s²."
    ).format(**all_at_once)


def platform_figure(platform: Platform) -> Figure:
    """The legs in the neutral pose, the range of each axis alone, and cuts across two axes."""
    hexapod = platform.six_legs()
    figure = Figure(figsize=(WIDTH, 6.6), layout="constrained")
    grid = figure.add_gridspec(3, 3, height_ratios=[1.25, 1.0, 1.0])
    _drawing(figure.add_subplot(grid[0, 0], projection="3d"), hexapod)
    _ranges(figure.add_subplot(grid[0, 1:]), platform, hexapod)
    cuts = [cut(hexapod, axes) for axes in CUTS]
    highest = max(float(np.nanmax(one.condition)) for one in cuts)
    scale = Normalize(1.0, highest)
    panels = [figure.add_subplot(grid[1 + k // 3, k % 3]) for k in range(len(cuts))]
    for axes, one in zip(panels, cuts, strict=True):
        mesh = _cut(axes, one, platform, scale)
    bar = figure.colorbar(mesh, ax=panels, location="bottom", shrink=0.5, aspect=50, pad=0.01)
    bar.set_label("condition number of the legs (1 is best); white: beyond a leg's stroke", fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT)
    return figure


def _drawing(axes: Any, hexapod: Hexapod) -> None:
    joints, anchors = hexapod.joints, hexapod.anchors
    for a, b in zip(anchors, joints, strict=True):
        axes.plot(*zip(a, b, strict=True), color=VERMILION, lw=1.6)
    for points, color in ((anchors, GREY), (joints, BLUE)):
        axes.plot(*np.vstack([points, points[:1]]).T, color=color, lw=1.4)
    axes.scatter(*hexapod.head, s=14, color=ORANGE)
    low, high = (float(f(np.vstack([joints, anchors])[:, 2])) for f in (np.min, np.max))
    axes.quiver(0, 0, hexapod.joints[:, 2].mean(), 0.8 * hexapod.size, 0, 0, color=BLUE, lw=1.0)
    axes.set_zlim(low, max(high, float(hexapod.head[2])))
    axes.set_aspect("equal")
    axes.view_init(elev=22, azim=-125)
    axes.set_axis_off()
    axes.set_title("neutral pose (arrow: forward)", fontsize=FONT, y=-0.06)


def _ranges(axes: Axes, platform: Platform, hexapod: Hexapod) -> None:
    """Bars of what the legs reach, as shares of the largest of each unit; marks where the file says else."""
    ranges, table = reach(hexapod), table_of(platform)
    for row, (axis, ends) in enumerate(ranges.items()):
        factor, unit = _shown(axis)
        alike = AXES[:3] if row < 3 else AXES[3:]
        size = max(max(map(abs, ranges[name])) for name in alike)
        low, high = (end / size for end in ends)
        axes.barh(row, high - low, left=low, height=0.55, color=BLUE, alpha=0.75)
        digits = 3 if unit == "m" else 1
        for end, share, side in ((ends[0], low, "right"), (ends[1], high, "left")):
            text = f" {factor * end:+.{digits}f} {unit} ".replace("-", "−")
            axes.text(share, row, text, ha=side, va="center", fontsize=FONT)
        if axis in table:
            axes.plot([end / size for end in table[axis]], [row, row], "|", color="black", ms=13, mew=1.2)
    axes.set_yticks(range(6), AXES, fontsize=FONT)
    axes.invert_yaxis()
    axes.set_xlim(-1.5, 1.5)
    axes.set_xticks([])
    axes.set_title("reach of each axis alone (bars) and what the file allows (marks)", fontsize=FONT)
    for side in ("top", "right", "bottom"):
        axes.spines[side].set_visible(False)


def _cut(axes: Axes, one: Cut, platform: Platform, scale: Normalize) -> Any:
    (fx, ux), (fy, uy) = (_shown(axis) for axis in one.axes)
    x, y, table = fx * one.first, fy * one.second, table_of(platform)
    mesh = axes.pcolormesh(
        x, y, one.condition, norm=scale, cmap="viridis", shading="nearest", rasterized=True
    )
    axes.contour(x, y, one.inside.astype(float), levels=[0.5], colors=VERMILION, linewidths=0.9)
    if all(axis in table for axis in one.axes):
        (x0, x1), (y0, y1) = ([f * end for end in table[a]] for a, f in zip(one.axes, (fx, fy), strict=True))
        axes.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="black", lw=0.7, ls="--")
    axes.set_xlabel(f"{one.axes[0]} [{ux}]", fontsize=FONT)
    axes.set_ylabel(f"{one.axes[1]} [{uy}]", fontsize=FONT)
    axes.tick_params(labelsize=FONT)
    return mesh


def tour(hexapod: Hexapod) -> tuple[Vec, Mat, list[str]]:
    """Time (n,), poses (n, 6) and captions of a tour: every axis to both of its ends and back."""
    swing = np.sin(2.0 * np.pi * np.arange(0.0, 1.0, 1.0 / (SWEEP * FRAMES_PER_SECOND)))
    poses, captions = [], []
    for i, (axis, (low, high)) in enumerate(reach(hexapod).items()):
        factor, unit = _shown(axis)
        for share in swing:
            pose = np.zeros(6)
            pose[i] = share * (high if share > 0.0 else -low)
            poses.append(pose)
            captions.append(f"{axis} {factor * pose[i]:+.2f} {unit}")
    return np.arange(len(poses)) / FRAMES_PER_SECOND, np.array(poses), captions


def platform_page(
    platform: Platform, summary: dict[str, Any], figure: Figure, *, run: Run | None = None
) -> str:
    """A page of one platform: the picture in motion, its ranges, cuts, and what they mean.

    Parameters
    ----------
    summary, figure : what `platform_summary` and `platform_figure` give.
    run : moves the picture; otherwise a tour of every axis does.
    """
    hexapod = platform.six_legs()
    view = platform_view(hexapod, *frames_of(run)) if run else platform_view(hexapod, *tour(hexapod))
    moving = f"{run.cueing} on {run.scenario}" if run else "every axis to both of its ends"
    share = 100.0 * summary["reachable_share_of_box"]
    rows = [(axis, _row(entry)) for axis, entry in summary["ranges"].items()]
    ranges = table("models", ("axis", "legs reach", "the file allows"), rows)
    at_once = (
        f"Of the box of all these ranges at once the legs reach {share:.1f} %. {together_sentence(summary)}"
    )
    parts = [
        Part(
            "In motion", f"<p>Shown: {escape(moving)}. Legs turn from blue, short, to red, long.</p>\n{view}"
        ),
        Part(
            "Reach of each axis alone",
            f'<div class="wide">{ranges}</div><p class="note">{escape(at_once)}</p>',
        ),
        Part(
            "Across two axes",
            "<p>Coloured: the legs are within their strokes, the other four axes neutral. Dashed: what the "
            f'file allows each axis alone.</p><div class="drawing">{_svg(figure)}</div>',
        ),
    ]
    lead = f'<p class="lead">{escape(platform.description)}</p>'
    return page(platform.name, "Platform", lead, parts, styles=("platform.css",))


def _row(entry: dict[str, list[float]]) -> list[str]:
    unit = next(iter(entry)).removeprefix("reach_")
    digits = 3 if unit == "m" else 1

    def shown(ends: list[float] | None) -> str:
        if ends is None:
            return "–"
        return f"{ends[0]:+.{digits}f} … {ends[1]:+.{digits}f} {unit}".replace("-", "−")

    return [f"<td>{shown(entry[f'reach_{unit}'])}</td>", f"<td>{shown(entry.get(f'file_{unit}'))}</td>"]


def _svg(figure: Figure) -> str:
    stream = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "otolith"}):
        figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=150)
    text = stream.getvalue()
    return text[text.index("<svg") :]
