"""A platform made visible: its legs, their reach, their conditioning, and a run in motion."""

import io
import itertools
import math
from collections.abc import Mapping
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
from otolith.loop import Run
from otolith.plant.dynamics import frequencies
from otolith.platforms import Platform
from otolith.platforms.combined_limits import together
from otolith.platforms.fit import table_of
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.reach import CUTS, Cut, box_share, cut, reach, reach_ends
from otolith.report.page import Part, page, table
from otolith.report.palette import BLUE, GREY, ORANGE, VERMILION
from otolith.report.view import FRAMES_PER_SECOND, frames_of, platform_view

WIDTH: Final = 7.16  # [in] width of two columns of a paper
FONT: Final = 7.0  # [pt]
POOR: Final = 20.0  # condition number at the end of the colour scale; from 50 a pose counts as singular
SWEEP: Final = 2.4  # [s] duration of each axis in the tour of a platform


def _shown(axis: str) -> tuple[float, str]:
    """Return the factor and unit in which an axis is shown."""
    return (180.0 / np.pi, "deg") if AXES.index(axis) >= 3 else (1.0, "m")


def has_own_legs(platform: Platform) -> bool:
    """Return whether the platform's file describes its own legs, and not those of another machine."""
    return platform.hexapod is not None and not platform.hexapod.lent


def platform_summary(platform: Platform) -> dict[str, Any]:
    """Return the reach and the conditioning of the legs as plain JSON values; degrees where a name says so.

    For a platform without legs of its own, only the range of each axis is given, and `legs` is null.
    """
    table = table_of(platform)
    allowed = {
        axis: {f"file_{_shown(axis)[1]}": [_shown(axis)[0] * end for end in table[axis]]} for axis in table
    }
    if not has_own_legs(platform):
        lent = None if platform.hexapod is None else platform.hexapod.source
        return {"platform": platform.name, "legs": None, "lent": lent, "ranges": allowed}
    hexapod, ranges = platform.six_legs(), dict[str, Any]()
    for axis, ends in reach_ends(hexapod).items():
        factor, unit = _shown(axis)
        found = {f"reach_{unit}": [factor * end.at for end in ends], "ends": [end.why for end in ends]}
        ranges[axis] = found | allowed.get(axis, {})
    table_of_legs = platform.hexapod
    angles = None if table_of_legs is None else table_of_legs.joint_angles
    return {
        "platform": platform.name,
        "legs": "" if table_of_legs is None else table_of_legs.source,
        "ranges": ranges,
        "joint_angles_deg": None if angles is None else [angles.base_deg, angles.platform_deg],
        **_drives(hexapod),
        "condition_neutral": hexapod.condition(np.zeros(6)),
        "reachable_share_of_box": box_share(hexapod),
        "reachable_share_of_file": file_share(platform),
        "together": _together(platform),
        "servo_frequencies_hz": frequencies(hexapod).tolist(),
    }


def _drives(hexapod: Hexapod) -> dict[str, Any]:
    """Return where the drives of the legs stand in the neutral pose, and their range."""
    drives = hexapod.drives
    neutral = (drives.size * hexapod.lengths(np.zeros(6))).tolist()
    if hexapod.cranks is None:
        return {"neutral_lengths_m": neutral, "leg_stroke_m": list(drives.span)}
    return {
        "neutral_angles_deg": neutral,
        "crank_range_deg": list(drives.span),
        "crank_m": hexapod.cranks.radius,
        "rod_m": hexapod.cranks.rod,
        "leverage_neutral": float(hexapod.leverages(np.zeros((1, 6))).min()),
    }


def file_share(platform: Platform, *, samples: int = 20_000, seed: int = 0) -> float:
    """Return the share of the poses within all limits of the file that the legs reach.

    Axes that the file lacks stay neutral. The samples include the corners of the box, where a controller's
    worst poses are likely.
    """
    table, box = table_of(platform), np.zeros((6, 2))
    for axis, ends in table.items():
        box[AXES.index(axis)] = ends
    inner = np.random.default_rng(seed).uniform(box[:, 0], box[:, 1], (samples, 6))
    poses = np.vstack([inner, np.array(list(itertools.product(*box)))])
    if platform.circle is not None:
        poses = poses[np.hypot(poses[:, 0], poses[:, 1]) <= platform.circle]
    return float(np.mean(platform.six_legs().reaches(poses)))


