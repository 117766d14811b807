"""`import otolith`: few names, documented, found when asked for, and nothing imported before."""

import ast
import importlib
import inspect
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import otolith


def test_public_names_are_few_sorted_and_documented() -> None:
    assert list(otolith.__all__) == sorted(otolith.__all__)
    assert len(otolith.__all__) <= 40
    for name in otolith.__all__:
        assert inspect.getdoc(getattr(otolith, name)), f"otolith.{name} has no docstring"


def test_type_checkers_are_told_the_same_names_as_run_time_finds() -> None:
    tree = ast.parse(Path(otolith.__file__).read_text())
    (branch,) = [
        one for one in tree.body if isinstance(one, ast.If) and ast.unparse(one.test) == "TYPE_CHECKING"
    ]
    told = {
        alias.asname: f"{one.module.removeprefix('otolith.')}:{alias.name}"
        for one in branch.body
        if isinstance(one, ast.ImportFrom) and one.module is not None
        for alias in one.names
    }
    assert told == otolith._WHERE
    assert set(told) == set(otolith.__all__)


def test_no_name_is_that_of_a_module_which_would_take_its_place() -> None:
    package = Path(otolith.__file__).parent
    modules = {path.stem for path in package.glob("*.py")} | {
        path.name for path in package.iterdir() if path.is_dir()
    }
    assert not modules & set(otolith.__all__)


def test_nothing_is_imported_before_it_is_asked_for() -> None:
    program = (
        "import sys, otolith; heavy = ('otolith.', 'numpy', 'numba');"
        "early = {m for m in sys.modules if m.startswith(heavy)} - {'otolith.core', 'otolith.core.lazy'};"
        "assert not early, early; otolith.Status; assert 'otolith.interfaces' in sys.modules;"
        "assert 'numba' not in sys.modules and 'otolith.report' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_what_there_is_not_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="module 'otolith' has no attribute 'nonsense'"):
        otolith.nonsense  # type: ignore[attr-defined]  # noqa: B018
    assert set(dir(otolith)) == {*otolith.__all__, "__version__"}


def test_the_examples_and_the_washout_need_nothing_else() -> None:
    root = Path(__file__).parents[1]
    sources = [
        *(root / "examples").glob("0[12]*.py"),
        Path(otolith.__file__).parent / "cli/samples/washout.py",
    ]
    for source in sources:
        for node in ast.walk(ast.parse(source.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert node.module is not None
                assert not node.module.startswith("otolith."), f"{source.name} imports {node.module}"


def test_every_package_has_the_names_that_it_promises() -> None:
    """A name left in `__all__` after its object went is found by `from … import *` alone."""
    promised = 0
    for one in pkgutil.walk_packages(otolith.__path__, "otolith."):
        if one.ispkg and not one.name.endswith(".samples"):
            package = importlib.import_module(one.name)
            names = getattr(package, "__all__", ())
            promised += len(names)
            assert [name for name in names if not hasattr(package, name)] == [], one.name
    assert promised > 50
