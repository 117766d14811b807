"""What a program may be called."""

import re
import subprocess
from pathlib import Path

import pytest

from otolith.core.errors import InputError
from otolith.export.program import Program, check_name
from tests.export.in_c import COMPILER, needs_compiler

HEADERS = ("math", "string", "stdio", "stdlib")
TAKEN = """main program linux math Math FILE EOF sinf y0 size_t M_PI and asm nullptr test all con printf
signbit NULL""".split()  # noqa: SIM905
FREE = "cueing_2 out in me i status double_ read washout f l t sf rotor leaf wheel".split()  # noqa: SIM905


@pytest.mark.parametrize("name", ["", "2nd", "motion-cueing", "int", "this", "größe", "a b", "x" * 41, "_x"])
def test_a_name_that_c_does_not_take_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="name of the program"):
        Program(name=name, period=0.01, inputs=(), outputs=(), header="")


@pytest.mark.parametrize("name", TAKEN)
def test_a_name_that_means_something_else_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="one that has no meaning yet"):
        check_name(name)


@pytest.mark.parametrize("name", FREE)
def test_any_other_name_of_c_is_taken(name: str) -> None:
    assert Program(name=name, period=0.01, inputs=(), outputs=(), header="").name == name


@needs_compiler
def test_functions_of_the_headers_that_a_program_meets_are_no_names(tmp_path: Path) -> None:
    """The C compiler lists the functions of its own headers; those of threads and locales are left out."""
    source, listed = tmp_path / "all.c", tmp_path / "all.txt"
    source.write_text("".join(f"#include <{one}.h>\n" for one in HEADERS))
    made = [str(COMPILER), "-std=gnu99", "-fsyntax-only", "-aux-info", str(listed), str(source)]
    if subprocess.run(made, check=False, capture_output=True).returncode != 0:
        pytest.skip(f"{COMPILER} cannot list functions, as GCC can")
    declared = set(re.findall(r"\b([A-Za-z]\w*) \(", listed.read_text()))
    assert {"sin", "memset", "fopen", "malloc"} <= declared
    usual = {one for one in declared if not re.search(r"_|48$|^q?[efg]cvt$|lockfile$", one)}
    free = []
    for name in sorted(usual):
        try:
            check_name(name)
        except InputError:
            continue
        free.append(name)
    assert free == []
