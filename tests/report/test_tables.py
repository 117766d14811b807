import re

from otolith.report import tables

SUMMARY = {
    "cueing": "hybrid-all",
    "rmse": 0.123456,
    "changes": {"mean": 2.0, "p99": 9.0, "max": 12},
    "violations": 0,
    "status": {"decided": 12345},
    "odd": {"a": 0.0, "b": 0.0, "c": 1e-3, "d": 0.0, "e": 0.0},
    "settling_time_s": 1.5,
    "new_<figure>": [1, "<b>", None, True],
    "residual_max": float("nan"),
    "nothing": {},
    "settings": {"secret": 1},
}


def plain(table: str) -> str:
    """A table without the heads that its cells repeat for narrow screens."""
    return re.sub(r' data-head="[^"]*"', "", table)


def test_known_figures_get_words_and_units() -> None:
    table = tables.key_figures(SUMMARY)
    assert "Tracking error of specific force (RMSE) <small>[m/s²]</small></th><td>0.1235" in table
    assert "<dt>99th percentile</dt><dd>9</dd>" in table
    assert "12\u202f345" in table


def test_unknown_figures_are_shown_and_escaped() -> None:
    table = tables.key_figures(SUMMARY)
    assert "settling time <small>[s]</small></th><td>1.5" in table
    assert "new &lt;figure&gt;</th><td>1, &lt;b&gt;, –, yes" in table
    assert "not a number" in table
    assert "nothing</th><td>–</td>" in table


def test_what_stands_elsewhere_is_not_repeated() -> None:
    assert "secret" not in tables.key_figures(SUMMARY)
    assert "hybrid-all" not in tables.key_figures(SUMMARY)


def test_many_zeros_are_counted_not_listed() -> None:
    table = tables.key_figures(SUMMARY)
    assert "<dt>c</dt><dd>0.001</dd></div></dl><p>0 for the other 4</p>" in table
    assert "0 for all 5" in tables.key_figures({"odd": dict.fromkeys("abcde", 0.0)})


def test_headline_is_else_against_the_first_model_and_sets_off_the_best() -> None:
    better = SUMMARY | {"changes": {"mean": 1.5, "p99": 9.0, "max": 8}, "rmse": 0.2}
    table = plain(tables.headline(["implicit", "<hybrid>"], [SUMMARY, better]))
    assert "Against implicit [%]" in table
    assert "−25.0" in table
    assert "<td class=best>1.5</td>" in table
    assert "<td class=best>0.1235</td>" in table
    assert "&lt;hybrid&gt;" in table
    assert "<td>9</td>" in table  # equal: none is best


def test_headline_prefers_the_percentages_that_the_summaries_tell() -> None:
    summaries = [SUMMARY | {"changes_against_implicit_percent": p} for p in (-35.0, 0.0)]
    table = plain(tables.headline(["hybrid", "implicit"], summaries))
    assert "Against implicit [%]" in table
    assert "<td>−35.0</td>" in table
    assert "<td>+0.0</td>" in table


def test_headline_does_without_figures_that_are_missing() -> None:
    table = plain(tables.headline(["a", "b"], [{}, {"changes": {"mean": 0.0}}]))
    assert "<td>–</td>" in table


def test_side_by_side_shows_the_union_of_all_figures() -> None:
    table = plain(tables.side_by_side(["a", "b"], [{"x": {"y_m": 1}}, {"z": -2.5}]))
    assert "x: y <small>[m]</small></th><td>1</td><td>–</td>" in table
    assert "z</th><td>–</td><td>−2.5</td>" in table


def test_who_solves_no_problem_has_a_dash_where_a_solver_would_have_changes() -> None:
    none = {"mean": 0.0, "p99": 0.0, "max": 0.0}
    washout = {"changes": none, "changes_against_implicit_percent": -100.0, "residual_max": 0.0}
    for table in (
        tables.headline(
            ["implicit", "washout"], [SUMMARY | {"changes_against_implicit_percent": 0.0}, washout]
        ),
        tables.side_by_side(["washout"], [washout]),
        tables.key_figures(washout),
    ):
        assert "100" not in table
        assert "–" in table
    assert "<td>+0.0</td><td>9</td>" not in table


def test_measures_of_many_kinds_are_a_small_table_without_those_that_never_were() -> None:
    never, once = {"count": 0, "peak": 0.0}, {"count": 1, "peak": 0.25}
    table = tables.key_figures({"false_cues": {"heave": {"missing": once, "scaled": never}}})
    assert '<th scope="col">peak <small>[m/s²]</small></th>' in table
    assert '<tr><th scope="row">missing</th><td>1</td><td>0.25</td></tr>' in table
    assert "scaled" not in table
    assert "<dd>none</dd>" in tables.key_figures({"false_cues": {"heave": {"missing": never}}})


def test_what_solvers_do_stands_last_and_every_cell_repeats_its_head() -> None:
    table = tables.headline(
        ["a", "b"], [SUMMARY, SUMMARY | {"status": {"decided": 1, "fallback (infeasible)": 4}}]
    )
    heads = re.findall(r'<th scope="col">([^<]*)</th>', table)
    assert heads[:2] == ["Cueing", "Error [m/s²]"]
    assert heads[-4:] == ["Mean changes", "Against a [%]", "Changes, p99", "Changes, max"]
    assert re.findall(r'data-head="([^"]*)"', table) == 2 * heads[1:]
    assert '<td data-head="Decisions failed">4</td>' in table


def test_what_turns_is_shown_in_degrees() -> None:
    summary = {"travel_rms": {"surge": 0.5, "pitch": 0.1}, "rate_rmse": {"yaw": 0.2}}
    table = tables.key_figures(summary)
    assert "<dt>surge</dt><dd>0.5</dd>" in table
    assert "<dt>pitch</dt><dd>5.73</dd>" in table
    assert "<dt>yaw</dt><dd>11.46</dd>" in table
    assert summary["travel_rms"]["pitch"] == 0.1  # what it was told stays as it is


def test_limits_are_told_in_their_own_unit() -> None:
    rate = {
        "name": "pitch rate", "soft": True, "comfort": True, "unit": "deg/s", "low": -3.0, "high": 3.0,
        "nodes_beyond": 310, "excess": 0.05961, "excess_between_nodes": None,
    }  # fmt: skip
    table = plain(tables.limits({"limits": {"surge-pitch tilt_rate": rate}}))
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", table)
    assert cells == ["±3 deg/s", "soft comfort threshold", "310", "0.0596 deg/s", "no number"]
    assert tables.limits({}) == ""


def test_the_distance_from_the_best_stands_in_words() -> None:
    by_dof = {"surge-pitch": {"times": 2.5, "error": 0.2, "through_lag": 0.0}}
    far = {
        "dofs": "surge-pitch",
        "plant": "ideal",
        "optimum": {"times": 2.5, "by_dof": by_dof, "plant": "ideal"},
    }
    near = far | {"optimum": far["optimum"] | {"times": None}}  # type: ignore[operator]
    unknown = far | {"optimum": {"not_computed": "add --optimum"}}
    table = plain(tables.side_by_side(["far", "unknown"], [far, unknown]))
    assert "<td>its error is 2.50 times the best that is possible on this drive (0.2000 m/s²)</td>" in table
    assert "<td>the best that is possible is not computed; add --optimum</td>" in table
    head = plain(tables.headline(["far", "near", "unknown"], [far, near, unknown]))
    for cell in (">2.5</td>", "<td>within reach</td>", "<td>not computed</td>"):
        assert cell in head
