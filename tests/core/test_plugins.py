"""What comes from outside is found lazily, and whatever is wrong with it is one sentence that says whose."""

import sys
from pathlib import Path

import pytest

from otolith.core import plugins
from otolith.core.errors import InputError, OtolithError


def distribution(site: Path, name: str, entry_points: str, source: str = "") -> None:
    """Install a distribution of one module into a folder of packages, as pip leaves it there."""
    info = site / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(entry_points)
    (site / f"{name}.py").write_text(source)


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder on the path for packages that stay installed as long as the test."""
    monkeypatch.syspath_prepend(tmp_path)
    plugins._search.cache_clear()
    monkeypatch.setattr(plugins, "_search", plugins._search.__wrapped__)
    return tmp_path


def test_a_group_is_what_installed_packages_declare(site: Path) -> None:
    distribution(site, "mine", "[otolith.things]\nchair = mine:Chair\n", "class Chair: pass\n")
    found = plugins.declared("otolith.things")
    assert list(found) == ["chair"]
    assert "mine" not in sys.modules  # nothing of it was imported to find it
    assert plugins.distribution(found["chair"]) == "mine 1.0"
    assert plugins.load_entry_point(found["chair"]).__name__ == "Chair"
    del sys.modules["mine"]


def test_a_name_that_two_declare_is_refused(site: Path) -> None:
    for name in ("one_of_two", "two_of_two"):
        distribution(site, name, f"[otolith.things]\nchair = {name}:Chair\n")
    with pytest.raises(OtolithError, match=r"'chair' of otolith.things is declared by .* 1.0 and by .* 1.0"):
        plugins.load_entry_point(plugins.declared("otolith.things")["chair"])
    assert list(plugins.doubtful("otolith.things")) == ["chair"]


def test_a_broken_package_is_named(site: Path) -> None:
    distribution(site, "cracked", "[otolith.things]\nchair = cracked:Chair\n", "x = 1 / 0\n")
    with pytest.raises(plugins.BrokenPlugin, match=r"'chair' of cracked 1.0 could not be imported: ZeroDiv"):
        plugins.load_entry_point(plugins.declared("otolith.things")["chair"])


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("Thing", "must be MODULE:ATTRIBUTE"),
        (":Thing", "must be MODULE:ATTRIBUTE"),
        ("json:", "must be MODULE:ATTRIBUTE"),
        ("json:dumps()", "must be MODULE:ATTRIBUTE"),
        ("no_such_module:Thing", "of a module 'no_such_module' that is not installed"),
        ("json.nothing:Thing", "of a module 'json.nothing' that is not installed"),
        ("json:Thing", "an attribute of json"),
        ("absent.py:Thing", "a file 'absent.py' that does not exist"),
    ],
)
def test_a_target_that_is_not_there_is_refused(target: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        plugins.load_target("--cueing", target)
    assert sentence in str(refused.value)


def test_a_file_is_run_once_and_its_mistakes_are_told_with_their_line(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.py", tmp_path / "bad.py"
    good.write_text("from dataclasses import dataclass\n@dataclass\nclass Thing:\n    x: int = 3\n")
    made = plugins.load_target("--cueing", f"{good}:Thing")
    assert made().x == 3
    assert plugins.load_target("--cueing", f"{good}:Thing") is made
    with pytest.raises(InputError, match="such as Thing"):
        plugins.load_target("--cueing", f"{good}:Thin")
    bad.write_text("a = 1\nimport no_such_module\n")
    with pytest.raises(plugins.BrokenPlugin, match=r"No module named 'no_such_module' \(line 2 of bad.py\)"):
        plugins.load_target("--cueing", f"{bad}:Thing")
    bad.write_text("def broken(:\n")
    with pytest.raises(plugins.BrokenPlugin, match="SyntaxError"):
        plugins.load_target("--cueing", f"{bad}:Thing")
