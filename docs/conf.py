"""How Sphinx makes the site of the pages that also stand, readable as they are, in the repository.

    sphinx-build -W --keep-going -E -c docs . site        (make docs)

The root of the repository is the source, so every relative link means the same on the site and in the
repository. What leads where is read from the tables of docs/README.md, and what the API reference holds from
the table of docs/api.md: the reader of the repository and the site's navigation cannot disagree.
"""

import re
import shutil
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from api_pages import write_api_pages  # noqa: E402
from source_digest import source_digest  # noqa: E402

project = "Otolith"
author = "The Otolith developers"
copyright = author  # noqa: A001 (Sphinx reads this name)
html_title = "Otolith"
language = "en"

root_doc = "README"
include_patterns = [
    "*.md",
    "docs/*.md",
    "docs/**/*.md",
    "docs/notebooks/*.ipynb",
    "thesis/README.md",
    "src/otolith/vehicle/data/README.md",
]
exclude_patterns = [".*", "site", "jupyter_execute", "**/.ipynb_checkpoints"]

extensions = ["myst_nb", "sphinx_copybutton"]
myst_heading_anchors = 5  # the same anchors as a repository's pages have
copybutton_exclude = ".linenos, .gp, .go"
suppress_warnings: list[str] = []

# What a notebook shows depends on the source, which its cache does not look at.
nb_execution_mode = "cache"
nb_execution_cache_path = str(ROOT / ".docs_cache" / source_digest(ROOT / "src" / "otolith")[:16])
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "friendly", "monokai"

_TABLE_LINK = re.compile(r"^\| \[[^\]]*\]\(([^)#]+)\)", re.MULTILINE)


def navigation(text: str) -> str:
    """Return hidden tables of contents, one for each section of a page whose tables begin with links."""
    trees = []
    for title, section in re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL):
        if pages := _TABLE_LINK.findall(section):
            trees.append(
                toctree(title, [f"/{(ROOT / 'docs' / page).resolve().relative_to(ROOT)}" for page in pages])
            )
    return "\n\n".join(trees)


def toctree(title: str, pages: list[str]) -> str:
    """Return the directive that makes these pages, named from the root, a section of the navigation."""
    return "\n".join(["```{toctree}", f":caption: {title}", ":hidden:", "", *pages, "```"])


def extend(_app: object, name: str, source: list[str]) -> None:
    """Give the first page the whole navigation, and the page of the API its parts."""
    if name == "README":
        overview = toctree("Otolith", ["/docs/README"])
        source[0] += (
            f"\n\n{overview}\n\n{navigation((ROOT / 'docs/README.md').read_text(encoding='utf-8'))}\n"
        )
    elif name == "docs/api":
        parts = sorted(f"/docs/api/{path.stem}" for path in (ROOT / "docs" / "api").glob("*.md"))
        source[0] += f"\n\n{toctree('Packages', parts)}\n"


def begin(_app: object, _config: object) -> None:
    """Write the pages of the API before Sphinx looks for pages."""
    write_api_pages(ROOT / "docs" / "api.md", ROOT / "src", ROOT / "docs" / "api")


def end(app: Any, failure: Exception | None) -> None:
    """Let the site's address itself lead to its first page."""
    if failure is None and app.builder.name == "html":
        shutil.copyfile(Path(app.outdir) / "README.html", Path(app.outdir) / "index.html")


def setup(app: Any) -> None:
    """Connect the functions above with Sphinx."""
    app.connect("config-inited", begin)
    app.connect("source-read", extend)
    app.connect("build-finished", end)
