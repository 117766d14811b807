"""The number by which a build knows whether machine code belongs to the source."""

import shutil
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

ROOT = Path(__file__).parents[1]


def digest(folder: Path) -> str:
    spec = spec_from_file_location("source_digest", ROOT / "tools" / "source_digest.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    found: str = module.source_digest(folder)
    return found


def test_a_digest_knows_every_edit_and_every_name(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    (one / "inner").mkdir(parents=True)
    (one / "a.py").write_text("x = 1\n")
    (one / "inner" / "b.py").write_text("y = 2\n")
    shutil.copytree(one, other)
    (other / "notes.txt").write_text("no source\n")
    assert digest(one) == digest(other)
    (other / "inner" / "b.py").write_text("y = 3\n")
    assert digest(one) != digest(other)
    shutil.copytree(one, other, dirs_exist_ok=True)
    (other / "a.py").rename(other / "c.py")
    assert digest(one) != digest(other)
