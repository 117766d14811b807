"""The site of the docs: built without a warning, complete, and without a request to any other host."""

import importlib.util
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).parents[1]
FETCHED = {"link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src"}


def build(root: Path, site: Path) -> subprocess.CompletedProcess[str]:
    """Run the builder as `make docs` does, but leave notebooks as they are."""
    settings = ["-W", "--keep-going", "-E", "-q", "-D", "nb_execution_mode=off"]
    words = [
        sys.executable,
        "-m",
        "sphinx",
        *settings,
        "-d",
        str(site / "doctrees"),
        "-c",
        str(root / "docs"),
    ]
    return subprocess.run(
        [*words, str(root), str(site / "html")], capture_output=True, text=True, check=False
    )


def tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


class Page(HTMLParser):
    """What a page fetches as it is shown, where its links lead, and which anchors it has."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.anchors = {""}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if tag in FETCHED and FETCHED[tag] in given:
            self.fetched.append(given[FETCHED[tag]])
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        self.anchors.add(given.get("id", ""))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = build(ROOT, folder)
    assert done.returncode == 0, done.stderr
    return folder / "html"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}


def test_every_page_of_the_docs_is_on_the_site_and_in_its_navigation(
    pages: dict[Path, Page], site: Path
) -> None:
    first = pages[site / "index.html"]
    reached = {
        str((site / urlsplit(link).path).resolve().relative_to(site))
        for link in first.links
        if "//" not in link
    }
    for source in [*ROOT.glob("docs/*.md"), *ROOT.glob("docs/tutorials/*.md"), ROOT / "CHANGELOG.md"]:
        name = source.relative_to(ROOT).with_suffix(".html").as_posix()
        assert site / name in pages, f"{name} is missing"
        assert name in reached, f"{name} is not in the navigation"


def test_nothing_is_fetched_from_another_host(pages: dict[Path, Page], site: Path) -> None:
    for path, page in pages.items():
        others = [address for address in page.fetched if urlsplit(address).netloc]
        assert not others, f"{path.name} fetches {others}"
        assert page.fetched, f"{path.name} fetches nothing: this test looks at the wrong attributes"
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.findall(r"(?:@import|url\()\s*['\"]?(?:https?:)?//", text), style.name


def test_every_link_within_the_site_leads_somewhere(pages: dict[Path, Page]) -> None:
    links = [(path, link) for path, page in pages.items() for link in page.links]
    inner = [(path, urlsplit(link)) for path, link in links if not urlsplit(link).scheme]
    assert len(inner) > 1_000
    for path, link in inner:
        target = (path.parent / unquote(link.path)).resolve() if link.path else path
        assert target.is_file(), f"{path.name}: {link.geturl()}"
        if target in pages and link.fragment:
            assert unquote(link.fragment) in pages[target].anchors, f"{path.name}: {link.geturl()}"


def test_public_packages_are_in_the_reference() -> None:
    """A package that states its names in `__all__` makes them public, unless its code is for us alone."""
    ours = {"otolith.cli", "otolith.live.faults", "otolith.qp.structured", "otolith.recordings.events"}
    stated = {
        ".".join(file.relative_to(ROOT / "src").parent.parts)
        for file in (ROOT / "src").rglob("__init__.py")
        if "__all__ = " in file.read_text(encoding="utf-8")
    }
    table = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| \[(otolith[\w.]*)\]", table, re.MULTILINE))
    assert stated - told == ours


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A repository of three pages and one package, with our settings of the builder."""
    root = tmp_path / "root"
    shutil.copytree(ROOT / "tools", root / "tools")
    (root / "docs" / "_static").mkdir(parents=True)
    shutil.copy(ROOT / "docs" / "conf.py", root / "docs")
    shutil.copy(ROOT / "docs" / "_static" / "site.css", root / "docs" / "_static")
    package = root / "src" / "otolith"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('"""A package."""\n', encoding="utf-8")
    (root / "README.md").write_text("# Home\n\n[docs](docs/README.md)\n", encoding="utf-8")
    (root / "docs" / "README.md").write_text(
        "# Docs\n\n## All\n\n| page | what |\n|---|---|\n| [api](api.md) | names |\n", encoding="utf-8"
    )
    (root / "docs" / "api.md").write_text(
        "# API\n\n| package | what |\n|---|---|\n| [otolith](../src/otolith/__init__.py) | all |\n",
        encoding="utf-8",
    )
    return root


def test_a_whole_repository_is_built(small: Path, tmp_path: Path) -> None:
    done = build(small, tmp_path / "site")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "site" / "html" / "docs" / "api" / "otolith.html").is_file()


def test_what_is_wrong_ends_the_build(small: Path, tmp_path: Path) -> None:
    lines = ["# Changes", "[x](docs/api.md#no-such)", "[x](docs/none.md)", "![x](none.png)"]
    (small / "CHANGELOG.md").write_text("\n\n".join(lines), encoding="utf-8")
    (small / "docs" / "lost.md").write_text("# Lost\n", encoding="utf-8")
    done = build(small, tmp_path / "site")
    assert done.returncode == 1
    for said in (
        "no-such",
        "docs/none",
        "none.png",
        "lost.md: WARNING: document isn't included in any toctree",
    ):
        assert said in done.stderr


def test_the_reference_tells_shapes_defaults_and_what_is_raised(tmp_path: Path) -> None:
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "__init__.py").write_text(
        '"""A pack."""\n\nfrom typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n'
        '    from pack.part import Part, made\n__all__ = ["Part", "made"]\n'
    )
    (tmp_path / "pack" / "part.py").write_text(
        "class Part(Base):\n"
        '    """A part of x_k and y_k."""\n\n'
        "    mass: Vec = field(default_factory=lambda: np.zeros(3))  # (3,) [kg] of a|b\n"
        "    _own: int = 0\n"
        "    @property\n"
        "    def weight(self) -> float:\n"
        '        """Weight [N]."""\n'
        "    def _inner(self) -> None:\n        pass\n"
        "    def moved(self, by: float, *, twice: bool = False) -> Part:\n"
        '        """Move it.\n\n        Raises\n        ------\n        TooFar : it is moved\n'
        "            too far.\n"
        '        """\n'
        "@kernel\ndef made(n: int) -> Part:\n"
        '    """Make one."""\n'
    )
    text = tool("api_pages").page("pack", tmp_path)
    assert "| `mass` | `Vec` | `np.zeros(3)` | (3,) \\[kg\\] of a\\|b |" in text
    assert "A part of x\\_k and y\\_k." in text
    assert "Part.weight: float" in text
    assert "Part.moved(by: float, *, twice: bool=False) -> Part" in text
    assert "- `TooFar`: it is moved too far." in text
    assert "made(n: int) -> Part" in text
    assert "_own" not in text
    assert "_inner" not in text


def test_a_name_that_the_source_does_not_have_ends_the_reference(tmp_path: Path) -> None:
    (tmp_path / "pack.py").write_text('__all__ = ["lost"]\n')
    with pytest.raises(KeyError, match=r"pack\.lost"):
        tool("api_pages").page("pack", tmp_path)
