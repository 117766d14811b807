"""Logs of anyone: random vehicles, roads, axes, units, channels and events, and what may become of them.

A log may be read right, or mirrored if a note says that left and right are not proven; or it may be refused,
and then the remedies that the sentence names are followed: one of them must make the truth, the only one if
there is one.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, parse_log
from otolith.recordings.settings import PLAIN, LogSettings
from tests.recordings import vehicles
from tests.recordings.checks.drives import FELT, NAMES, SAE, differs, text
from tests.recordings.vehicles import G, Ride

BARE = {"ax": "ax", "ay": "ay", "az": "az", "roll_rate": "roll_rate", "pitch_rate": "pitch_rate"}
BARE |= {"yaw_rate": "yaw_rate", "vx": "speed"}
TOLERANCE = 0.01
FAINT = 0.2  # [m/s²]
WAYS = 3  # refusals in a row that are followed
HILLS = "{} goes with the change of speed, which proves its sign unless the road climbs"


@dataclass(frozen=True)
class Case:
    """One log, and what it is made of."""

    what: str
    data: Mapping[str, Vec]  # as the file holds them, angles in radians
    names: Mapping[str, str]
    truth: Mapping[str, Vec]
    turned: tuple[str, ...]
    events: bool = False
    doubts: tuple[str, ...] = field(default=())  # quantities whose sign nothing can prove


def random_ride(rng: np.random.Generator) -> tuple[str, Ride]:
    """A vehicle on a road, driven at random."""
    a, b, c = map(float, rng.uniform(0.5, 1.5, 3))

    def pace(t: Vec) -> Vec:
        return 16.0 * a + 6.0 * np.sin(0.3 * b * t) + 2.0 * np.sin(0.11 * c * t)

    def bends(t: Vec) -> Vec:
        return 0.12 * b * np.sin(0.2 * c * t + a) + 0.08 * np.sin(0.47 * a * t)

    kind = str(
        rng.choice(["car", "car", "car", "oval", "hills", "mountain", "motorcycle", "train", "rolling"])
    )
    length = float(rng.uniform(50.0, 90.0))
    if kind == "oval":
        speed, bank = float(rng.uniform(15.0, 80.0)), float(rng.uniform(5.0, 40.0))
        return f"oval at {speed:.0f} m/s, {bank:.0f} deg", vehicles.oval(speed, banked_deg=bank)
    if kind == "hills":
        return kind, vehicles.hills(drive=float(rng.uniform(0.2, 1.2)), steep=float(rng.uniform(0.02, 0.1)))
    if kind == "mountain":
        steep = float(rng.uniform(-0.1, 0.1))
        return kind, vehicles.ride(pace, bends, climb=lambda t: np.full_like(t, steep), length=length)
    if kind in ("motorcycle", "train", "rolling"):
        lean = {"motorcycle": rng.uniform(0.85, 1.15), "train": rng.uniform(0.2, 0.9), "rolling": -0.07}[kind]
        ride = vehicles.ride(
            pace, bends, bank=lambda t: -float(lean) * np.arctan(pace(t) * bends(t) / G), length=length
        )
        return f"{kind} that leans {float(lean):.2f}", ride
    return kind, vehicles.ride(pace, bends, length=length)


def random_case(rng: np.random.Generator) -> Case:
    """A log as somebody's logger might have written it."""
    kind, ride = random_ride(rng)
    keys = ["ax", "ay"]
    keys += ["az"] if rng.random() < 0.6 else []
    keys += ["roll_rate", "pitch_rate"] if rng.random() < 0.6 else []
    keys += ["yaw_rate"] if rng.random() < 0.8 else []
    keys += ["vx"] if rng.random() < 0.8 else []
    witness = str(rng.choice(["", "", "lat lon", "heading", "x y"]))
    keys += witness.split()
    data = {"t": ride.t[::2], **{key: ride.channels()[key][::2] for key in keys}}
    if "az" in data and rng.random() < 0.3:
        data["az"] = data["az"] - G
    for key in ("ax", "ay"):
        data[key] = data[key] + rng.normal(0.0, 0.02, len(data["t"]))  # as a good sensor's
    truth = {key: data[key] for key in FELT if key in data}
    if "az" in truth and float(np.mean(truth["az"])) > 0.5 * G:
        truth["az"] = truth["az"] - G
    axes = str(rng.choice(["iso", "iso", "sae", "sae", "ay", "yaw_rate", "ax"]))
    turned = tuple(key for key in (SAE if axes == "sae" else (axes,)) if key in data)
    data = {key: -values if key in turned else values for key, values in data.items()}
    names, unit = dict(NAMES), ""
    if kind == "car" and {"yaw_rate", "vx"} <= set(data) and rng.random() < 0.4:
        names |= BARE
        unit, data = _in_other_units(data, rng)
    events = bool(rng.random() < 0.15)
    if events:
        data, truth = _paused(data, truth, rng)
    notes_found = f"{kind}; {' '.join(keys)}; axes {axes}; {unit or 'SI'}{'; paused' if events else ''}"
    return Case(notes_found, data, names, truth, turned, events)


def _in_other_units(data: Mapping[str, Vec], rng: np.random.Generator) -> tuple[str, dict[str, Vec]]:
    """Forces in g, rates in deg/s or speed in km/h, which no name tells."""
    kind = str(rng.choice(["g", "deg/s", "km/h", "g deg/s km/h"]))
    scales: dict[str, float] = {}
    scales |= dict.fromkeys(("ax", "ay", "az"), 1.0 / G) if "g" in kind.split() else {}
    scales |= dict.fromkeys(("roll_rate", "pitch_rate", "yaw_rate"), 180.0 / np.pi) if "deg/s" in kind else {}
    scales |= {"vx": 3.6} if "km/h" in kind else {}
    return kind, {key: values * scales.get(key, 1.0) for key, values in data.items()}


