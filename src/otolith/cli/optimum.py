"""The best that a platform can do for a drive: `otolith optimum`, and the comparison of runs with it."""

import functools
from pathlib import Path
from typing import Final

from rich.console import Console

from otolith import files, registry
from otolith.cli.loop import Prepared
from otolith.cli.options import RunOptions, with_run_options
from otolith.cli.output import Force, file_name, print_json, screen, sentence, warn, working
from otolith.cli.results import Figures, Json, Out, write_results
from otolith.core.errors import InputError, OtolithError
from otolith.cueing.optimum import NAME, Optimum, check, measure_of
from otolith.loop import Run
from otolith.metrics.against_best import NOT_COMPUTED

LONGEST: Final = 60.0  # [s] longest drive whose optimum is computed without --optimum, in a few seconds
_ON_FIRST_USE: Final = "the solver is compiled on first use (some 5 s), then cached"


@with_run_options
def optimum(
    choices: RunOptions,
    out: Out = None,
    figures: Figures = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find the best motion for a scenario or a drive that is known as a whole, and write it as a run.

    No algorithm that has to decide without knowing the future can do better within the same limits.
    """
    console = screen()
    _refuse_what_it_ignores(choices)
    design = choices.design()
    scenario = choices.wanted().along(design, note=functools.partial(warn, console))
    folder = out or Path("out") / f"{file_name(scenario.name)}-optimum"
    files.check_folder(folder, command="optimum", force=force)
    with working(console, f"solving; {_ON_FIRST_USE}"):
        found = choices.experiment(NAME, design).optimum(scenario)
    summary = write_results(found.run, folder, command="optimum", force=force, best=found, figures=figures)
    if json:
        print_json(summary)
    console.print(sentence(summary), highlight=False, soft_wrap=True)
    certified = f"certified to {found.certificate.worst:.1e} after {found.iterations} steps"
    console.print(f"{certified}; written to {folder}", highlight=False, soft_wrap=True)


def _refuse_what_it_ignores(choices: RunOptions) -> None:
    """Refuse options of algorithms and plants, which would have no effect."""
    read = frozenset().union(*(entry.reads for entry in registry.CUEING.own.values())) | {"plant"}
    for option in sorted(choices.given & read):
        word = f"--{option.replace('_', '-')}"
        raise InputError(word, "given, but the optimum would ignore it", "left out")


class Yardstick:
    """The optimum of every scenario, computed once for each ideal plant.

    Parameters
    ----------
    asked : True for --optimum, False for --no-optimum; None: it is computed for drives of at most `LONGEST`.

    Raises
    ------
    InputError : --optimum is given for a drive without an optimum; no time has been spent yet.
    """

    def __init__(self, prepared: Prepared, asked: bool | None, console: Console) -> None:
        self._prepared, self._asked, self._console = prepared, asked, console
        self._found: dict[tuple[int, str], Optimum | str] = {}
        if asked:
            for scenario in prepared.scenarios:
                check(scenario)

    def best(self, k: int, cueing: str) -> Optimum | str:
        """Return the optimum of scenario k on the plant of an algorithm, or in words why it is unknown."""
        key = k, measure_of(self._prepared.plants[cueing])
        if key not in self._found:
            self._found[key] = self._seek(k, cueing)
        return self._found[key]

    def drawn(self, k: int) -> Run | None:
        """Return the optimum's run that pages of scenario k show, which is that of the first algorithm."""
        best = self.best(k, next(iter(self._prepared.plants)))
        return None if isinstance(best, str) else best.run

    def _seek(self, k: int, cueing: str) -> Optimum | str:
        scenario = self._prepared.scenarios[k]
        if self._asked is False:
            return NOT_COMPUTED
        if self._asked is None and scenario.duration > LONGEST:
            return f"the drive lasts {scenario.duration:.4g} s, more than {LONGEST:g} s: {NOT_COMPUTED}"
        try:
            with working(self._console, f"the best that is possible on {scenario.name}; {_ON_FIRST_USE}"):
                return self._prepared.experiments[k][cueing].optimum(scenario)
        except OtolithError as error:
            warn(self._console, f"the best that is possible on {scenario.name} is not known: {error}")
            return str(error)
