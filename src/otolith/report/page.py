"""The frame of every page: head, banner, contents, parts that fold. A page needs nothing else, no network."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from typing import Final

MANY: Final = 5  # parts, from where on a page begins with a list of them


@dataclass(frozen=True, slots=True)
class Part:
    """A titled part of a page; its body is HTML. A folded one shows its title until it is opened."""

    title: str
    body: str
    folded: bool = False


def page(
    title: str,
    kind: str,
    lead: str,
    parts: Sequence[Part],
    *,
    styles: Sequence[str] = (),
    scripts: Sequence[str] = (),
    contents: str | None = None,
) -> str:
    """A whole page; everything but the title is HTML.

    Parameters
    ----------
    lead : what stands under the title.
    styles, scripts : assets of this page beside those of every page, in their order.
    contents : links to the page's parts; none given: a list of all parts where they are many.
    """
    listed = contents_of(parts) if contents is None else contents
    style = "".join(asset(name) for name in ("page.css", *styles))
    script = "".join(f"<script>{asset(name)}</script>\n" for name in ("folds.js", *scripts))
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)} – Otolith</title>
<style>{style}</style>
</head>
<body>
<header>
<p class="kind">Otolith <span>{escape(kind)}</span></p>
<h1>{escape(title)}</h1>
{lead}
{listed}
</header>
<main>
{"".join(_part(key, part) for key, part in keyed(parts).items())}
</main>
<footer>Made by Otolith. This page is complete in itself.</footer>
{script}</body>
</html>
"""


@cache
def asset(name: str) -> str:
    """A file that pages carry within: one of Otolith's by its name, another package's as "package:name"."""
    package, _, own = name.rpartition(":")
    return (files(package or "otolith.report") / "assets" / own).read_text(encoding="utf-8")


def keyed(parts: Sequence[Part]) -> dict[str, Part]:
    """Parts by what a link to them points at: their titles' words, numbered where two would be the same."""
    found: dict[str, Part] = {}
    for part in parts:
        words = re.sub(r"\W+", "-", part.title.lower()).strip("-") or "part"
        key = words
        while key in found:
            key = f"{words}-{len(found)}"
        found[key] = part
    return found


def contents_of(parts: Sequence[Part]) -> str:
    """Links to the parts of a page, where they are many."""
    if len(parts) <= MANY:
        return ""
    links = "".join(
        f'<li><a href="#{key}">{escape(part.title)}</a></li>' for key, part in keyed(parts).items()
    )
    return f'<nav class="contents" aria-label="Contents"><ol>{links}</ol></nav>'


def anchor(key: str) -> str:
    """A small link to a part beside its title, to copy."""
    return f'<a class="anchor" href="#{key}" aria-label="link to this part">#</a>'


def table(kind: str, heads: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """A table of HTML cells, each with its head said again, for a narrow screen stacks the cells of a row.

    Parameters
    ----------
    heads : of all columns, the first that of the rows' names; plain text.
    rows : name of a row, and its cells as whole elements `<td…>…</td>`.
    """
    head = "".join(f'<th scope="col">{escape(text)}</th>' for text in heads)
    body = "".join(
        f'<tr><th scope="row">{name}</th>'
        + "".join(
            cell.replace("<td", f'<td data-head="{escape(text)}"', 1)
            for text, cell in zip(heads[1:], cells, strict=True)
        )
        + "</tr>"
        for name, cells in rows
    )
    return f'<table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def _part(key: str, part: Part) -> str:
    heading = f"<h2>{escape(part.title)}</h2>{anchor(key)}"
    if part.folded:
        return f'<details class="part" id="{key}"><summary>{heading}</summary>{part.body}</details>\n'
    return f'<section class="part" id="{key}"><div class="heading">{heading}</div>{part.body}</section>\n'
