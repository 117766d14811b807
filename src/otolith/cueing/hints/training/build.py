"""Makes a hint for one platform, its pairs and settings: simulate, then fit."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict

from otolith.core.frames import Dof
from otolith.cueing.hints.stored import StoredHint, model_of
from otolith.cueing.hints.training.fit import Effort, OnProgress, fit_laws, fit_networks, fit_table
from otolith.cueing.hints.training.manoeuvres import Manoeuvre, along, training
from otolith.cueing.hints.training.recording import record
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform


def build(
    platform: Platform,
    pairs: Sequence[Dof],
    settings: MpcSettings,
    *,
    manoeuvres: Sequence[Manoeuvre] | None = None,
    effort: Effort | None = None,
    progress: OnProgress = lambda _: None,
) -> StoredHint:
    """Train on `manoeuvres`, by default those of `otolith.cueing.hints.training.manoeuvres.training`.

    Raises
    ------
    MissingExtra : scikit-learn is not installed.
    """
    effort = effort or Effort()
    clock = _Clock()
    scenarios = along(training() if manoeuvres is None else manoeuvres, pairs, seed=effort.seed)
    recording = record(
        platform,
        pairs,
        settings,
        scenarios,
        progress=lambda done: progress(f"simulating: {100 * done:.0f} %"),
    )
    clock.lap("simulate")
    networks, losses = fit_networks(
        platform, pairs, settings, recording=recording, effort=effort, progress=progress
    )
    clock.lap("learn")
    progress("table of visited sets")
    table = fit_table(platform, pairs, recording, effort)
    clock.lap("table")
    progress("explicit laws on the coarse grid")
    laws = fit_laws(platform, pairs, settings, recording, effort)
    clock.lap("law")
    account = {
        "steps": len(recording),
        "unsolved": int((~recording.solved).sum()),
        "loss": losses,
        "entries": len(table.parameters),
        "regions": sum(len(part) for part in laws.parameters),
        "network_bytes": sum(network.numbers.nbytes for network in networks),
        "effort": asdict(effort),
        "seconds": clock.laps,
    }
    return StoredHint(
        model=model_of(platform, pairs, settings), training=account, networks=networks, table=table, laws=laws
    )


class _Clock:
    """Measures the time of each part of the work [s]."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now, self._since, self.laps = now, now(), dict[str, float]()

    def lap(self, name: str) -> None:
        """End the part `name`."""
        now = self._now()
        self.laps[name], self._since = round(now - self._since, 3), now
