"""All reproduced items of the thesis by name, in the thesis's order."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from otolith.core.errors import InputError, one_of
from otolith_thesis import (
    braking,
    emulator_tables,
    explicit,
    figures,
    lap_tables,
    model_tables,
    perception_tables,
    washout_tables,
)
from otolith_thesis.jobs import Answers, Job, OnProgress, do_all
from otolith_thesis.model_tables import ADAPTIVE_2, ADAPTIVE_4, CONSTANT_2
from otolith_thesis.outcome import Outcome
from otolith_thesis.studies import (
    counting,
    cues,
    effort,
    emulator,
    explicit_signals,
    laps,
    misprints,
    redundant,
    regions,
    signals,
    weights,
)

Build = Callable[[Answers], Outcome]


@dataclass(frozen=True, slots=True)
class Item:
    """One table, figure or study: the jobs it needs, and how their results are combined."""

    chapter: str  # "chapter-5", "chapter-6", "appendix-b", "appendix-c" or "studies"
    build: Build
    jobs: Callable[[], Iterable[Any]] = tuple


def _explicit(chapter: str, name: str) -> tuple[str, Item]:
    return name, Item(chapter, partial(explicit.table, name), partial(explicit.cases, name))


def _drawn(chapter: str, name: str) -> tuple[str, Item]:
    figure = figures.DRAWN[name]
    return name, Item(chapter, figure.outcome, lambda: [figure.loop])


def _iterations(chapter: str, name: str, setting: model_tables.Setting) -> tuple[str, Item]:
    return name, Item(chapter, partial(model_tables.iterations, name, setting), setting.counted)


def _percentages(chapter: str, name: str, counts: str, setting: model_tables.Setting) -> tuple[str, Item]:
    return name, Item(chapter, partial(model_tables.percentages, name, counts, setting), setting.loops)


def _errors(chapter: str, name: str, setting: model_tables.Setting, pair: str) -> tuple[str, Item]:
    return name, Item(chapter, partial(model_tables.errors, name, setting, pair=pair), setting.loops)


def _emulated(name: str) -> tuple[str, Item]:
    return name, Item(
        "chapter-6", partial(emulator_tables.emulator_table, name), emulator_tables.emulator_jobs
    )


def _emulator_figure(chapter: str, name: str) -> tuple[str, Item]:
    return name, Item(
        chapter, partial(emulator_tables.emulator_figure, name), partial(emulator_tables.figure_jobs, name)
    )


def _lap(name: str) -> tuple[str, Item]:
    return name, Item("chapter-6", partial(lap_tables.lap_table, name), lap_tables.lap_jobs)


def _lap_figure(chapter: str, name: str) -> tuple[str, Item]:
    return name, Item(
        chapter, partial(lap_tables.lap_figure, name), partial(lap_tables.lap_figure_jobs, name)
    )


_LONG, _LAT = "surge-pitch", "sway-roll"
ITEMS: Final[dict[str, Item]] = dict(
    (
        ("figure-4.2", Item("chapter-5", figures.figure_4_2)),
        ("figure-5.1", Item("chapter-5", figures.figure_5_1)),
        _drawn("chapter-5", "figure-5.2"),
        _explicit("chapter-5", "table-5.2"),
        _drawn("chapter-5", "figure-5.3"),
        _drawn("chapter-5", "figure-5.4"),
        (
            "figure-5.5",
            Item(
                "chapter-5",
                figures.figure_5_5,
                lambda: [figures.DRAWN[name].loop for name in ("figure-5.3", "figure-5.4")],
            ),
        ),
        _drawn("chapter-5", "figure-5.6"),
        _drawn("chapter-5", "figure-5.7"),
        ("table-5.3", Item("chapter-5", washout_tables.best, washout_tables.best_jobs)),
        ("table-5.4", Item("chapter-5", washout_tables.compared, washout_tables.compared_jobs)),
        _drawn("chapter-5", "figure-5.8"),
        _iterations("chapter-5", "table-5.5", ADAPTIVE_2),
        _percentages("chapter-5", "table-5.6", "table-5.5", ADAPTIVE_2),
        _errors("chapter-5", "table-5.7", ADAPTIVE_2, _LONG),
        _explicit("chapter-5", "table-5.8"),
        _drawn("chapter-5", "figure-5.9"),
        _drawn("chapter-5", "figure-5.10"),
        _drawn("chapter-5", "figure-5.11"),
        _drawn("chapter-5", "figure-5.12"),
        _iterations("chapter-5", "table-5.9", ADAPTIVE_4),
        _percentages("chapter-5", "table-5.10", "table-5.9", ADAPTIVE_4),
        _errors("chapter-5", "table-5.11", ADAPTIVE_4, _LONG),
        _errors("chapter-5", "table-5.12", ADAPTIVE_4, _LAT),
        *(_emulated(name) for name in ("table-6.2", "table-6.3")),
        _emulator_figure("chapter-6", "figure-6.2"),
        *(_lap(name) for name in ("table-6.4", "table-6.5")),
        ("figure-6.3", Item("chapter-6", lap_tables.map_figure, lap_tables.map_jobs)),
        *(_lap_figure("chapter-6", name) for name in ("figure-6.4", "figure-6.5")),
        ("table-b.2", Item("appendix-b", perception_tables.table_b2)),
        ("figure-b.1", Item("appendix-b", perception_tables.figure_b1)),
        ("table-b.4", Item("appendix-b", perception_tables.table_b4)),
        ("figure-b.2", Item("appendix-b", perception_tables.figure_b2)),
        ("figure-b.3", Item("appendix-b", perception_tables.figure_b3)),
        ("figure-c.1", Item("appendix-c", braking.figure_c1)),
        ("figure-c.2", Item("appendix-c", figures.figure_c2, figures.timed_jobs)),
        ("figure-c.3", Item("appendix-c", figures.figure_c3, figures.timed_jobs)),
        _explicit("appendix-c", "benchmark-c.2"),
        _drawn("appendix-c", "figure-c.4"),
        _drawn("appendix-c", "figure-c.5"),
        _explicit("appendix-c", "table-c.1"),
        _explicit("appendix-c", "table-c.2"),
        _explicit("appendix-c", "table-c.3"),
        _iterations("appendix-c", "table-c.4", CONSTANT_2),
        _percentages("appendix-c", "table-c.5", "table-c.4", CONSTANT_2),
        _errors("appendix-c", "table-c.6", CONSTANT_2, _LONG),
        _drawn("appendix-c", "figure-c.6"),
        _drawn("appendix-c", "figure-c.7"),
        *(_emulator_figure("appendix-c", name) for name in ("figure-c.8", "figure-c.9")),
        *(_lap_figure("appendix-c", f"figure-c.{number}") for number in (10, 11, 12, 13)),
        ("study-filters", Item("studies", misprints.filters)),
        ("study-signs", Item("studies", misprints.signs, misprints.sign_jobs)),
        ("study-guess", Item("studies", effort.guess, effort.guess_jobs)),
        (
            "study-braking-rows",
            Item("studies", braking.printed_rows, braking.row_jobs),
        ),
        ("study-braking-bound", Item("studies", braking.bound, lambda: braking.ATTACKS)),
        ("study-circle", Item("studies", signals.circle, signals.circle_jobs)),
        ("study-step", Item("studies", signals.step, signals.step_jobs)),
        ("study-explicit-signals", Item("studies", explicit_signals.study, explicit_signals.jobs)),
        ("study-weights", Item("studies", weights.weights, weights.weights_jobs)),
        ("study-constant-weights", Item("studies", weights.constant_weights, weights.constant_jobs)),
        ("study-terminal", Item("studies", weights.terminal, weights.terminal_jobs)),
        ("study-start", Item("studies", effort.start, effort.start_jobs)),
        ("study-solver", Item("studies", effort.solver, effort.solver_jobs)),
        ("study-acado-start", Item("studies", counting.acado, counting.acado_jobs)),
        ("study-mean", Item("studies", counting.means, counting.mean_jobs)),
        ("study-false-cues", Item("studies", cues.study, cues.jobs)),
        ("study-damping", Item("studies", effort.damping, effort.damping_jobs)),
        ("study-emulator-weights", Item("studies", emulator.weights, emulator.weights_jobs)),
        ("study-emulator-guess", Item("studies", emulator.guess, emulator.guess_jobs)),
        ("study-lap-size", Item("studies", laps.size, laps.size_jobs)),
        ("study-arithmetic", Item("studies", misprints.arithmetic)),
        ("study-tolerance", Item("studies", regions.tolerance, regions.tolerance_jobs)),
        ("study-open-parameters", Item("studies", regions.open_parameters, regions.reach_jobs)),
        ("study-overlaps", Item("studies", regions.overlaps, regions.overlap_jobs)),
        ("study-table-6.1", Item("studies", misprints.table_6_1)),
        ("study-redundant", Item("studies", redundant.study, redundant.jobs)),
        ("study-table-b.2", Item("studies", perception_tables.exchanged)),
    )
)
CHAPTERS: Final = tuple(dict.fromkeys(item.chapter for item in ITEMS.values()))
# These items take half a minute on one core, and change whenever a controller, a solver or a law changes.
QUICK: Final = (
    "table-5.8",
    "figure-5.11",
    "table-c.2",
    "table-b.2",
    "table-b.4",
    "figure-c.6",
    "figure-c.7",
    "study-filters",
    "study-braking-rows",
    "study-braking-bound",
    "study-arithmetic",
    "study-table-6.1",
    "study-table-b.2",
)


def chosen(words: Sequence[str]) -> list[str]:
    """Return the items that names, chapters, "quick" or "all" mean, each once, in the thesis's order.

    Raises
    ------
    InputError : a word is none of these.
    """
    names: set[str] = set()
    for word in words:
        found = {name for name, item in ITEMS.items() if word in (name, item.chapter, "all")}
        found |= set(QUICK) if word == "quick" else set()
        if not found:
            raise InputError("ITEM", repr(word), one_of([*ITEMS, *CHAPTERS, "quick", "all"], word))
        names |= found
    return [name for name in ITEMS if name in names]


def reproduce(names: Sequence[str], *, processes: int, progress: OnProgress) -> list[Outcome]:
    """Run the jobs of the items, each once, and build the items from their results."""
    jobs: list[Job] = [job for name in names for job in ITEMS[name].jobs()]
    answers = do_all(jobs, processes=processes, progress=progress)
    return [ITEMS[name].build(answers) for name in names]
