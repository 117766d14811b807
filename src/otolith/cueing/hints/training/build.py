"""Makes a hint for one platform, its pairs and settings: simulate, then fit."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from otolith.core.frames import Dof
from otolith.core.jobs import Workers
from otolith.cueing.hints.stored import StoredHint, model_of
from otolith.cueing.hints.training.fit import Effort, OnProgress, fit_laws, fit_network, fit_table
from otolith.cueing.hints.training.manoeuvres import Manoeuvre, along, training
from otolith.cueing.hints.training.recording import Recording, record
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform


def _tell_nobody(_: str) -> None:
    """Report no progress."""


def build(
    platform: Platform,
    pairs: Sequence[Dof],
    settings: MpcSettings,
    *,
    manoeuvres: Sequence[Manoeuvre] | None = None,
    effort: Effort | None = None,
    jobs: int = 1,
    progress: OnProgress = _tell_nobody,
) -> StoredHint:
    """Train on `manoeuvres`, by default those of `otolith.cueing.hints.training.manoeuvres.training`.

    Parameters
    ----------
    jobs : number of processes that share the manoeuvres, and then what is fitted; the hint is the same.

    Raises
    ------
    MissingExtra : scikit-learn is not installed.
    """
    effort = effort or Effort()
    scenarios = along(training() if manoeuvres is None else manoeuvres, pairs, seed=effort.seed)
    began = time.perf_counter()
    recording = record(
        platform,
        pairs,
        settings,
        scenarios,
        jobs=jobs,
        progress=lambda done: progress(f"simulating: {100 * done:.0f} %"),
    )
    simulated = time.perf_counter() - began
    lessons = _Lessons(platform, tuple(pairs), settings, recording, effort, progress)
    parts: list[int | str] = [*range(len(pairs)), "law", "table"]  # networks by pair; the longest first

    def note(part: int | str) -> None:
        progress(f"fitted: {part if isinstance(part, str) else pairs[part].name}")

    with Workers(jobs, lessons if jobs < 2 else replace(lessons, progress=_tell_nobody)) as workers:
        *fitted, (laws, law_s), (table, table_s) = workers.each(_fitted, parts, note)
    networks = tuple(network for (network, _), _ in fitted)
    account = {
        "steps": len(recording),
        "unsolved": int((~recording.solved).sum()),
        "loss": tuple(loss for (_, loss), _ in fitted),
        "entries": len(table.parameters),
        "regions": sum(len(part) for part in laws.parameters),
        "network_bytes": sum(network.numbers.nbytes for network in networks),
        "effort": asdict(effort),
        "seconds": {
            "simulate": round(simulated, 3),
            "learn": round(sum(seconds for _, seconds in fitted), 3),
            "table": round(table_s, 3),
            "law": round(law_s, 3),
        },
    }
    return StoredHint(
        model=model_of(platform, pairs, settings), training=account, networks=networks, table=table, laws=laws
    )


@dataclass(frozen=True)
class _Lessons:
    """Everything from which the parts of a hint are fitted, each by itself."""

    platform: Platform
    pairs: tuple[Dof, ...]
    settings: MpcSettings
    recording: Recording
    effort: Effort
    progress: OnProgress


def _fitted(of: _Lessons, part: int | str) -> tuple[Any, float]:
    """Fit the network of a pair, by number, or the "table" or "law"; return it, and how long it took [s]."""
    began = time.perf_counter()
    fitted: Any
    if part == "table":
        of.progress("table of visited sets")
        fitted = fit_table(of.platform, of.pairs, of.recording, of.effort)
    elif part == "law":
        of.progress("explicit laws on the coarse grid")
        fitted = fit_laws(of.platform, of.pairs, of.settings, of.recording, of.effort)
    else:
        fitted = fit_network(
            of.platform,
            of.pairs,
            of.settings,
            int(part),
            recording=of.recording,
            effort=of.effort,
            progress=of.progress,
        )
    return fitted, time.perf_counter() - began
