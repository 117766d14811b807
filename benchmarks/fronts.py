"""Is the front of the study `predictive` the same with another seed, and do its presets beat the default?

    python benchmarks/fronts.py [--trials N] [--seeds 1 2] [--jobs N]

The shipped study is run once with each seed, with the horizon and the blocks that `predictive` has, since
each other pair of them would have to be compiled. Compared are the hypervolumes of the fronts, each objective
scaled to 0 … 1 over all of them: the volume of all values that a front beats, after each batch of trials.
Presets are then run on the references that are held out, beside `predictive` as it is shipped, at three
values of liveliness.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from optuna._hypervolume import compute_hypervolume  # the only part of Optuna that is asked for directly

from otolith.core.arrays import Mat
from otolith.core.jobs import number_of_jobs
from otolith.cueing.mpc.settings import BLOCKS
from otolith.studies.definition import Study, load_study
from otolith.studies.executors import Processes
from otolith.studies.jobs import JUDGING, TRAINING, Job, do
from otolith.studies.problem import Prepared, problem_of
from otolith.studies.results import State, Trial, average, front, preset_of, values
from otolith.studies.search import Search
from otolith.studies.store import Store

BATCH = 30
FIXED = ("horizon", "block_count")


def study_of(trials: int, seed: int) -> Study:
    """The shipped study with other numbers in its budget, and with the blocks of `predictive`."""
    shipped = load_study("predictive")
    budget = shipped.budget.model_copy(update={"trials": trials, "batch": BATCH, "seed": seed})
    kept = {name: one for name, one in shipped.parameters.items() if name not in FIXED}
    start = tuple({name: one[name] for name in kept} for one in shipped.start)  # liveliness 1/2, 0 and 1
    blocks = {"blocks": ",".join(map(str, BLOCKS))}
    return shipped.model_copy(
        update={"parameters": kept, "start": start, "fixed": blocks, "budget": budget},
    )


def searched(prepared: Prepared, jobs: int) -> list[Trial]:
    """All trials of a study, with the presets and the first trial judged on what is held out."""
    study, problems = prepared.study, {TRAINING: prepared.training, JUDGING: prepared.judging}
    store = Store.create("", study.name, len(study.objectives), {})
    with Processes(jobs, problems) as executor:
        items = {kind: len(one.items) for kind, one in problems.items()}
        search = Search(study, store, items, executor)
        trials = search.train()
        chosen = {preset_of(study, trials, name).number for name in study.presets} | {0}
        search.judge([trials[number] for number in sorted(chosen)])
    return store.trials()


def hypervolumes(fronts: Sequence[Mat]) -> list[float]:
    """The volume that each front beats, of the box around all of them."""
    together = np.vstack(fronts)
    low, high = together.min(axis=0), together.max(axis=0)
    return [float(compute_hypervolume((one - low) / (high - low), np.ones(len(low)))) for one in fronts]


def printed(name: str, found: Sequence[float]) -> None:
    """Print one line of the table of held-out references."""
    print(f"{name:34s}" + "".join(f"{value:12.4f}" for value in found), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--jobs", type=int, default=None)
    options = parser.parse_args()
    sampled, names = [], [one.measure for one in load_study("predictive").objectives]
    for seed in options.seeds:
        began = time.monotonic()
        prepared = problem_of(study_of(options.trials, seed), Path.cwd())
        study, trials = prepared.study, searched(prepared, number_of_jobs(options.jobs))
        best = front(study, trials)
        sampled.append(trials)
        early = sum(one.state is State.PRUNED for one in trials)
        loops = sum(len(one.training) + len(one.judging) for one in trials)
        print(
            f"seed {seed}: {len(trials)} trials, {early} ended early, {loops} loops, {len(best)} on the front"
        )
        print(f"{time.monotonic() - began:.0f} s; on what was held out:")
        print(" " * 34 + "".join(f"{name[:10]:>12s}" for name in names))
        for preset in study.presets:
            chosen = trials[preset_of(study, trials, preset).number]
            printed(f"{preset}, trial {chosen.number}", values(study, chosen.judging))
            print("    ", {name: f"{value:.4g}" for name, value in chosen.settings.items()})
    shipped = prepared.judging
    of_predictive = replace(shipped, cueing="predictive", fixed={})
    for liveliness in (0.0, 0.5, 1.0):
        done = {
            k: do(of_predictive, Job((("liveliness", liveliness),), k)) for k in range(len(shipped.items))
        }
        printed(f"predictive, liveliness {liveliness}", [average(one, done) for one in study.objectives])
    counts = range(BATCH, options.trials + 1, BATCH)  # a shorter search is the beginning of a longer one
    fronts = [
        np.array([values(study, one.training) for one in front(study, trials[:count])])
        for count in counts
        for trials in sampled
    ]
    volumes = np.reshape(hypervolumes(fronts), (len(counts), len(sampled)))
    for count, row in zip(counts, volumes, strict=True):
        apart = 100 * (max(row) / min(row) - 1)
        print(f"{count} trials, hypervolumes", *(f"{one:.4f}" for one in row), f"apart by {apart:.1f} %")


if __name__ == "__main__":
    main()
