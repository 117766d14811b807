"""Packages whose names are imported on first use."""

import pkgutil
import subprocess
import sys
from importlib import import_module

import pytest

PACKAGES = (
    "otolith",
    "otolith.mpqp",
    "otolith.platforms",
    "otolith.recordings",
    "otolith.report",
    "otolith.vehicle",
)


@pytest.mark.parametrize("name", PACKAGES)
def test_every_name_is_found_and_none_is_hidden_by_a_module(name: str) -> None:
    package = import_module(name)
    modules = {one.name for one in pkgutil.iter_modules(package.__path__)}
    for public in package.__all__:
        assert hasattr(package, public)
        assert public not in modules or public in vars(package)


@pytest.mark.parametrize("name", PACKAGES)
def test_an_unknown_name_is_an_attribute_error(name: str) -> None:
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute 'nonesuch'"):
        _ = import_module(name).nonesuch


def test_a_name_is_imported_when_it_is_used() -> None:
    script = (
        "import sys, otolith.vehicle as v\n"
        "assert 'otolith.vehicle.car' not in sys.modules\n"
        "v.load_car\n"
        "assert 'otolith.vehicle.car' in sys.modules and 'load_car' in vars(v)\n"
        "import otolith.vehicle.road\n"
        "assert callable(v.road), 'the function, which a module of the same name must not hide'\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
