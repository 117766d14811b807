"""The frame of every page: head, banner, contents, foldable parts. A page works without a network."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from typing import Final

MANY: Final = 5  # a page with more parts begins with a list of contents


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a page: a title and an HTML body. A folded part shows only its title until it is opened."""

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
    """Return a whole page; all texts but the title are HTML.

    Parameters
    ----------
    lead : text below the title.
    styles, scripts : assets of this page in addition to those of every page, in order.
    contents : links to the page's parts; if None, all parts are listed if there are many.
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
    """Return the text of a file that is embedded in pages; "package:name" is one of another package."""
    package, _, own = name.rpartition(":")
    return (files(package or "otolith.report") / "assets" / own).read_text(encoding="utf-8")


def keyed(parts: Sequence[Part]) -> dict[str, Part]:
    """Return parts by the name of their anchor, made of the words of the title and a number if needed."""
    found: dict[str, Part] = {}
    for part in parts:
        words = re.sub(r"\W+", "-", part.title.lower()).strip("-") or "part"
        key = words
        while key in found:
            key = f"{words}-{len(found)}"
        found[key] = part
    return found


def contents_of(parts: Sequence[Part]) -> str:
    """Return links to the parts of a page if there are many parts."""
    if len(parts) <= MANY:
        return ""
    links = "".join(
        f'<li><a href="#{key}">{escape(part.title)}</a></li>' for key, part in keyed(parts).items()
    )
    return f'<nav class="contents" aria-label="Contents"><ol>{links}</ol></nav>'


def anchor(key: str) -> str:
    """Return a small link to a part, next to its title."""
    return f'<a class="anchor" href="#{key}" aria-label="link to this part">#</a>'


def table(kind: str, heads: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """Return a table of HTML cells; each repeats its column's head, because narrow screens stack the cells.

    Parameters
    ----------
    heads : heads of all columns, the first for the names of the rows; plain text.
    rows : name of each row, and its cells as elements `<td…>…</td>`.
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