def _paused(
    data: Mapping[str, Vec], truth: Mapping[str, Vec], rng: np.random.Generator
) -> tuple[dict[str, Vec], dict[str, Vec]]:
    """Three seconds in which all stands still but time, with zeros in between; the truth has none."""
    at, rows, step = int(rng.integers(300, 900)), 75, float(data["t"][1] - data["t"][0])
    held = {k: np.r_[v[:at], np.full(rows, v[at - 1]), v[at:]] for k, v in data.items()}
    if max(abs(held[key][at]) for key in ("ax", "ay")) > 1.0:  # a packet of zeros that shows
        for key in FELT:
            if key in held:
                held[key][at + 30] = 0.0
    held["t"] = step * np.arange(len(held["ax"]))
    return held, dict(truth)


def outcome(case: Case) -> str:
    """``right``, ``mirrored, and reported``, ``refused, …``; else ``wrong: …``."""
    settings = LogSettings(events="cut") if case.events else PLAIN
    log, sentence = _attempt(case, settings, {})
    if log is not None:
        return judged(case, log)
    return f"refused, {_followed(case, settings, {}, sentence, WAYS)}"


def judged(case: Case, log: Log) -> str:
    """How a log was read."""
    wrong = {key: error for key, error in _errors(case, log).items() if error > TOLERANCE}
    if float(np.std(case.truth["ay"])) < FAINT:  # a motorcycle's, whose sign nothing shows and nobody feels
        wrong.pop("ay", None)
    if not wrong:
        return "right"
    words = (
        "left and right are not proven",
        "proves them only if",
        "unless the road is banked",
        "hardly goes with",
    )
    notes_found = [note for note in log.notes if any(word in note for word in words)]
    mirror = {key: -values if key in case.turned else values for key, values in case.truth.items()}
    if max(_errors(replace(case, truth=mirror), log).values()) <= TOLERANCE and notes_found:
        return "mirrored, and reported"
    doubts = (
        "doubtful: {}",
        "reported only, since it is not cued: {} in",
        "the sign of {} is not proven",
        "{} hardly goes with",
        HILLS,
    )
    doubted = {k for k in wrong if any(n.startswith(d.format(k)) for n in log.notes for d in doubts)}
    signs = [n.split(" is not proven")[0] for n in log.notes if re.match("the sign of .* is not proven", n)]
    doubted |= {key for key in wrong if any(re.search(rf"\b{key}\b", words) for words in signs)}
    if set(wrong) <= doubted | ({"pitch_rate"} if notes_found else set()):
        return "right but for what is said to be doubtful"
    return "wrong: " + ", ".join(f"{key} by {100.0 * error:.0f} %" for key, error in wrong.items())


def _errors(case: Case, log: Log) -> dict[str, float]:
    """RMS errors as shares; of a drive that was cut, where a bridge of one row does not matter."""
    if not case.events:
        return differs(log, case.truth)
    t = np.arange(len(case.truth["ax"])) * float(case.data["t"][1] - case.data["t"][0])
    assert log.found is not None
    played = [event for event in log.found.events if event.kind == "held"]  # told, and in the drive
    at = t + sum((t > event.start) * (event.end - event.start - event.bridge) for event in played)
    errors = {}
    for key, values in case.truth.items():
        got = log.channels[key].on(at)
        size = max(float(np.sqrt(np.mean(values**2))), 0.1)
        errors[key] = 0.2 * float(np.sqrt(np.mean((got - values) ** 2))) / size
    return errors


def _attempt(case: Case, settings: LogSettings, columns: Mapping[str, str]) -> tuple[Log | None, str]:
    try:
        return parse_log(text(case.data, case.names), "log.csv", columns=columns, settings=settings), ""
    except InputError as error:
        return None, str(error)


def _followed(case: Case, settings: LogSettings, columns: Mapping[str, str], sentence: str, more: int) -> str:
    """What comes of following the remedies of a refusal: the truth by one of them."""
    found = ways(sentence)
    if not found:
        return "without a remedy"
    outcomes = []
    for mapping, axes in found:
        chosen = {**columns, **mapping}
        if axes and set(case.turned) != (set(SAE) & set(case.data) if axes == "sae" else set()):
            outcomes.append("right, had the user's word been true")
            continue
        notes_found = replace(settings, axes=axes or settings.axes)
        log, again = _attempt(case, notes_found, chosen)
        if log is not None:
            outcomes.append(judged(case, log))
        else:
            outcomes.append(_followed(case, notes_found, chosen, again, more - 1) if more else "in circles")
    good = [one for one in outcomes if one.startswith(("right", "mirrored", "a remedy", "the remedy"))]
    if len(found) == 1:
        return "the remedy is right" if good else f"wrong remedy ({outcomes[0]}): {sentence}"
    return "a remedy of several is right" if good else f"wrong remedies ({outcomes}): {sentence}"


def ways(sentence: str) -> list[tuple[dict[str, str], str]]:
    """The remedies that a refusal names: mappings, and a word for `--axes`."""
    found = []
    for part in re.split(r"; or |, map |, or |; nothing ", sentence):
        mapping = dict(re.findall(r"\b(\w+)=(-?[A-Za-z_#\d]+(?: \(deg\))?(?::[\w/]+)?)", part))
        axes = re.search(r"--axes (iso|sae)", part)
        if mapping or axes:
            found.append((mapping, axes.group(1) if axes else ""))
    return found