def _together(platform: Platform) -> dict[str, float | None] | None:
    """Return what four axes can do in every combination; None if the file lacks one of them."""
    try:
        found = together(platform)
    except InputError:
        return None
    turning = found.tilt_acceleration
    return {
        "reach_share": found.reach,
        "speed_share": found.speed,
        "acceleration_share": found.acceleration,
        "circle_m": found.circle,
        "tilt_deg": math.degrees(found.tilt),
        "velocity_mps": found.velocity,
        "tilt_rate_degps": math.degrees(found.tilt_rate),
        "acceleration_mps2": found.translation,
        "tilt_acceleration_degps2": None if turning is None else math.degrees(turning),
    }


def range_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return a line per axis with its range: the legs' with what limits it, otherwise the file's."""
    lines = []
    for axis, entry in summary["ranges"].items():
        unit = _shown(axis)[1]
        low, high = entry.get(f"reach_{unit}", entry.get(f"file_{unit}"))
        why = f" ({'; '.join(entry['ends'])})" if "ends" in entry else " (the file)"
        lines.append(f"{axis}: {low:.3f} to {high:.3f} {unit}{why}")
    return lines


def sentences(summary: Mapping[str, Any]) -> list[str]:
    """Describe a platform's reach in sentences."""
    if summary["legs"] is None and summary["lent"] is not None:
        return [
            f"No legs of its own are documented, and none are shown: those in the file ({summary['lent']}) "
            "serve the plants that need some."
        ]
    if summary["legs"] is None:
        return [
            "The file describes no legs: what the axes can do together is unknown, and none are shown "
            "(a table [hexapod] describes them)."
        ]
    found = [f"Of the legs: {summary['legs']}."] if summary["legs"] else []
    found += _joint_sentences(summary)
    return [*found, *_box_sentences(summary), *filter(None, [together_sentence(summary)])]


def _joint_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Describe the cranks, where there are some, and the joints' limits."""
    angles, cranks = summary["joint_angles_deg"], "crank_m" in summary
    if angles is None:
        ends = "cranks' ranges, near their dead centres" if cranks else "legs' strokes"
        given = [f"Joint angles are not given: reach ends with the {ends} and at singular poses only."]
    elif cranks:
        out = f"Rods lean up to {angles[0]:g} deg out of their cranks' planes"
        given = [f"{out}, {angles[1]:g} deg at the platform's joints."]
    else:
        out = f"Legs lean up to {angles[0]:g} deg at the base's joints"
        given = [f"{out}, {angles[1]:g} deg at the platform's."]
    if not cranks:
        return given
    low, high = summary["crank_range_deg"]
    leverage = summary["leverage_neutral"]
    angles_deg = [round(angle, 1) + 0.0 for angle in summary["neutral_angles_deg"]]  # no −0.0
    stand = " to ".join(f"{angle:g}" for angle in sorted({min(angles_deg), max(angles_deg)}))
    described = (
        f"Cranks of {1e3 * summary['crank_m']:g} mm with rods of {1e3 * summary['rod_m']:g} mm turn from "
        f"{low:g} to {high:g} deg; in the neutral pose they stand at {stand} deg, "
        f"and {100.0 * leverage:.0f} % of a tip's motion is along its rod."
    )
    return [described, *given]


def _box_sentences(summary: Mapping[str, Any]) -> list[str]:
    """State whether the file's limits exceed the legs' reach, for each axis alone and for all together."""
    beyond = []
    for axis, entry in summary["ranges"].items():
        unit = _shown(axis)[1]
        ends = [(entry.get(f"file_{unit}"), entry[f"reach_{unit}"])]
        beyond += [
            f"{axis} {_span(file, unit)} (the legs reach {_span(legs, unit)})"
            for file, legs in ends
            if file is not None and (file[0] < legs[0] or file[1] > legs[1])
        ]
    found = [f"Alone, the file allows more than the legs reach of {', '.join(beyond)}."] if beyond else []
    share = summary["reachable_share_of_file"]
    if share < 1.0:
        found.append(
            "All at once, the file's limits leave the legs' reach: of the poses that they allow, the legs "
            f"make only {_percent(share)}."
        )
    else:
        found.append(
            "All at once, the file's limits stay within the legs' reach, in every pose that was tried."
        )
    return found


