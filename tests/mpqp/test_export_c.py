"""The exported C gives the same answers as the law."""

import ctypes
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from otolith.mpqp import InvalidProblem, Law, enumerate_regions
from otolith.mpqp.certify import _facet_point
from otolith.mpqp.export_c import WALK, export_c
from otolith.mpqp.oracle import Oracle
from tests.mpqp.models import random_problem

NONE, UNSOLVED = -1, -2

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


@pytest.fixture(scope="module")
def first_input(blocked: Law, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The blocked law in C, its first two variables only."""
    return compiled(blocked, tmp_path_factory.mktemp("c"), outputs=2)


def hostile(law: Law, count: int) -> np.ndarray:
    """Parameters on and beside facets, in corners, on and just outside the edges of the box."""
    rng, p = np.random.default_rng(5), len(law.form.half)
    facets = []
    for region in rng.integers(len(law), size=count):
        tau, row, _ = _facet_point(law, int(region), rng)
        facets += [tau + step * row for step in (0.0, 1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6)]
    corners = np.sign(rng.uniform(-1, 1, (count, p)))
    edges = rng.uniform(-1, 1, (count, p))
    edges[np.arange(count), rng.integers(p, size=count)] = rng.choice((1.0, 1 + 5e-9, -1 - 5e-9), count)
    taus = np.vstack([facets, corners, edges, [np.zeros(p)], law.centre[: law.alone]])
    rng.shuffle(taus)
    thetas: np.ndarray = law.form.centre + law.form.half * taus
    return thetas


@needs_compiler
def test_hostile_parameters_are_answered_as_an_independent_qp_does(
    blocked: Law, first_input: ctypes.CDLL
) -> None:
    """Whatever the walk starts from; where feasibility hangs on rounding, either verdict stands."""
    oracle, rng, answers = Oracle(blocked.problem), np.random.default_rng(1), 0
    for theta in hostile(blocked, 150):
        truth, margin = oracle.solve(theta), oracle.margin(theta)
        for start in (NONE, int(rng.integers(len(blocked))), len(blocked)):
            region, z = ask(first_input, theta, start, 2)
            if region == NONE:
                assert margin < 1e-8 or np.abs(blocked.form.scaled(theta)).max() > 1 + 1e-8
                assert np.isnan(z).all()
            else:
                assert margin > -1e-8
                assert 0 <= region <= len(blocked)
                if np.isfinite(truth).all():
                    np.testing.assert_allclose(z, truth[:2], rtol=0.0, atol=1e-8)
                    answers += 1
    assert answers > 2000


@needs_compiler
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300, 20.0 * (1 + 1e-7)])
def test_parameters_outside_the_box_have_no_answer(first_input: ctypes.CDLL, bad: float) -> None:
    for start in (-(2**31), NONE, 0, 952, 953, 2**31 - 1):
        region, z = ask(first_input, np.array([0.0, 0.0, 0.0, 0.0, bad]), start, 2)
        assert region == NONE
        assert np.isnan(z).all()


@needs_compiler
def test_a_law_with_holes_and_without_links_is_still_right(blocked: Law, tmp_path: Path) -> None:
    """No link leads anywhere, and thin regions are missing: the QP answers, and its set is looked up."""
    coarse = enumerate_regions(blocked.problem, tolerance=1e-2)
    assert len(coarse) < len(blocked)
    unlinked = replace(coarse, beyond=np.full_like(coarse.beyond, -3))
    library, p = compiled(unlinked, tmp_path, outputs=2), blocked.problem
    thetas = np.random.default_rng(3).uniform(p.lower, p.upper, (2000, 5))
    fine, sparse = blocked.evaluate_many(thetas), coarse.evaluate_many(thetas)
    holes, start = 0, 0
    for theta, z, region in zip(thetas, fine.z, sparse.region, strict=True):
        found, first = ask(library, theta, start, 2)
        assert found == {-1: len(coarse), -2: NONE}.get(int(region), region)
        np.testing.assert_allclose(first, z[:2], atol=1e-9)
        holes += found == len(coarse)
        start = max(found, 0)
    assert holes > 0


@needs_compiler
def test_work_is_bounded_and_the_bound_is_stated(
    blocked: Law, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A QP that may not change its active set has no answer, and says so; a longer one is as stated."""
    stated = re.search(r"looks at (\d+) regions with at most\s+(\d+) facets", export_c(blocked, "law").header)
    assert stated is not None
    assert [int(word) for word in stated.groups()] == [WALK, np.diff(blocked.start).max()]
    monkeypatch.setattr("otolith.mpqp.export_c.CHANGES", 1)
    library = compiled(blocked, tmp_path, outputs=2)
    theta = blocked.form.centre + blocked.form.half * blocked.ball(len(blocked) - 1)[0]
    assert len(blocked.active(blocked.evaluate(theta).region)) > 1
    region, z = ask(library, theta, NONE, 2)
    assert region == UNSOLVED
    assert np.isnan(z).all()


def test_a_name_that_c_cannot_take_is_refused(line: Law) -> None:
    with pytest.raises(InvalidProblem, match="C identifier"):
        export_c(line, "my law")


def test_outputs_out_of_range_are_refused(line: Law) -> None:
    with pytest.raises(InvalidProblem, match="between 1 and 1"):
        export_c(line, "law", outputs=2)
