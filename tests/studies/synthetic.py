"""A study whose jobs are formulas, so that its machinery is tested without a closed loop."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from otolith.studies.definition import Study, parse_study
from otolith.studies.executors import Processes
from otolith.studies.jobs import JUDGING, TRAINING
from otolith.studies.results import Trial
from otolith.studies.search import Search
from otolith.studies.store import Store
from tests.studies.formulas import formula

TEXT = """
name = "formula"
cueing = "implicit"
training = ["sine-1", "step-1"]
judging = ["sine-2"]
objectives = [{ measure = "tracking" }, { measure = "travel" }]
[parameters]
"weight.position" = { scale = "log", low = 0.01, high = 1.0 }
"weight.velocity" = { low = 0.0, high = 1.0 }
horizon = { scale = "integer", low = 10, high = 50, step = 10 }
braking = { scale = "choice", of = ["stopping", "none"] }
[[start]]
"weight.position" = 0.1
"weight.velocity" = 0.5
horizon = 30
braking = "none"
[budget]
trials = 14
batch = 4
[presets.calm]
travel = 1.0
[presets.lively]
tracking = 1.0
"""


def study(**budget: Any) -> Study:
    """The study, with other numbers in its budget."""
    known = parse_study(TEXT, "formula.toml")
    return known.model_copy(update={"budget": known.budget.model_copy(update=budget)})


class Interrupted(Exception):
    """What a test interrupts with."""


class Stopping:
    """An executor that stops after a number of jobs, and counts how often each was done."""

    def __init__(self, jobs: float = float("inf"), backwards: bool = False) -> None:
        self.left, self.backwards, self.done = jobs, backwards, []  # type: ignore[var-annotated]

    def __enter__(self) -> "Stopping":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def as_done(self, work: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        order = range(len(items))
        for k in reversed(order) if self.backwards else order:
            if self.left == 0:
                raise Interrupted
            self.left -= 1
            self.done.append(items[k])
            yield k, work(None, items[k])


def search(of: Study, store: Store, executor: Any = None, do_one: Any = formula) -> list[Trial]:
    """Run the study to its end."""
    made = executor or Processes(1, None)
    return Search(of, store, {TRAINING: 2, JUDGING: 1}, made, do_one=do_one).run()


def created(where: str | Path, of: Study) -> Store:
    """A new store for a study."""
    return Store.create(str(where), of.name, len(of.objectives), {"study": of.model_dump(mode="json")})
