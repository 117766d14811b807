"""The folder of a program in C: its header, a CMake project, test vectors and a program that replays them."""

from pathlib import Path
from string import Template
from typing import Final

from otolith.core.disk import write_text
from otolith.export.program import Program
from otolith.export.vectors import Vectors

_SOURCE: Final = Template("""\
/* The one file that holds the functions of $name. */
#define ${NAME}_IMPLEMENTATION
#include "$name.h"
""")

_CMAKE: Final = Template("""\
cmake_minimum_required(VERSION 3.10)
project($name C)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_STANDARD_REQUIRED ON)

add_library($name STATIC $name.c)
target_include_directories($name PUBLIC $${CMAKE_CURRENT_SOURCE_DIR})
if(UNIX)
  target_link_libraries($name PUBLIC m)
endif()$strict

enable_testing()
add_executable(${name}_test ${name}_test.c)
target_link_libraries(${name}_test PRIVATE $name)
add_test(NAME vectors COMMAND ${name}_test $${CMAKE_CURRENT_SOURCE_DIR}/vectors.txt)
""")

_STRICT: Final = """
if(NOT MSVC) # what judges is as exact as in Python: no sum is fused
  target_compile_options({name} PRIVATE -ffp-contract=off)
endif()"""

_TEST: Final = Template("""\
/* Replay vectors.txt: each line holds the inputs of a step and the outputs that Otolith computed in Python.
   The status must be equal, numbers within TOLERANCE; how hard the solver worked may differ. */
#include <math.h>
#include <stdio.h>

#include "$name.h"

#define TOLERANCE 1e-7
#define COMPARED (${NAME}_OUTPUTS - $effort)

static $name program;

int main(int count, char *arguments[]) {
    FILE *file = fopen(count > 1 ? arguments[1] : "vectors.txt", "r");
    double in[${NAME}_INPUTS], expected[${NAME}_OUTPUTS], out[${NAME}_OUTPUTS], worst = 0.0;
    int steps = 0, wrong = 0;
    if (!file) {
        fprintf(stderr, "vectors.txt cannot be read\\n");
        return 2;
    }
    ${name}_init(&program);
    for (;;) {
        int read = 0;
        for (int i = 0; i < ${NAME}_INPUTS; i++) read += fscanf(file, "%lf", &in[i]) == 1;
        for (int i = 0; i < ${NAME}_OUTPUTS; i++) read += fscanf(file, "%lf", &expected[i]) == 1;
        if (read < ${NAME}_INPUTS + ${NAME}_OUTPUTS) break;
        ${name}_step(&program, in, out);
        steps++;
        for (int i = 0; i < COMPARED; i++) {
            const double off = fabs(out[i] - expected[i]);
            if (!(off <= TOLERANCE)) wrong++;
            if (off > worst) worst = off;
        }
    }
    fclose(file);
    printf("%d steps, largest difference %.1e, %d numbers beyond %.0e\\n", steps, worst, wrong, TOLERANCE);
    return steps == 0 || wrong > 0;
}
""")

FILES: Final = ("CMakeLists.txt", "vectors.txt")  # besides NAME.h, NAME.c and NAME_test.c


def write_project(program: Program, checks: Vectors, folder: Path, *, strict: bool = False) -> None:
    """Write all files of a program into a folder.

    Parameters
    ----------
    strict : whether no compiler may fuse its sums, since it judges.

    Raises
    ------
    NotWritten : a file cannot be written.
    """
    words = {"name": program.name, "NAME": program.name.upper(), "effort": checks.free}
    words["strict"] = _STRICT.format(name=program.name) if strict else ""
    name = program.name
    write_text(folder / f"{name}.h", program.header)
    write_text(folder / f"{name}.c", _SOURCE.substitute(words))
    write_text(folder / f"{name}_test.c", _TEST.substitute(words))
    write_text(folder / "CMakeLists.txt", _CMAKE.substitute(words))
    lines = (
        " ".join(f"{x:.17g}" for x in (*inputs, *outputs))
        for inputs, outputs in zip(checks.inputs.tolist(), checks.outputs.tolist(), strict=True)
    )
    write_text(folder / "vectors.txt", "\n".join(lines) + "\n")
