"""`otolith example`: write files to start from, on which every command of the README works."""

from importlib.resources import files as package_files
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer

from otolith import files
from otolith.cli.output import Force, screen
from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.platforms.template import template

_SAMPLES: Final = package_files("otolith.cli") / "samples"
_HEADER: Final = "t_s,speed_mps,ax_mps2,ay_mps2,yaw_rate_radps"
_RATE: Final = 50.0  # [Hz]
_START_SPEED: Final = 15.0  # [m/s]
# Manoeuvres of the drive: start [s], end [s], and peak.
_PEDALS: Final = ((2.0, 8.0, 1.5), (16.0, 20.0, -3.0), (30.0, 36.0, -1.8))  # [m/s²]
_TURNS: Final = ((9.0, 15.0, 0.12), (21.0, 24.0, 0.15), (24.0, 27.0, -0.15))  # [rad/s]


def example_(
    out: Annotated[Path, typer.Option(help="Folder for the files.")] = Path("example"),
    force: Force = False,
) -> None:
    """Write files to start from: drive.csv, rig.toml, tuning.toml, and a cueing algorithm, washout.py."""
    if out.is_dir() and any(out.iterdir()) and not force:
        bound = "empty, absent or another name; --force replaces the folder and all that it holds"
        raise InputError(f"output {out}", "a folder with files, which may be yours", bound)
    with files.whole_folder(out, command="example", force=force) as made:
        with files.whole(made / "drive.csv") as place:
            np.savetxt(place, drive(), fmt="%.6g", delimiter=",", header=_HEADER, comments="")
        files.write_text(made / "rig.toml", template("axes"))
        for name in ("tuning.toml", "washout.py"):
            files.write_text(made / name, (_SAMPLES / name).read_text(encoding="utf-8"))
    console = screen()
    console.print(f"written to {out}: drive.csv, rig.toml, tuning.toml, washout.py; try", soft_wrap=True)
    at = f"--log {out / 'drive.csv'} --platform {out / 'rig.toml'}"
    console.print(f"otolith run {at}", soft_wrap=True)
    console.print(f"otolith run {at} --cueing classical --tuning {out / 'tuning.toml'}", soft_wrap=True)
    console.print(f"otolith run sine-1 --cueing {out / 'washout.py'}:HighPass", soft_wrap=True)
    console.print(f"python {out / 'washout.py'}", soft_wrap=True)


def drive() -> Mat:
    """Return forty seconds of a car on level ground: the columns of drive.csv (n, 5), without contradictions.

    The speed is the integral of a_x, and a_y is speed times yaw rate, as of a car that does not slide.
    """
    t = np.arange(0.0, 40.0, 1.0 / _RATE)
    ax, yaw_rate = _bumps(t, _PEDALS), _bumps(t, _TURNS)
    gained = np.r_[0.0, np.cumsum(0.5 * (ax[1:] + ax[:-1]))] / _RATE
    speed = _START_SPEED + gained
    return np.stack([t, speed, ax, speed * yaw_rate, yaw_rate], axis=1)


def _bumps(t: Vec, manoeuvres: tuple[tuple[float, float, float], ...]) -> Vec:
    """Sum raised cosines, one per manoeuvre, which begin and end without a jump."""
    total = np.zeros(len(t))
    for begin, end, peak in manoeuvres:
        phase = np.clip((t - begin) / (end - begin), 0.0, 1.0)
        total += peak * np.sin(np.pi * phase) ** 2
    return total
