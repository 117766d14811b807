"""How much memory a drive of two hours takes, of another source tree and of this one.

    git worktree add /tmp/before 6f24dd5
    python benchmarks/memory.py /tmp/before/src [--minutes 10 30] [--whole] [--json FILE]

`otolith run` cues recorded drives of a multisine, 4 DOF, plant at 1 kHz, each in a process of its own, and
writes all of its results. Its largest resident memory above that of a drive of ten seconds counts; of two
lengths, the slope gives that of two hours. With `--whole`, this tree also cues the two hours themselves.
Memory does not depend on how busy the machine is.
"""

import argparse
import functools
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

import numpy as np

PROGRAM: Final = "from otolith.cli import main; main()"
HOURS, SHORT = 2.0, 10.0 / 60.0  # [h], [min]
GOAL: Final = 6.0
OPTIONS: Final = ("--dofs", "surge-pitch,sway-roll", "--platform", "thesis", "--axes", "iso")


def drive(minutes: float, path: Path) -> None:
    """Write a drive sampled at 100 Hz: 24 sines from 0.05 to 2 Hz along x and y, 1 m/s² RMS each."""
    t = np.arange(round(6000 * minutes) + 1) / 100.0
    frequencies = np.geomspace(0.05, 2.0, 24)
    columns = [t]
    for seed in (1, 2):
        phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 24)
        sizes = np.sqrt(2.0 / np.sum(1.0 / frequencies)) / np.sqrt(frequencies)
        waves = [
            a * np.sin(2.0 * np.pi * f * t + p) for a, f, p in zip(sizes, frequencies, phases, strict=True)
        ]
        columns.append(np.sum(waves, axis=0))
    header = "time [s],ax [m/s^2],ay [m/s^2]"
    np.savetxt(path, np.stack(columns, axis=1), fmt="%.6g", delimiter=",", header=header, comments="")


def peak(src: str, minutes: float, folder: Path) -> float:
    """Return the largest resident memory [MB] of cueing such a drive, in a process of its own."""
    log = folder / f"drive-{minutes:.3g}.csv"
    if not log.exists():
        drive(minutes, log)
    line = [sys.executable, "-c", PROGRAM, "run", "--log", str(log), *OPTIONS, *without_optimum(src)]
    process = subprocess.Popen(  # noqa: S603
        [*line, "--out", str(folder / "out"), "--force"],
        env={**os.environ, "PYTHONPATH": src},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(line)} of {src} ended with {os.waitstatus_to_exitcode(status)}")
    return used.ru_maxrss / 1024.0


@functools.cache
def without_optimum(src: str) -> list[str]:
    """Return the option that leaves the optimum of the short drive out, if a tree computes one unasked."""
    asked = [sys.executable, "-c", PROGRAM, "run", "--help"]
    told = subprocess.run(  # noqa: S603
        asked, env={**os.environ, "PYTHONPATH": src}, capture_output=True, text=True, check=True
    )
    return ["--no-optimum"] if "--no-optimum" in told.stdout else []


def slope(src: str, lengths: list[float], folder: Path) -> tuple[float, list[float]]:
    """Return the memory of a second of a drive [MB/s], and the peaks above a drive of ten seconds [MB]."""
    peak(src, SHORT, folder)  # compiles what is missing
    least = peak(src, SHORT, folder)
    above = [peak(src, minutes, folder) - least for minutes in lengths]
    seconds = 60.0 * (np.array(lengths) - SHORT)
    per_second = above[0] / seconds[0] if len(above) == 1 else np.polyfit(seconds, above, 1)[0]
    return float(per_second), above


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", metavar="OTHER_SRC")
    parser.add_argument("--minutes", type=float, nargs="+", default=[10.0, 30.0])
    parser.add_argument("--whole", action="store_true", help="Cue the two hours, too, with this tree.")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    here = str(Path(__file__).resolve().parents[1] / "src")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = {tree: slope(tree, given.minutes, folder) for tree in (given.other, here)}
        whole = peak(here, 60.0 * HOURS, folder) - peak(here, SHORT, folder) if given.whole else None
    (before, of_before), (now, of_now) = found[given.other], found[here]
    print(f"{'above a drive of 10 s [MB]':40}{'before':>10}{'now':>10}{'ratio':>8}")
    for minutes, one, other in zip(given.minutes, of_before, of_now, strict=True):
        print(f"{f'{minutes:g} min':40}{one:10.0f}{other:10.0f}{one / other:8.1f}")
    hours = [3600.0 * HOURS * one for one in (before, now)]
    ratio = hours[0] / hours[1]
    print(f"{'2 h, by the slope':40}{hours[0]:10.0f}{hours[1]:10.0f}{ratio:8.1f}  (goal {GOAL:g})")
    if whole is not None:
        ratio = hours[0] / whole
        print(f"{'2 h, measured now':40}{hours[0]:10.0f}{whole:10.0f}{ratio:8.1f}  (goal {GOAL:g})")
    row = {
        "what": "memory of a drive of 2 h, 4 DOF, 1 kHz",
        "before": hours[0],
        "now": hours[1] if whole is None else whole,
        "unit": "MB",
        "ratio": ratio,
        "goal": GOAL,
    }
    if given.json is not None:
        given.json.write_text(json.dumps([row], indent=2) + "\n")


if __name__ == "__main__":
    main()
