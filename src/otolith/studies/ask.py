"""Which settings are tried next: Optuna's samplers, asked so that the answer can be repeated.

It depends on the study's seed, the number of the trial and the results of earlier batches alone: a sampler is
made anew for every trial, with a seed of its own, and asks in a study in memory, a copy of what the store
holds.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from otolith.studies.definition import Parameter, Study
from otolith.studies.engine import optuna
from otolith.studies.results import State, Trial, excesses, values
from otolith.studies.store import CONSTRAINT, STATES, Store

Asked = tuple[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]]


class Memory:
    """The copy in memory."""

    def __init__(self, study: Study, store: Store) -> None:
        self._of = study
        self._space = {name: distribution(one) for name, one in study.parameters.items()}
        self._storage: Any = optuna.storages.InMemoryStorage()
        directions = [optuna.study.StudyDirection.MINIMIZE] * len(study.objectives)
        self._study = optuna.create_study(storage=self._storage, directions=directions)
        self._id: int = self._storage.get_all_studies()[0]._study_id
        self._known = set()
        for one in store.frozen():
            self._storage.create_new_trial(self._id, template_trial=one)
            if one.state.is_finished():
                self._known.add(one.number)

    def ask(self, number: int) -> Asked:
        """Return the parameters of a new trial, their distributions, and what the sampler notes about it."""
        self._study.sampler = sampler(self._of, number, self._space)
        if number < len(self._of.start):
            self._study.enqueue_trial(dict(self._of.start[number]))
        self._study.ask(self._space)
        frozen = self._storage.get_trial(self._place(number))
        return dict(frozen.params), dict(frozen.distributions), dict(frozen.system_attrs)

    def tell(self, trial: Trial) -> None:
        """Learn what became of a trial, unless it is known."""
        if trial.number in self._known:
            return
        self._known.add(trial.number)
        if trial.state is not State.DONE:
            self._study.tell(trial.number, state=STATES[trial.state])
            return
        for name, excess in excesses(self._of, trial.training).items():
            self._storage.set_trial_system_attr(self._place(trial.number), f"{CONSTRAINT}{name}", excess)
        self._study.tell(trial.number, values(self._of, trial.training))

    def _place(self, number: int) -> int:
        found: int = self._storage.get_trial_id_from_study_id_trial_number(self._id, number)
        return found


def distribution(parameter: Parameter) -> Any:
    """Return a parameter as Optuna knows it."""
    if parameter.scale == "choice":
        return optuna.distributions.CategoricalDistribution(parameter.of)
    low, high = parameter.low, parameter.high
    if low is None or high is None:  # which `Parameter` has refused
        raise ValueError("a range without bounds")
    if parameter.scale == "integer":
        return optuna.distributions.IntDistribution(int(low), int(high), step=parameter.step)
    return optuna.distributions.FloatDistribution(low, high, log=parameter.scale == "log")


def sampler(study: Study, number: int, space: Mapping[str, Any]) -> Any:
    """Return the sampler of one trial, with a seed made of the study's seed and the trial's number.

    Parameters
    ----------
    space : distributions by name.
    """
    budget = study.budget
    seed = int(np.random.SeedSequence([budget.seed, number]).generate_state(1)[0])
    if budget.sampler == "nsga2":
        return _Nsga2(space, population_size=budget.batch, seed=seed)
    if budget.sampler == "tpe":
        return optuna.samplers.TPESampler(n_startup_trials=budget.batch, seed=seed)
    return optuna.samplers.RandomSampler(seed=seed)


class _Nsga2(optuna.samplers.NSGAIISampler):
    """NSGA-II in a space that is known; a new sampler would look for it in all trials, at every trial."""

    def __init__(self, space: Mapping[str, Any], **others: Any) -> None:
        super().__init__(**others)
        self._known = dict(sorted(space.items()))

    def infer_relative_search_space(self, study: Any, trial: Any) -> dict[str, Any]:  # noqa: ARG002
        """Return the space."""
        return self._known
