"""A study by processes of this machine, and by a Dask cluster of which workers are killed: the same?

    python benchmarks/studies.py [--loops N] [--jobs N] [--workers N] [--kill N]

The study closes loops of 20 s of `predictive` in 2 DOF, ten references for each of N/10 settings; a tenth
of the 10,000 loops that are asked for shows as much. It runs in local processes, then on a Dask cluster of
this machine, of whose workers some are killed while they work. Both stores must hold the same trials with the
same results and the same best, and their journals each result exactly once. Times depend on what else the
machine does; CPU time of a loop is printed beside.
"""

import argparse
import json
import os
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from otolith.studies.cluster import Cluster
from otolith.studies.definition import Study, parse_study
from otolith.studies.executors import Executor, Processes
from otolith.studies.jobs import JUDGING, TRAINING, Job, work
from otolith.studies.problem import Prepared, problem_of
from otolith.studies.results import Trial, best_of
from otolith.studies.search import Progress, Search
from otolith.studies.store import Store

REFERENCES = 10
TEXT = """
name = "benchmark"
cueing = "predictive"
training = [{references}]
objectives = [{{ measure = "tracking" }}, {{ measure = "travel" }}]
[parameters]
liveliness = {{ low = 0.0, high = 1.0 }}
"prediction.near" = {{ scale = "log", low = 0.5, high = 4.0 }}
"prediction.far" = {{ scale = "log", low = 0.3, high = 2.0 }}
"prediction.slope" = {{ scale = "log", low = 0.1, high = 1.5 }}
[budget]
trials = {trials}
batch = 20
"""


def study_of(loops: int) -> Study:
    """The study of so many loops."""
    wanted = [f'"multisine:seed={k},amplitude={0.5 + 0.15 * k},duration=20"' for k in range(REFERENCES)]
    text = TEXT.format(references=", ".join(wanted), trials=max(1, loops // REFERENCES))
    return parse_study(text, "benchmark.toml")


class Done:
    """The trials of one run of the study, its journal, and its time."""

    def __init__(self, prepared: Prepared, executor: Executor, path: Path, progress: Any) -> None:
        study = prepared.study
        definition = {"study": study.model_dump(mode="json"), "folder": ".", "digest": prepared.digest}
        began = time.monotonic()
        with Store.create(str(path), study.name, len(study.objectives), definition) as store:
            items = {TRAINING: len(prepared.training.items), JUDGING: 0}
            self.trials: list[Trial] = Search(study, store, items, executor, progress=progress).run()
        self.seconds = time.monotonic() - began
        self.repeated = repeated(path)


def repeated(path: Path) -> int:
    """How many results a journal holds beyond one of each job."""
    found: Counter[str] = Counter()
    for line in path.read_text("utf-8").splitlines():
        record = json.loads(line)
        for name in record.get("user_attr", {}):
            if name.startswith(TRAINING):
                found[f"{record['trial_id']} {name}"] += 1
    return sum(count - 1 for count in found.values())


def killing(cluster: Cluster, after: Sequence[int], told: list[int]) -> Any:
    """A progress that kills one worker at each of these numbers of jobs."""
    left = list(after)

    def tell(now: Progress) -> None:
        if left and now.jobs >= left[0]:
            left.pop(0)
            pids = sorted(cluster.client.run(os.getpid).values())
            victim = next(pid for pid in pids if pid not in told)
            told.append(victim)
            os.kill(victim, signal.SIGKILL)

    return tell


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loops", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--kill", type=int, default=2)
    options = parser.parse_args()
    prepared = problem_of(study_of(options.loops), Path.cwd())
    problems = {TRAINING: prepared.training, JUDGING: prepared.judging}
    loops = REFERENCES * prepared.study.budget.trials
    settings = (("liveliness", 0.5),)
    work(problems, (TRAINING, Job(settings, 0)))  # compiles
    began = time.thread_time()
    for k in range(REFERENCES):
        work(problems, (TRAINING, Job(settings, k)))
    cpu = (time.thread_time() - began) / REFERENCES
    print(
        f"one loop of 20 s and its measures: {1e3 * cpu:.0f} ms of CPU time, {20.0 / cpu:.0f} times real time"
    )
    with tempfile.TemporaryDirectory() as folder:
        with Processes(options.jobs, problems) as processes:
            here = Done(prepared, processes, Path(folder) / "here.journal", lambda _: None)
        rate = 3600 * loops / here.seconds
        print(f"{options.jobs} processes: {loops} loops in {here.seconds:.0f} s, {rate:,.0f}/h")
        killed: list[int] = []
        with Cluster("local", problems, workers=options.workers) as cluster:
            after = [loops * (k + 1) // (options.kill + 2) for k in range(options.kill)]
            there = Done(prepared, cluster, Path(folder) / "there.journal", killing(cluster, after, killed))
    print(f"{options.workers} workers of Dask, {len(killed)} killed: {loops} loops in {there.seconds:.0f} s")
    same = here.trials == there.trials
    best = [best_of(prepared.study, one.trials).number for one in (here, there)]
    results = sum(len(one.training) for one in there.trials)
    print(f"same trials and results: {same}; best: {best[0]} and {best[1]}")
    print(f"results: {results} of {loops}, of these twice: {here.repeated} and {there.repeated}")
    if not (same and best[0] == best[1] and results == loops and here.repeated == there.repeated == 0):
        raise SystemExit("the two runs differ")


if __name__ == "__main__":
    main()
