"""The animation of a platform as a piece of HTML, for a platform's page and a run's report."""

import json
import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.rotation import place_of
from otolith.loop import Run
from otolith.platforms.hexapod import Hexapod
from otolith.report.page import asset

FRAMES_PER_SECOND: Final = 25.0
FRAMES: Final = 3000  # largest number, about 0.25 MB; runs of more than two minutes are shown more coarsely


def platform_view(
    hexapod: Hexapod,
    time: Vec,
    poses: Mat,
    captions: Sequence[str] = (),
    *,
    bases: Mat | None = None,
) -> str:
    """Return an animation of a platform as self-contained HTML; dragging turns the view.

    Parameters
    ----------
    time : (n,) [s] times of the poses.
    poses : (n, 6) all are shown; see `frames_of` for a run.
    captions : one text per pose, or none.
    bases : (n, 3) [m, m, rad] x, y and yaw of the base at the same times; None where it stands still.
    """
    places = np.empty((len(poses), 7))
    for pose, place in zip(poses, places, strict=True):
        place_of(pose, place)
    data = {
        "anchors": hexapod.anchors.round(5).tolist(),
        "joints": hexapod.joints.round(5).tolist(),
        "head": hexapod.head.round(5).tolist(),
        "stroke": list(hexapod.drives.span),
        "cranks": None if hexapod.cranks is None else hexapod.cranks.plain(),
        "time": np.asarray(time).round(4).tolist(),
        "places": places.round(6).tolist(),
        "captions": list(captions),
        "bases": [] if bases is None else bases.round(5).tolist(),
    }
    text = json.dumps(data, allow_nan=False).replace("</", "<\\/")
    script = asset("drawing.js") + asset("platform.js")
    return (
        '<figure class="platform-view"><canvas width="960" height="560" role="img" '
        'aria-label="The platform in motion"></canvas>'
        '<p><button type="button">Play</button> <input type="range" min="0" value="0" aria-label="time"> '
        "<output></output></p>"
        f'<script type="application/json">{text}</script><script>(() => {{{script}}})();</script></figure>'
    )


def frames_of(run: Run) -> tuple[Vec, Mat]:
    """Return time (n,) [s] and poses (n, 6) of a run at `FRAMES_PER_SECOND`, or less often if it is long."""
    return _shown(run, lambda part: part.time), _shown(run, lambda part: part.pose)


def bases_of(run: Run) -> Mat | None:
    """Return x, y and yaw (n, 3) of a run's base at the times of `frames_of`; None without a base."""
    if run.base is None:
        return None
    return _shown(run, lambda part: np.empty((0, 3)) if part.base is None else part.base[:, [0, 1, 5]])


def _shown(run: Run, pick: Callable[[Run], Vec]) -> Vec:
    """Return the samples of a series that are shown."""
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * run.plant_period)), math.ceil(run.samples / FRAMES))
    found, before = [], 0
    for part in run.parts():
        found.append(pick(part)[-before % every :: every])
        before += part.samples
    return np.concatenate(found)
