"""Copies inside kernels."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from otolith.core import jit
from otolith.core.copying import copy_to

ROOT = Path(__file__).parents[2]
DECORATORS = {name for name in vars(jit) if name.startswith("jit_")} | {"kernel"}


@jit.kernel
def copied(out: NDArray[Any], values: NDArray[Any]) -> None:
    copy_to(out, values)  # which has no wrapper for Python


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_as_many_numbers_are_copied_as_there_is_room_for(kind: type) -> None:
    out: NDArray[Any] = np.zeros(2, kind)
    copied(out, np.arange(1, 4).astype(kind))
    assert out.tolist() == [1, 2]


def kernels_with_slices(tree: ast.Module) -> Iterator[str]:
    """Names of kernels in which a slice is set to what is not plainly a number."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        if not {getattr(one, "id", "") for one in function.decorator_list} & DECORATORS:
            continue
        for node in ast.walk(function):
            if not isinstance(node, ast.Assign) or isinstance(node.value, ast.Constant):
                continue
            targets = [one for one in node.targets if isinstance(one, ast.Subscript)]
            if any(isinstance(part, ast.Slice) for one in targets for part in ast.walk(one.slice)):
                yield function.name


def test_no_kernel_copies_by_a_slice() -> None:
    """A first run would compile the text of an error message."""
    by_a_number = {
        "src/otolith/cueing/mpc/kernels.py: weigh_washout",  # w₁ + w₂ r + …
        "src/otolith/cueing/prediction/adaptive.py: _adapt",  # one force
        "src/otolith/cueing/washout/adaptive.py: step",  # neutral gains
    }
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / "src").rglob("*.py")
        for name in kernels_with_slices(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert found == by_a_number
