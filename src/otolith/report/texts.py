"""The texts of a page that explain its panels; the names of key figures are in `otolith.metrics`."""

from typing import Final

PANELS: Final = {
    "force": (
        "What the driver should feel (grey) and what the platform lets the driver feel (blue). The "
        "platform has two means: it accelerates, which is quick but soon runs out of "
        "travel, and it tilts, so that a part of gravity, g sin(tilt), takes over what lasts. A base that "
        "carries it is a third. The parts add up to the felt force. Where blue leaves grey, the cue is "
        "missing; where they have "
        "opposite signs, it is false. The best possible (dashed), where it was computed, knows the whole "
        "drive beforehand."
    ),
    "tilt": (
        "Tilt lends gravity to the cue, but only slowly: a tilt rate beyond the dashed limit would be "
        "felt as rotation. A controller that uses all of its tilt rate looks like a train of ramps. "
        "Tilt is counted so that a positive one adds to the specific force."
    ),
    "position": (
        "How much of the travel is spent, and how fast. Good cueing keeps room for what comes next: the "
        "curve returns to the middle when the tilt has taken over (washout) and slows down before it "
        "reaches a limit (braking). A limit that is far beyond the curve is named in the legend and not "
        "drawn."
    ),
    "base": (
        "The rail or tripod that carries the platform: it has a larger reach and is slower, and its limits "
        "are its own. What lasts too long for the platform’s travel, and not long enough for tilt, is its "
        "part."
    ),
    "heave": (
        "Vertical force less the standing 1 g, as it should be felt (grey) and is (blue). Nothing helps "
        "heave as tilt helps surge and sway: what lasts cannot be cued, only how it begins and ends."
    ),
    "heave-place": "How much of the stroke is spent, and how fast; limits far beyond are only named.",
    "yaw": (
        "Rate of turn about the driver’s vertical axis, as it should be felt (grey) and is (blue). The "
        "platform turns by some 20 deg at most, so a bend can be begun but not driven through."
    ),
    "yaw-place": "How far the platform has turned, and how fast; limits far beyond are only named.",
    "changes": (
        "How many constraints the solver had to add to or remove from its working set until it found "
        "the optimum: its iterations, counted the same on every computer. High where the reference "
        "changes suddenly. Marks stand where the fallback decided instead of the algorithm."
    ),
    "step-time": (
        "Processor time that each decision took. What matters in real time is not the mean but the "
        "slowest step, which must stay below the controller's period."
    ),
    "compare-force": (
        "What the driver should feel (grey) and what each algorithm achieves. Where curves cover each "
        "other, the algorithms decide alike; a click on a name hides its curve. The best possible, "
        "where it was computed, knows the whole drive beforehand."
    ),
    "compare-tilt": (
        "Tilt of each algorithm, counted so that a positive one adds to the specific force; limits are "
        "dashed."
    ),
    "compare-position": "Travel that each algorithm spends, with the platform's limits dashed.",
    "compare-heave": "Vertical force less the standing 1 g: wanted (grey), and as each algorithm gives it.",
    "compare-heave-place": "Stroke that each algorithm spends, with the platform’s limits dashed.",
    "compare-yaw": "Rate of turn about the driver’s vertical axis: wanted (grey), and as each gives it.",
    "compare-yaw-place": "How far each algorithm turns the platform, with its limits dashed.",
    "compare-false-cues": (
        "When each algorithm misled. A cue is inverted when it has the wrong sign, unwanted when nothing was "
        "to be felt, missing when something was and is not, scaled when it has the wrong size; each by at "
        "least 0.17 m/s², about what is noticed. The first three mislead."
    ),
    "compare-use": (
        "How far each algorithm went, as a share of what the platform can. Beyond the dashed line the "
        "platform would have hit its end; far below it, room was left that could have carried cues."
    ),
    "trade": (
        "Low and to the left is best: little error for little travel. An algorithm further right spends more "
        "of the reach for what it gains; one beyond the dashed line would have hit its end."
    ),
    "trade-up": (
        "High and to the left is best: much gained for little travel. An algorithm further right spends more "
        "of the reach for what it gains; one beyond the dashed line would have hit its end."
    ),
    "compare-changes": (
        "Each curve gives the share of steps that needed at least so many working-set changes. Lower "
        "and further left is better. The right end, the rare and costly steps, decides whether a "
        "controller keeps its period."
    ),
}

LIMITS: Final = (
    "Judged by the motion and the platform’s file alone. An algorithm may pass a soft limit at a price; a "
    "comfort threshold is what a driver begins to notice, the other limits are the machine’s. Controllers "
    "impose limits at their nodes, once per period; the last column shows what happened in between."
)

RULE: Final = (
    "Within a scenario, algorithms that kept every hard limit come before those that passed one; a limit "
    "that is soft for one of them is held against none. Then the measure decides; equal ones share a rank."
)
RULE_OVERALL: Final = (
    " Over all scenarios the mean rank decides, then whether every hard limit was kept in all of them, then "
    "the mean of the measure relative to the best."
)

DOFS: Final = {
    "surge-pitch": "Surge and pitch",
    "sway-roll": "Sway and roll",
    "heave": "Heave",
    "yaw": "Yaw",
}

UNITS: Final = {  # ending of a name that no measure has -> its unit
    "_percent": "%",
    "_us": "µs",
    "_ms": "ms",
    "_s": "s",
    "_deg": "deg",
    "_m": "m",
}
