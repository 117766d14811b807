"""Appendix B: step responses of the perception models (Tables B.2, B.4), and its figures."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from otolith_thesis import perception_study as study
from otolith_thesis.jobs import Answers
from otolith_thesis.outcome import Bearing, Claim, Curve, Outcome, Panel
from otolith_thesis.perception_study import PERIOD, Responses, StepCharacteristics
from otolith_thesis.published import published
from otolith_thesis.studies.common import bearing
from otolith_thesis.verdict import Number, judged

_OURS: Final = {
    "rise_time": lambda one: one.rise_time / PERIOD,  # the thesis prints samples and calls them seconds
    "settling_time": lambda one: one.settling_time,
    "settling_min": lambda one: one.minimum,
    "settling_max": lambda one: one.maximum,
}
_READING: Final = (
    "Samples every 0.05 s, the step held until 15.05 s, the final value the one at 45 s. In this reading "
    "the thesis's rise times are counted in samples, and are towards a last value of a few thousandths: "
    "they do not say how fast an organ answers."
)


def _table(name: str, ours: Mapping[str, StepCharacteristics], fast: str) -> Outcome:
    printed = published(name)
    numbers: list[Number] = []
    for column in _OURS:
        numbers += judged(
            [
                Number(
                    row=row["model"],
                    column=column,
                    published=float(row[column]),
                    ours=_OURS[column](ours[row["model"]]),
                    digits=4 if column != "rise_time" or row[column] > 0.001 else 8,
                )
                for row in printed.rows
            ]
        )
    rises = {model: one.rise_time for model, one in ours.items()}
    return Outcome(
        name=name,
        kind="table",
        title=printed.title,
        section=printed.section,
        text=_READING,
        numbers=tuple(sorted(numbers, key=lambda number: list(ours).index(number.row))),
        claims=(
            Claim(
                text=f"The model of {fast.capitalize()} has the smallest rise time",
                holds=min(rises, key=rises.__getitem__) == fast,
                figures=", ".join(f"{model} {1e3 * value:.3g} ms" for model, value in rises.items()),
            ),
        ),
        reasons=("study-table-b.2",) if name == "table-b.2" else (),
    )


def table_b2(answers: Answers) -> Outcome:
    """Build Table B.2 from the printed parameters of Table B.1."""
    del answers
    return _table("table-b.2", study.table_b2(), "telban")


def table_b4(answers: Answers) -> Outcome:
    """Build Table B.4 from the printed parameters of Table B.3."""
    del answers
    return _table("table-b.4", study.table_b4(), "telban")


def exchanged(answers: Answers) -> Outcome:
    """Show that in Table B.2 the columns of Young and Ormsby are exchanged, and one has a short lag."""
    del answers
    printed = {row["model"]: row for row in published("table-b.2").rows}
    lagged = study.in_thesis_reading(study.YOUNG_IN_TABLE_B2.system())
    ormsby = study.table_b2()["ormsby"]
    pairs = {"Ormsby's column": (lagged, printed["ormsby"]), "Young's column": (ormsby, printed["young"])}
    gaps = {
        name: max(abs(_OURS[column](one) / row[column] - 1.0) for column in _OURS)
        for name, (one, row) in pairs.items()
    }
    return Outcome(
        name="study-table-b.2",
        kind="study",
        title="Table B.2: the columns of Young and Ormsby are exchanged",
        section="B.1",
        text=(
            "Ormsby's parameters give Young's column, and Young's with a short lag of 0.04 s, where Table "
            "B.1 prints 0, give Ormsby's."
        ),
        claims=(
            Claim(
                text="The columns stand under their names",
                holds=max(gaps.values()) > 0.001,
                figures="exchanged, largest relative difference: "
                + ", ".join(f"{name} {100 * gap:.3f} %" for name, gap in gaps.items()),
            ),
        ),
        bears_on=bearing(["table-b.2"], max(gaps.values()) <= 0.001, Bearing.EXPLAINS),
    )


def _panels(models: Mapping[str, Responses]) -> tuple[Panel, ...]:
    def overlay(title: str, y_label: str, x: str, y: str) -> Panel:
        return Panel(
            title=title,
            x_label="time [s]" if x == "time" else "frequency [rad/s]",
            y_label=y_label,
            log_x=x != "time",
            curves=tuple(
                Curve(label=name, x=np.asarray(getattr(one, x)), y=np.asarray(getattr(one, y)))
                for name, one in models.items()
            ),
        )

    return (
        overlay("Step response", "response", "time", "output"),
        overlay("Magnitude", "[dB]", "omega", "magnitude_db"),
        overlay("Phase", "[deg]", "omega", "phase_deg"),
    )


def figure_b1(answers: Answers) -> Outcome:
    """Draw figure B.1."""
    del answers
    return Outcome(
        name="figure-b.1",
        kind="figure",
        title="Step and frequency response of the semicircular canals",
        section="B.1",
        panels=_panels(study.figure_b1()),
    )


def figure_b2(answers: Answers) -> Outcome:
    """Draw figure B.2."""
    del answers
    return Outcome(
        name="figure-b.2",
        kind="figure",
        title="Step and frequency response of the otolith organs",
        section="B.1",
        panels=_panels(study.figure_b2()),
    )


def figure_b3(answers: Answers) -> Outcome:
    """Draw figure B.3, where "by the same factor" is read as 1.5."""
    del answers
    found = [study.figure_b3(factor) for factor in (0.5, 1.0, 1.5)]
    return Outcome(
        name="figure-b.3",
        kind="figure",
        title="Sensitivity analysis of Telban's otolith",
        section="B.1",
        text="The gain times 0.5 and, since the text says no other number, 1.5.",
        panels=(
            *_panels({f"sensitivity, gain × {one.factor:g}": one.sensitivity for one in found})[1:2],
            *_panels({f"otolith, gain × {one.factor:g}": one.otolith for one in found}),
        ),
    )
