"""Without the extra, a study is refused with the command that installs it."""

import importlib
import sys

import pytest

from otolith.core.errors import MissingExtra


@pytest.mark.parametrize(("module", "needs"), [("engine", "optuna"), ("cluster", "distributed")])
def test_a_missing_extra_is_one_sentence(module: str, needs: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, needs, None)
    monkeypatch.delitem(sys.modules, f"otolith.studies.{module}", raising=False)
    with pytest.raises(
        MissingExtra, match=rf"needs {needs}, which is not installed: pip install 'otolith\[study\]'"
    ):
        importlib.import_module(f"otolith.studies.{module}")
