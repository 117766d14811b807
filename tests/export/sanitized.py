"""Run a program under the sanitizers for addresses, undefined behaviour and casts."""

import subprocess
from pathlib import Path
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat
from otolith.export.program import Program
from tests.export.in_c import COMPILER, STRICT

SANITIZERS: Final = (
    *("-O1", "-g", "-ffp-contract=off", "-fno-sanitize-recover=all"),
    "-fsanitize=address,undefined,float-cast-overflow",
)
_MAIN: Final = """
#define {NAME}_IMPLEMENTATION
#include "{name}.h"
#include <stdio.h>
static {name} it, snapshot;
/* Step through the inputs; at `again` go back to a snapshot, once, and go on as before. */
int main(int count, char *arguments[]) {{
    double in[{NAME}_INPUTS], out[1 + {NAME}_OUTPUTS];
    const long keep = atol(arguments[3]), again = atol(arguments[4]);
    FILE *given = fopen(arguments[1], "rb"), *answers = fopen(arguments[2], "wb");
    int back = 0;
    (void)count;
    {name}_init(&it);
    for (long k = 0; fread(in, sizeof in, 1, given) == 1; k++) {{
        if (k == keep) snapshot = it;
        out[0] = {name}_step(&it, in, out + 1);
        fwrite(out, sizeof out, 1, answers);
        if (k == again && !back) {{
            back = 1;
            k = keep - 1;
            fseek(given, keep * (long)sizeof in, SEEK_SET);
            memcpy(&it, &snapshot, sizeof it);
        }}
    }}
    return fclose(answers);
}}
"""


class Sanitized:
    """A program, compiled with sanitizers, that ends with an error where they find one."""

    def __init__(self, program: Program, folder: Path, *flags: str) -> None:
        self.program, self._folder, name = program, folder, program.name
        (folder / f"{name}.h").write_text(program.header)
        main = _MAIN.format(name=name, NAME=name.upper())
        (folder / "main.c").write_text(f"#include <stdlib.h>\n#include <string.h>\n{main}")
        line = [str(COMPILER), *STRICT, *SANITIZERS, *flags, str(folder / "main.c"), "-lm", "-o"]
        done = subprocess.run([*line, str(folder / "main")], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:4000]

    def run(self, inputs: Mat, *, keep: int = -1, again: int = -1) -> tuple[Ints, Mat]:
        """Return the statuses and the outputs of all steps, each from inputs (n, inputs).

        After step `again` the memory of the program becomes what it was before step `keep`, and it goes on
        from there.
        """
        given, answers = self._folder / "inputs", self._folder / "answers"
        given.write_bytes(np.ascontiguousarray(inputs, dtype=np.float64).tobytes())
        line = [str(self._folder / "main"), str(given), str(answers), str(keep), str(again)]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:4000]
        found = np.frombuffer(answers.read_bytes()).reshape(-1, 1 + len(self.program.outputs))
        return found[:, 0].astype(np.int64), found[:, 1:]


HOSTILE: Final = (
    *(np.nan, np.inf, -np.inf, 1e300, -1e300, 1.7e308, 1e-310, -5e-324, 0.0, -0.0),
    *(1e6, 1.0000001e6, -1e9, 3e9, 1.0, -3.0),
)


def hostile(inputs: Mat, seed: int, share: float = 0.1) -> Mat:
    """Return inputs of which a share of the rows holds hostile numbers in some or in all places."""
    random = np.random.default_rng(seed)
    found = np.array(inputs)
    for row in np.flatnonzero(random.random(len(found)) < share):
        places = random.random(found.shape[1]) < random.choice([0.05, 0.3, 1.0])
        found[row, places] = random.choice(HOSTILE, np.count_nonzero(places))
    return found