def _percent(share: float) -> str:
    """Return a share below 1 in percent; it is never rounded to 100."""
    return f"{min(100.0 * share, 99.9):.1f} %" if share > 0.0005 else "less than 0.1 %"


def _span(ends: list[float], unit: str) -> str:
    digits = 3 if unit == "m" else 1
    return f"{ends[0]:+.{digits}f} … {ends[1]:+.{digits}f} {unit}".replace("-", "−")


def together_sentence(summary: Mapping[str, Any]) -> str:
    """Describe in one sentence what four axes can do in every combination; empty if it is unknown."""
    all_at_once = summary["together"]
    if all_at_once is None:
        return ""
    accelerations = (
        "accelerations are unknown, for the file gives none of roll or pitch"
        if all_at_once["acceleration_mps2"] is None
        else "{acceleration_mps2:.2f} m/s², {tilt_acceleration_degps2:.0f} deg/s²"
    )
    return (
        "Surge, sway, roll and pitch in every combination: {circle_m:.3f} m around neutral with "
        f"±{{tilt_deg:.2f}} deg, {{velocity_mps:.3f}} m/s, {{tilt_rate_degps:.1f}} deg/s; {accelerations}."
    ).format(**all_at_once)


def platform_figure(platform: Platform) -> Figure:
    """Draw the legs in the neutral pose, the range of each axis alone, and sections across two axes.

    For a platform without legs, only the ranges of its file are drawn.
    """
    if not has_own_legs(platform):
        figure = Figure(figsize=(WIDTH, 0.6 + 0.3 * len(platform.axes)), layout="constrained")
        _ranges(figure.add_subplot(), platform, None)
        return figure
    hexapod = platform.six_legs()
    figure = Figure(figsize=(WIDTH, 6.6), layout="constrained")
    grid = figure.add_gridspec(3, 3, height_ratios=[1.25, 1.0, 1.0])
    _drawing(figure.add_subplot(grid[0, 0], projection="3d"), hexapod)
    _ranges(figure.add_subplot(grid[0, 1:]), platform, hexapod)
    cuts = [cut(hexapod, axes) for axes in CUTS]
    highest = max(float(np.nanmax(one.condition)) for one in cuts)
    scale = Normalize(1.0, min(highest, POOR))
    panels = [figure.add_subplot(grid[1 + k // 3, k % 3]) for k in range(len(cuts))]
    for axes, one in zip(panels, cuts, strict=True):
        mesh = _cut(axes, one, platform, scale)
    bar = figure.colorbar(
        mesh,
        ax=panels,
        location="bottom",
        shrink=0.5,
        aspect=50,
        pad=0.01,
        extend="max" if highest > POOR else "neither",
    )
    bar.set_label("condition number of the legs (1 is best); white: out of reach", fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT)
    return figure


def _drawing(axes: Any, hexapod: Hexapod) -> None:
    joints, anchors = hexapod.joints, hexapod.anchors
    knees = hexapod.tips(hexapod.lengths(np.zeros((1, 6))))[0]  # the tips of cranks; of legs, their anchors
    for a, knee, b in zip(anchors, knees, joints, strict=True):
        axes.plot(*zip(a, knee, strict=True), color=ORANGE, lw=3.0, solid_capstyle="round")
        axes.plot(*zip(knee, b, strict=True), color=VERMILION, lw=1.6)
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


def _ranges(axes: Axes, platform: Platform, hexapod: Hexapod | None) -> None:
    """Draw the legs' reach as bars, relative to the largest of each unit, and mark the file's limits.

    For a platform without legs, the bars are the file's limits.
    """
    table = table_of(platform)
    ranges = table if hexapod is None else reach(hexapod)
    for row, axis in enumerate(ranges):
        factor, unit = _shown(axis)
        alike = AXES[:3] if axis in AXES[:3] else AXES[3:]
        size = max(abs(end) for name in alike for end in ranges.get(name, ()))
        low, high = (end / size for end in ranges[axis])
        axes.barh(row, high - low, left=low, height=0.55, color=GREY if hexapod is None else BLUE, alpha=0.75)
        digits = 3 if unit == "m" else 1
        for end, share, side in ((ranges[axis][0], low, "right"), (ranges[axis][1], high, "left")):
            text = f" {factor * end:+.{digits}f} {unit} ".replace("-", "−")
            axes.text(share, row, text, ha=side, va="center", fontsize=FONT)
        if hexapod is not None and axis in table:
            axes.plot([end / size for end in table[axis]], [row, row], "|", color="black", ms=13, mew=1.2)
    axes.set_yticks(range(len(ranges)), list(ranges), fontsize=FONT)
    axes.invert_yaxis()
    axes.set_xlim(-1.5, 1.5)
    axes.set_xticks([])
    title = "reach of each axis alone (bars) and what the file allows (marks)"
    axes.set_title("what the file allows of each axis" if hexapod is None else title, fontsize=FONT)
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
    """Return time (n,) [s], poses (n, 6) and captions of a tour that moves every axis to both of its ends."""
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
    platform: Platform, summary: Mapping[str, Any], figure: Figure, *, run: Run | None = None
) -> str:
    """Return the page of one platform: an animation, its ranges, sections, and their meaning.

    Parameters
    ----------
    summary, figure : the results of `platform_summary` and `platform_figure`.
    run : drives the animation; without one it is a tour of all axes.
    """
    rows = [(axis, _row(axis, entry)) for axis, entry in summary["ranges"].items()]
    ranges = table("models", ("axis", "legs reach", "what ends it", "the file allows"), rows)
    described = "".join(f"<p>{escape(sentence)}</p>" for sentence in sentences(summary))
    drawing = f'<div class="drawing">{_svg(figure)}</div>'
    if not has_own_legs(platform):
        allowed = f'{described}<div class="wide">{ranges}</div>'
        parts = [Part("What the file allows of each axis", allowed), Part("As a picture", drawing)]
    else:
        share = _percent(summary["reachable_share_of_box"])
        share = f"Of the box of all these ranges at once the legs reach {share}."
        reached = f'{described}<div class="wide">{ranges}</div><p class="note">{share}</p>'
        parts = [
            Part("In motion", _moving(platform.six_legs(), run)),
            Part("Reach of each axis alone", reached),
            Part("Across two axes", f"<p>{CUT_NOTE}</p>{drawing}"),
        ]
    lead = f'<p class="lead">{escape(platform.description)}</p>'
    return page(platform.name, "Platform", lead, parts, styles=("platform.css",))


CUT_NOTE: Final = (
    "Coloured: the pose is in reach, on a way through such poses from the neutral one, the other four axes "
    "neutral. Dashed: what the file allows each axis alone."
)


def _moving(hexapod: Hexapod, run: Run | None) -> str:
    """Return the animation, and a line that states what moves it."""
    view = platform_view(hexapod, *frames_of(run)) if run else platform_view(hexapod, *tour(hexapod))
    moving = f"{run.cueing} on {run.scenario}" if run else "every axis to both of its ends"
    meaning = "Legs turn from blue, short, to red, long"
    if hexapod.cranks is not None:
        meaning = "Rods turn from blue, with their cranks at the lowest angle, to red, at the highest"
    return f"<p>Shown: {escape(moving)}. {meaning}.</p>\n{view}"


def _row(axis: str, entry: dict[str, Any]) -> list[str]:
    unit = _shown(axis)[1]
    spans = [entry.get(f"{kind}_{unit}") for kind in ("reach", "file")]
    reached, allowed = ("–" if span is None else _span(span, unit) for span in spans)
    return [f"<td>{cell}</td>" for cell in (reached, "; ".join(entry.get("ends", ["–"])), allowed)]


def _svg(figure: Figure) -> str:
    stream = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "otolith"}):
        figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=150)
    text = stream.getvalue()
    return text[text.index("<svg") :]
