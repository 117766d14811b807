"""The curve tells the share of decisions with at least so many changes."""

import numpy as np

from otolith.report.changes import changes_figure


def test_curves_fall_from_the_share_that_changes_at_all_to_the_worst() -> None:
    changes = np.array([0.0, 0.0, 1.0, 4.0, np.nan])
    figure = changes_figure([("previous", changes), ("learned", changes / 2.0)])
    first, second = figure.axes[0].lines
    np.testing.assert_allclose(np.asarray(first.get_xdata()), [1.0, 4.0])
    np.testing.assert_allclose(np.asarray(first.get_ydata()), [0.5, 0.25])
    assert first.get_color() != second.get_color()
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["previous", "learned"]
