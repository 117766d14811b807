"""The animation of a platform as a piece of HTML, for a platform's page and a run's report."""

import json
import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.rotation import place_of
from otolith.loop import Run
from otolith.platforms.hexapod import Hexapod
from otolith.report.page import asset

FRAMES_PER_SECOND: Final = 25.0
FRAMES: Final = 3000  # largest number, about 0.25 MB; runs of more than two minutes are shown more coarsely


def platform_view(hexapod: Hexapod, time: Vec, poses: Mat, captions: Sequence[str] = ()) -> str:
    """Return an animation of a platform as self-contained HTML; dragging turns the view.

    Parameters
    ----------
    time : (n,) [s] times of the poses.
    poses : (n, 6) all are shown; see `frames_of` for a run.
    captions : one text per pose, or none.
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
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * run.plant_period)), math.ceil(run.samples / FRAMES))
    times, poses, before = [], [], 0
    for part in run.parts():
        first = -before % every  # of the samples that are shown, the first in this part
        times.append(part.time[first::every])
        poses.append(part.pose[first::every])
        before += part.samples
    return np.concatenate(times), np.concatenate(poses)
