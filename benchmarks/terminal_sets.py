"""The set of an axis beside its limits, where it could still stop, and the wedge that was too short.

    python benchmarks/terminal_sets.py [--out FILE]

Place and speed of surge on two platforms, whatever the acceleration is (the sets' shadows). Dots: states that
keep all rows with half the wedge's time, and from which no command leads to another such state.
"""

import argparse
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.spatial import ConvexHull

from otolith.core.arrays import Mat
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.axis_sets import axis_sets
from otolith.cueing.mpc.rows import BrakingRows
from otolith.platforms import load
from otolith.report import palette
from otolith.safety.invariant.axis import AxisSet
from otolith.safety.invariant.contraction import cells
from otolith.safety.invariant.polytope import halfspaces

PLATFORMS: Final = ("davsi", "thesis")
SET, SHORT, STOP = palette.BLUE, palette.VERMILION, palette.GREY


def shadow(of: AxisSet) -> Mat:
    """Corners (n, 2) of the set's shadow on place and speed, the first one repeated as the last."""
    points = np.vstack([cell.vertices for cell in cells(of)])[:, :2]
    order = ConvexHull(points).vertices
    closed: Mat = points[[*order, order[0]]]
    return closed


def stuck(of: AxisSet, samples: int = 4000) -> Mat:
    """Random states (n, 2) on the boundary from which no command leads back into the set."""
    C, b = halfspaces(of.rows)
    A, B = of.axis.dynamics()
    corners = np.vstack([cell.vertices for cell in cells(of)])
    X = np.random.default_rng(0).dirichlet(np.full(len(corners), 0.1), samples) @ corners
    X /= (X @ C.T / b).max(axis=1)[:, None]
    commands = np.linspace(-of.axis.command, of.axis.command, 2001)
    least = [((C @ (A @ x)[:, None] + np.outer(C @ B, commands)) / b[:, None]).max(axis=0).min() for x in X]
    found: Mat = X[np.array(least) > 1.0 + 1e-3][:, :2]
    return found


def draw(axes: Axes, name: str) -> None:
    """One platform."""
    proved = axis_sets(load(name), SURGE_PITCH, BrakingRows.STOPPING, lag=0.01, period=0.01)[0]
    (low, high), V = proved.axis.limits.position, proved.axis.limits.velocity
    v = np.linspace(0.0, min(V, np.sqrt(2.0 * proved.axis.command * (high - low))), 200)
    way = v**2 / (2.0 * proved.axis.command)
    axes.plot(high - way, v, color=STOP, lw=1.2, label="full braking ends within the reach")
    axes.plot(low + way, -v, color=STOP, lw=1.2)
    short = proved._replace(ahead=0.5 * proved.ahead)
    axes.plot(*shadow(short).T, color=SHORT, lw=1.2, ls="--", label="half the wedge's time: not proved")
    axes.plot(*stuck(short).T, ".", color=SHORT, ms=2.5, label="no command leads back")
    axes.fill(*shadow(proved).T, color=SET, alpha=0.18)
    axes.plot(*shadow(proved).T, color=SET, lw=1.8, label="the set: never to be left")
    axes.axvline(low, color="k", lw=0.6)
    axes.axvline(high, color="k", lw=0.6)
    axes.set_title(f"{name}, surge", loc="left", fontsize=10)
    axes.set_xlabel("place [m]")
    axes.set_ylabel("speed [m/s]")
    axes.spines[["top", "right"]].set_visible(False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/images/terminal-sets.png"))
    chosen = parser.parse_args()
    figure, panels = plt.subplots(1, 2, figsize=(9.5, 4.2), layout="constrained")
    for axes, name in zip(panels, PLATFORMS, strict=True):
        draw(axes, name)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8, frameon=False
    )
    figure.savefig(chosen.out, dpi=130)


if __name__ == "__main__":
    main()
