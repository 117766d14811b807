"""Which trials end early: those that earlier trials beat by every objective on the first references.

After a reference, a trial's *partial score* by an objective is the objective's value on the references so
far. Optuna's percentile pruner compares it with the partial scores, after the same reference, of trials that
were finished in earlier batches. A trial ends early if the pruner of every objective says so: what is good by
one objective may be on the front. The decision depends on results alone, so it is the same however many jobs
are done at once, and an interrupted study decides again as it did.
"""

from collections.abc import Mapping
from typing import Any

from otolith.studies.definition import Study
from otolith.studies.engine import optuna
from otolith.studies.jobs import Done
from otolith.studies.results import State, Trial, values


class Pruning:
    """Knows the partial scores of finished trials, and judges those that are under way.

    Parameters
    ----------
    items : number of references on which a trial is trained.
    """

    def __init__(self, study: Study, items: int) -> None:
        budget = study.budget
        self._of, self._items = study, items
        known = len(study.objectives) if budget.prune_percentile is not None else 0
        self._known = [optuna.create_study() for _ in range(known)]  # one for each objective
        self._pruner = optuna.pruners.PercentilePruner(
            budget.prune_percentile or 50.0, n_startup_trials=budget.batch
        )

    @property
    def rungs(self) -> tuple[int, ...]:
        """Return after how many references trials are judged, and last the number of all references."""
        first = min(self._of.budget.prune_after, self._items) if self._known else self._items
        return tuple(range(first, self._items + 1))

    def ends(self, trial: Trial, count: int) -> bool:
        """Return whether its results on the first `count` references make a trial not worth another one."""
        if not self._known:
            return False
        scores = values(self._of, _first(trial.training, count))
        return all(
            self._pruner.prune(known, _under_way({count: score}))
            for known, score in zip(self._known, scores, strict=True)
        )

    def learn(self, trial: Trial) -> None:
        """Learn the partial scores of a trial of a finished batch, if it has results on all references."""
        if trial.state is not State.DONE or not self._known:
            return
        partial = [values(self._of, _first(trial.training, count)) for count in self.rungs]
        for place, known in enumerate(self._known):
            known.add_trial(
                optuna.trial.create_trial(
                    value=partial[-1][place],
                    intermediate_values={
                        count: scores[place] for count, scores in zip(self.rungs, partial, strict=True)
                    },
                )
            )


def _first(results: Mapping[int, Done], count: int) -> dict[int, Done]:
    """Return the results on the first references."""
    return {item: results[item] for item in range(count)}


def _under_way(score: Mapping[int, float]) -> Any:
    """Return a trial of Optuna that has this score only.

    Its earlier scores are left out, because the pruner judges by the best of all of them, and the error on an
    easy first reference would hide what the harder ones have shown.
    """
    running = optuna.trial.TrialState.RUNNING
    return optuna.trial.create_trial(state=running, intermediate_values=dict(score))
