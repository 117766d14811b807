"""What a notebook shows of a run and of a comparison."""

import re
from dataclasses import replace

import pytest
from matplotlib import pyplot

from otolith.core.errors import InputError
from otolith.loop import Run
from otolith.metrics import summarise
from otolith.report.notebook import Comparison

EVIL = "<script>alert('x')</script>"


def test_a_run_shows_its_key_figures(handmade: Run) -> None:
    html = handmade._repr_html_()
    assert f"<td>{summarise(handmade)['rmse']:.4f}</td>" in html
    assert "<td>nobody</td>" in html
    assert "1 of 10" in html  # its tenth decision is a fallback
    assert len(html) < 2000
    assert not re.search("<script|<style|http", html)


def test_names_from_outside_are_text(handmade: Run) -> None:
    html = replace(handmade, cueing=EVIL, scenario=EVIL)._repr_html_()
    assert "<script" not in html
    assert "&lt;script" in html


def test_a_comparison_has_a_row_for_each_run(handmade: Run) -> None:
    both = Comparison([handmade, replace(handmade, cueing="somebody")])
    assert re.findall(r"<tr><td>(\w+)</td>", both._repr_html_()) == ["nobody", "somebody"]


def test_both_draw_and_leave_no_figure_open(handmade: Run) -> None:
    for one in (handmade, Comparison([handmade, replace(handmade, cueing="somebody")])):
        assert one.plot().axes
        with pytest.raises(InputError, match="degree of freedom is 'yaw', must be one of surge-pitch"):
            one.plot("yaw")
    assert pyplot.get_fignums() == []


def test_what_is_no_comparison_is_refused(handmade: Run) -> None:
    with pytest.raises(InputError, match="runs to compare is 1, must be at least 2"):
        Comparison([handmade])
    with pytest.raises(InputError, match="of 2 kinds"):
        Comparison([handmade, replace(handmade, scenario="another")])
