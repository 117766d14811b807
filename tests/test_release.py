"""What a release is judged by: licences, sizes, links of the README, one version everywhere."""

import importlib.util
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import pytest

import otolith
from otolith.core.version import NOT_INSTALLED, installed

ROOT = Path(__file__).parents[1]


def tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def release_check(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return tool("release_check")


def test_the_version_is_that_of_the_installed_distribution() -> None:
    assert otolith.__version__ == installed() == version("otolith")
    assert installed("no-such-distribution") == NOT_INSTALLED


def test_the_version_is_not_looked_up_before_it_is_asked_for() -> None:
    program = (
        "import sys, otolith;"
        "assert 'otolith.core.version' not in sys.modules; otolith.__version__;"
        "assert 'otolith.core.version' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize(
    ("expression", "allowed"),
    [
        ("MIT", True),
        ("GPL-3.0-only", False),
        ("MIT AND GPL-3.0-only", False),
        ("MIT OR GPL-3.0-only", True),
        ("GPL-3.0-only OR MIT AND BSD-3-Clause", True),
        ("(GPL-3.0-only OR MIT) AND GPL-2.0-only", False),
        ("(GPL-3.0-only OR MIT) AND BSD-3-Clause", True),
        ("BSD-3-Clause AND Apache-2.0 WITH LLVM-exception", True),
        ("BSD-3-Clause AND Apache-2.0 WITH odd-exception", False),
        ("License :: OSI Approved :: BSD License", True),
        ("License :: Other", False),
        ("MIT MIT", False),
        ("MIT AND", False),
        ("(MIT", False),
        ("", False),
    ],
)
def test_an_expression_of_licences_is_met_or_not(expression: str, *, allowed: bool) -> None:
    assert tool("licences").allowed(expression, tool("licences").PERMISSIVE) is allowed


def test_a_package_without_a_licence_or_with_an_unknown_one_is_refused() -> None:
    licences = tool("licences")
    bill = {
        "components": [
            {"name": "good", "licenses": [{"license": {"id": "MIT"}}]},
            {"name": "both", "licenses": [{"license": {"id": "MIT"}}, {"license": {"name": "Own"}}]},
            {"name": "silent"},
            {"name": "casadi", "licenses": [{"license": {"name": "License :: OSI Approved"}}]},
            {"name": "mixed", "licenses": [{"expression": "MIT AND SSPL-1.0"}]},
        ]
    }
    refused = {"both": "MIT; Own", "mixed": "MIT AND SSPL-1.0", "silent": "none is stated"}
    assert licences.refused(bill, licences.PERMISSIVE) == {**refused, "casadi": "LGPL-3.0-or-later"}
    assert licences.refused(bill, licences.PERMISSIVE | licences.OF_EXTRAS) == refused


def test_sizes_are_those_of_the_files_of_each_distribution(tmp_path: Path) -> None:
    for name, size in (("large", 3_000_000), ("small", 10_000), ("pip", 5_000_000)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_bytes(b"#" * size)
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (info / "RECORD").write_text(f"{name}/__init__.py,,\n{name}/gone.py,,\n")
    footprint = tool("footprint")
    sizes = footprint.footprint(tmp_path)
    assert sizes == {"large": 3.0, "small": 0.01}
    assert footprint.table(sizes).splitlines() == [
        "    3.0 MB  100%  large",
        "    0.0 MB    0%  1 others",
        "    3.0 MB        in all",
    ]


def test_links_of_the_packages_page_lead_to_the_repository_or_nowhere() -> None:
    absolute = tool("readme_links").absolute
    text = "[a](docs/a.md#b) ![p](docs/p.png) [x](https://x.org/y) [t](#top) [m](mailto:a@b)"
    kept = "[x](https://x.org/y) [t](#top) [m](mailto:a@b)"
    told = f"[a](https://h/o/blob/v0.2.0/docs/a.md#b) ![p](https://h/o/raw/v0.2.0/docs/p.png) {kept}"
    assert absolute(text, "https://h/o", "0.2.0") == told
    assert "/blob/main/docs/a.md" in absolute(text, "https://h/o", "0.2.1.dev3+gabc")
    assert absolute(text, "", "0.2.0") == f"a  {kept}"


def test_no_relative_link_of_the_readme_is_left() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = tool("readme_links").absolute(text, "https://h/o", "0.2.0")
    assert len(re.findall(r"\]\((?!https?:|#)", text)) > 20
    assert not re.findall(r"\]\((?!https?:|#)", shown)
    files = re.findall(r"\(https://h/o/(?:blob|raw)/v0\.2\.0/([^)#]+)", shown)
    assert [path for path in files if not (ROOT / path).exists()] == []


@pytest.mark.parametrize(
    ("made", "changelog", "wrong"),
    [
        ("{cited}", "## {cited} - 2026-12-01\n", 0),
        ("{cited}", "## {cited} - not released yet\n", 1),
        ("{cited}", "## Unreleased\n\n## {cited} - 2026-12-01\n", 1),
        ("9.9.9", "## 9.9.9 - 2026-12-01\n", 1),
        ("9.9.9", "## Unreleased\n", 2),
        ("9.9.9.dev4+gabc", "## Unreleased\n", 0),
    ],
)
def test_a_release_has_one_version(release_check: ModuleType, made: str, changelog: str, wrong: int) -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    (cited,) = re.findall(r"^version: (\S+)$", text, re.MULTILINE)
    findings = list(release_check.versions(made.format(cited=cited), changelog.format(cited=cited)))
    assert len(findings) == wrong, findings


def test_the_changelog_and_the_citation_prepare_the_same_version() -> None:
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited is not None
    assert newest is not None
    assert newest[1] in (cited[1], "Unreleased")


def test_the_workflows_call_what_a_developer_calls() -> None:
    """No command of its own, which could differ from what was tried before; no secret."""
    called = {"sh .ci/run", "make docs", "make release-check"}
    for path in sorted((ROOT / ".github" / "workflows").glob("*.yml")):
        text = path.read_text(encoding="utf-8")
        commands = {line.strip() for line in re.findall(r"- run: (.+)", text)}
        assert {one for one in commands if "apt-get" not in one} <= called
        assert commands & called
        assert "secrets." not in text
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "\ndocs:" in makefile
    assert "\nrelease-check:" in makefile
