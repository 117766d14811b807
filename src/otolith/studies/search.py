"""The search itself: settings are asked for in batches, and what they lead to is told in their order.

It depends neither on how many jobs are done at once, nor on which is done first, nor on interruptions.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from otolith.studies.ask import Memory
from otolith.studies.definition import Study
from otolith.studies.executors import Executor
from otolith.studies.jobs import JUDGING, TRAINING, Done, Job, work
from otolith.studies.results import State, Trial, excesses, front, values
from otolith.studies.store import Store

Work = Callable[[Any, tuple[str, Job]], Done]


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a study is."""

    trials: int  # that are done
    of: int
    jobs: int  # that were done since it was started
    seconds: float  # since then
    text: str

    @property
    def per_hour(self) -> float:
        """Return the number of closed loops in an hour."""
        return 3600.0 * self.jobs / max(self.seconds, 1e-9)


class Search:
    """Does what is left of a study.

    Parameters
    ----------
    items : number of references of each set.
    executor : does the jobs; what they have in common are the problems by set.
    do_one : the work, which tests replace.
    """

    def __init__(
        self,
        study: Study,
        store: Store,
        items: Mapping[str, int],
        executor: Executor,
        *,
        do_one: Work = work,
        progress: Callable[[Progress], None] = lambda _: None,
    ) -> None:
        self._study, self._store, self._items, self._executor = study, store, items, executor
        self._work, self._progress = do_one, progress
        self._jobs, self._began = 0, time.monotonic()

    def run(self) -> list[Trial]:
        """Do all trials that are left, judge the front, and return all trials."""
        self.judge(front(self._study, self.train()))
        return self._store.trials()

    def train(self) -> list[Trial]:
        """Do all trials that are left, and return all trials."""
        budget, store = self._study.budget, self._store
        memory = Memory(self._study, store)
        for first in range(0, budget.trials, budget.batch):
            numbers = range(first, min(first + budget.batch, budget.trials))
            for number in numbers[max(0, len(store.frozen()) - first) :]:
                store.add(*memory.ask(number))
            trials = {one.number: one for one in store.trials()[first : numbers.stop]}
            for trial in self._done(TRAINING, [t for t in trials.values() if t.state is State.OPEN]):
                trials[trial.number] = self._finished(trial)
            for number in numbers:
                memory.tell(trials[number])
        return store.trials()

    def judge(self, trials: Iterable[Trial]) -> None:
        """Run trials on the references for judging."""
        for _ in self._done(JUDGING, list(trials)):
            pass

    def _done(self, kind: str, trials: Sequence[Trial]) -> Iterator[Trial]:
        """Do the jobs that trials lack, and yield each trial once it lacks none."""
        count = self._items[kind]
        results = {one.number: dict(getattr(one, kind)) for one in trials}
        by_number = {one.number: one for one in trials}
        asked = [(one, k) for one in trials for k in range(count) if k not in results[one.number]]
        jobs = [(kind, Job(tuple(one.settings.items()), k)) for one, k in asked]
        yield from (
            _with(one, kind, results[one.number]) for one in trials if len(results[one.number]) == count
        )
        for place, done in self._executor.as_done(self._work, jobs):
            trial, item = asked[place]
            self._store.write(trial.number, trial.settings, kind, item, done)
            self._tell(kind, trial.number)
            results[trial.number][item] = done
            if len(results[trial.number]) == count:
                yield _with(by_number[trial.number], kind, results[trial.number])

    def _finished(self, trial: Trial) -> Trial:
        """Write what became of a trial whose training is done, and return it."""
        refused = any(done.refused for done in trial.training.values())
        state = State.REJECTED if refused else State.DONE
        if refused:
            self._store.finish(trial.number, state, (), {})
        else:
            found = values(self._study, trial.training)
            self._store.finish(trial.number, state, found, excesses(self._study, trial.training))
        return _with(trial, "state", state)

    def _tell(self, kind: str, number: int) -> None:
        self._jobs += 1
        trials = self._study.budget.trials
        text = "judging the front" if kind == JUDGING else f"trial {number + 1} of {trials}"
        seconds = time.monotonic() - self._began
        self._progress(Progress(trials=number, of=trials, jobs=self._jobs, seconds=seconds, text=text))


def _with(trial: Trial, name: str, value: object) -> Trial:
    return replace(trial, **{name: value})  # type: ignore[arg-type]
