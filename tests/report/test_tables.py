from otolith.report import tables

SUMMARY = {
    "cueing": "hybrid-all",
    "rmse": 0.123456,
    "changes": {"mean": 2.0, "p99": 9.0, "max": 12},
    "violations": 0,
    "status": {"optimal": 12345},
    "worst_excess": {"a": 0.0, "b": 0.0, "c": 1e-3, "d": 0.0, "e": 0.0},
    "settling_time_s": 1.5,
    "new_<figure>": [1, "<b>", None, True],
    "residual_max": float("nan"),
    "nothing": {},
    "settings": {"secret": 1},
}


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
    assert "0 for all 5" in tables.key_figures({"worst_excess": dict.fromkeys("abcde", 0.0)})


def test_headline_is_else_against_the_first_model_and_sets_off_the_best() -> None:
    better = SUMMARY | {"changes": {"mean": 1.5, "p99": 9.0, "max": 8}, "rmse": 0.2}
    table = tables.headline(["implicit", "<hybrid>"], [SUMMARY, better])
    assert "Against implicit [%]" in table
    assert "−25.0" in table
    assert "<td class=best>1.5</td>" in table
    assert "<td class=best>0.1235</td>" in table
    assert "&lt;hybrid&gt;" in table
    assert "<td>9</td>" in table  # equal: none is best


def test_headline_prefers_the_percentages_that_the_summaries_tell() -> None:
    told = [SUMMARY | {"changes_against_implicit_percent": p} for p in (-35.0, 0.0)]
    table = tables.headline(["hybrid", "implicit"], told)
    assert "Against implicit [%]" in table
    assert "<td>−35.0</td>" in table
    assert "<td>+0.0</td>" in table


def test_headline_does_without_figures_that_are_missing() -> None:
    table = tables.headline(["a", "b"], [{}, {"changes": {"mean": 0.0}}])
    assert "<td>–</td>" in table


def test_side_by_side_shows_the_union_of_all_figures() -> None:
    table = tables.side_by_side(["a", "b"], [{"x": {"y_m": 1}}, {"z": -2.5}])
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
