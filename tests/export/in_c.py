"""Compile a program with the C compiler of this machine, and step it."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from otolith.core.arrays import Ints, Mat
from otolith.export.program import Program

COMPILER: Final = shutil.which("cc") or shutil.which("gcc")
STRICT: Final = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler (cc) on this machine")

SHELL: Final = """
#define {NAME}_IMPLEMENTATION
#include "{name}.h"
unsigned long size_of_it(void) {{ return sizeof({name}); }}
"""


class Stepper:
    """One instance of a program, in a library of its own."""

    def __init__(self, program: Program, folder: Path, *flags: str) -> None:
        self.program, name = program, program.name
        (folder / f"{name}.h").write_text(program.header)
        (folder / f"{name}.c").write_text(SHELL.format(name=name, NAME=name.upper()))
        library = folder / f"{name}.so"
        line = [
            str(COMPILER),
            *STRICT,
            *flags,
            "-shared",
            "-fPIC",
            f"{folder / name}.c",
            "-o",
            str(library),
            "-lm",
        ]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:4000]
        self._library = ctypes.CDLL(str(library))
        self._library.size_of_it.restype = ctypes.c_ulong
        self.size = int(self._library.size_of_it())
        self._me = ctypes.create_string_buffer(self.size)
        self.begin()

    def begin(self) -> None:
        """Start at rest."""
        getattr(self._library, f"{self.program.name}_init")(self._me)

    def step(self, inputs: Sequence[float] | Mat) -> tuple[int, Mat]:
        """Do one period; return the status and the outputs."""
        given = np.ascontiguousarray(inputs, dtype=np.float64)
        assert given.shape == (len(self.program.inputs),)
        out = np.zeros(len(self.program.outputs))
        of = getattr(self._library, f"{self.program.name}_step")
        status = of(self._me, ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(out.ctypes.data))
        return int(status), out

    def run(self, inputs: Mat) -> tuple[Ints, Mat]:
        """Do one period per row; return all statuses and outputs."""
        steps = [self.step(row) for row in inputs]
        return np.array([status for status, _ in steps]), np.array([out for _, out in steps])
