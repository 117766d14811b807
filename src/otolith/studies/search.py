"""The search itself: settings are asked for in batches, and what they lead to is told in their order.

It depends neither on how many jobs are done at once, nor on which is done first, nor on interruptions.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from otolith.studies.ask import Memory
from otolith.studies.definition import Study
from otolith.studies.executors import Executor
from otolith.studies.jobs import JUDGING, TRAINING, Done, Job, work
from otolith.studies.prune import Pruning
from otolith.studies.results import State, Trial, excesses, front, values
from otolith.studies.store import Store

Work = Callable[[Any, tuple[str, Job]], Done]


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a study is."""

    trials: int  # number of the one that was done last
    jobs: int  # that were done since it was started
    seconds: float  # since then
    share: float  # of the training, or of the judging, that is done
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
        self._jobs, self._share, self._began = 0, 0.0, time.monotonic()

    def run(self) -> list[Trial]:
        """Do all trials that are left, judge the front, and return all trials."""
        self.judge(front(self._study, self.train()))
        return self._store.trials()

    def train(self) -> list[Trial]:
        """Do all trials that are left, and return all trials."""
        budget, store = self._study.budget, self._store
        memory, pruning = Memory(self._study, store), Pruning(self._study, self._items[TRAINING])
        for first in range(0, budget.trials, budget.batch):
            numbers = range(first, min(first + budget.batch, budget.trials))
            for number in numbers[max(0, len(store.frozen()) - first) :]:
                store.add(number, *memory.ask(number))
            trials = self._trained(store.trials(numbers), pruning)
            for number in numbers:
                memory.tell(trials[number])
                pruning.learn(trials[number])
        return store.trials()

    def _trained(self, trials: Sequence[Trial], pruning: Pruning) -> dict[int, Trial]:
        """Do what the trials of a batch lack, and return them by number; some end early, after a rung."""
        found = {one.number: one for one in trials if one.state is not State.OPEN}
        going = [one for one in trials if one.state is State.OPEN]
        for count in pruning.rungs:
            reached, going = self._done(TRAINING, going, count), []
            for trial in reached:
                state = self._state(trial, count, pruning)
                if state is State.OPEN:
                    going.append(trial)
                else:
                    found[trial.number] = self._finished(trial, state)
        return found

    def judge(self, trials: Iterable[Trial]) -> None:
        """Run trials on the references for judging."""
        for _ in self._done(JUDGING, list(trials), self._items[JUDGING]):
            pass

    def _done(self, kind: str, trials: Sequence[Trial], count: int) -> Iterator[Trial]:
        """Do the jobs that trials lack on the first references, and yield each trial once it lacks none."""
        results = {one.number: dict(getattr(one, kind)) for one in trials}
        by_number = {one.number: one for one in trials}
        asked = [(one, k) for one in trials for k in range(count) if k not in results[one.number]]
        jobs = [(kind, Job(tuple(one.settings.items()), k)) for one, k in asked]
        lacking = Counter(one.number for one, _ in asked)
        yield from (one for one in trials if not lacking[one.number])
        for nth, (place, done) in enumerate(self._executor.as_done(self._work, jobs), start=1):
            trial, item = asked[place]
            self._store.write(trial.number, trial.settings, kind, item, done)
            self._tell(kind, trial.number, nth / len(jobs))
            results[trial.number][item] = done
            lacking[trial.number] -= 1
            if not lacking[trial.number]:
                yield _with(by_number[trial.number], kind, results[trial.number])

    def _state(self, trial: Trial, count: int, pruning: Pruning) -> State:
        """Return what has become of an open trial that has results on the first references."""
        if any(done.refused for done in trial.training.values()):
            return State.REJECTED
        if count == self._items[TRAINING]:
            return State.DONE
        return State.PRUNED if pruning.ends(trial, count) else State.OPEN

    def _finished(self, trial: Trial, state: State) -> Trial:
        """Write what became of a trial, and return it."""
        if state is State.DONE:
            found = values(self._study, trial.training)
            self._store.finish(trial.number, state, found, excesses(self._study, trial.training))
        else:
            self._store.finish(trial.number, state, (), {})
        return _with(trial, "state", state)

    def _tell(self, kind: str, number: int, share: float) -> None:
        """Tell how far the study is.

        Parameters
        ----------
        share : of the jobs of this kind that were asked for together.
        """
        self._jobs += 1
        trials = self._study.budget.trials
        if kind == TRAINING:
            share = self._share = max(self._share, number / trials)  # jobs are not done in their order
        text = "judging" if kind == JUDGING else f"trial {number + 1} of {trials}"
        seconds = time.monotonic() - self._began
        self._progress(Progress(trials=number, jobs=self._jobs, seconds=seconds, share=share, text=text))


def _with(trial: Trial, name: str, value: object) -> Trial:
    return replace(trial, **{name: value})  # type: ignore[arg-type]
