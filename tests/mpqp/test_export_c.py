"""The exported C gives the same answers as the law."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from otolith.mpqp import InvalidProblem, Law, enumerate_regions
from otolith.mpqp.export_c import export_c
from tests.mpqp.models import random_problem

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
needs_compiler = pytest.mark.skipif(
    COMPILER is None, reason="no C compiler (cc, gcc or clang) on this machine"
)


def compiled(law: Law, folder: Path, outputs: int | None = None) -> ctypes.CDLL:
    text = export_c(law, "law", outputs=outputs)
    (folder / "law.h").write_text(text.header)
    (folder / "law.c").write_text(text.source)
    command = [str(COMPILER), "-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*command, "-o", str(folder / "law.so"), str(folder / "law.c")], check=True)
    library = ctypes.CDLL(str(folder / "law.so"))
    pointer = ctypes.POINTER(ctypes.c_double)
    library.law_evaluate.argtypes = [pointer, ctypes.c_int, pointer]
    return library


def ask(library: ctypes.CDLL, theta: np.ndarray, start: int, outputs: int) -> tuple[int, np.ndarray]:
    z, pointer = np.full(outputs, np.nan), ctypes.POINTER(ctypes.c_double)
    theta = np.ascontiguousarray(theta)
    region = library.law_evaluate(theta.ctypes.data_as(pointer), start, z.ctypes.data_as(pointer))
    return region, z


@needs_compiler
def test_c_equals_python_on_the_blocked_law(blocked: Law, tmp_path: Path) -> None:
    library, problem = compiled(blocked, tmp_path, outputs=2), blocked.problem
    thetas = np.random.default_rng(3).uniform(problem.lower, problem.upper, (2000, 5))
    answers, start = blocked.evaluate_many(thetas), -1
    for theta, z, region in zip(thetas, answers.z, answers.region, strict=True):
        found, first = ask(library, theta, start, 2)
        assert found == max(region, -1)
        np.testing.assert_allclose(first, z[:2], atol=1e-9)
        start = found


@needs_compiler
def test_c_equals_python_with_offset_box_and_linear_cost(tmp_path: Path) -> None:
    law = enumerate_regions(random_problem(11, 3, 6, 2))
    library = compiled(law, tmp_path)
    thetas = np.random.default_rng(0).uniform(1.2 * law.problem.lower, 1.2 * law.problem.upper, (500, 2))
    for theta, z in zip(thetas, law.evaluate_many(thetas).z, strict=True):
        np.testing.assert_allclose(ask(library, theta, -1, 3)[1], z, atol=1e-9)


def test_a_name_that_c_cannot_take_is_refused(line: Law) -> None:
    with pytest.raises(InvalidProblem, match="C identifier"):
        export_c(line, "my law")


def test_outputs_out_of_range_are_refused(line: Law) -> None:
    with pytest.raises(InvalidProblem, match="between 1 and 1"):
        export_c(line, "law", outputs=2)
