import sys

import pytest

from otolith import registry
from otolith.core.errors import InputError, MissingExtra


@pytest.mark.parametrize("table", [registry.CUEING, registry.PLANTS, registry.SOLVERS, registry.PERCEPTION])
def test_every_entry_loads_and_is_described(table: dict[str, registry.Entry]) -> None:
    for name, entry in table.items():
        assert callable(entry.load()), name
        assert entry.description


def test_a_missing_extra_is_one_sentence_with_the_command() -> None:
    entry = registry.Entry("no_such_simulator.api:Plant", "", extra="emulator", needs=("no_such_simulator",))
    with pytest.raises(MissingExtra, match=r"needs no_such_simulator.*pip install 'otolith\[emulator\]'"):
        entry.load()


@pytest.mark.parametrize("name", ["casadi-hpipm", "casadi-qpoases"])
def test_without_casadi_its_engines_say_how_to_install_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    monkeypatch.delitem(sys.modules, "otolith.qp.casadi", raising=False)
    with pytest.raises(MissingExtra, match=r"pip install 'otolith\[check\]'"):
        registry.SOLVERS[name].load()


def test_another_import_error_is_not_taken_for_a_missing_extra() -> None:
    with pytest.raises(ModuleNotFoundError):
        registry.Entry("otolith.not_there:Thing", "", extra="emulator", needs=("mujoco",)).load()


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(InputError, match="--plant is 'moon', must be one of ideal, ideal-no-lag"):
        registry.lookup(registry.PLANTS, "--plant", "moon")
