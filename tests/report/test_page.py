"""The frame of every page."""

from otolith.report.page import MANY, Part, contents_of, keyed, page, table


def test_parts_of_the_same_words_have_places_of_their_own() -> None:
    parts = [Part(title, "") for title in ("sine: 1", "Sine 1", "sine-1-1", "sine (1)", "…")]
    keys = list(keyed(parts))
    assert keys[0] == "sine-1"
    assert len(set(keys)) == len(parts)
    text = page("t", "k", "", parts, contents=contents_of([*parts, Part("more", "")]))
    for key in keys:
        assert text.count(f'id="{key}"') == 1
        assert f'href="#{key}"' in text


def test_contents_are_for_pages_of_many_parts() -> None:
    few = [Part(str(k), "") for k in range(MANY)]
    assert contents_of(few) == ""
    assert contents_of([*few, Part("<one more>", "")]).count("<li>") == MANY + 1


def test_titles_are_text_and_folded_parts_fold() -> None:
    text = page("<title>", "<kind>", "", [Part("<b>", "<i>body</i>", folded=True)])
    assert "<h2>&lt;b&gt;</h2>" in text
    assert "<h1>&lt;title&gt;</h1>" in text
    assert "<i>body</i></details>" in text
    assert "&lt;kind&gt;" in text


def test_every_cell_says_its_head_again() -> None:
    text = table("models", ("name", 'a "quoted" head'), [("x", ["<td class=best>1</td>"])])
    assert '<td data-head="a &quot;quoted&quot; head" class=best>1</td>' in text
