#!/bin/sh
# numba 0.68.1: in a first compilation, `out[:] = values` costs thirty times what a loop that does the same costs.
#
# A copy from array to slice is checked for its shape, and the text of the error, "cannot assign slice of shape …", is put
# together in compiled code. So with a single such line numba also compiles its own str() of integers, its repr(), and the
# joining of strings: more than thirty functions beside the one that was asked for, which is one or two seconds of
# processor time, once in each process that compiles. A tuple on the right side does it, too; a number does not. The loop
# is as fast when it runs. A program whose start is waited for copies element by element.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet "numba==0.68.1" "numpy==2.4.6"
cat > "$folder/measure.py" <<'PYTHON'
import sys
import time

import numba
import numpy as np
from numba.core import event

compiled = []


class Listener(event.Listener):
    def on_start(self, happened):
        function = happened.data["dispatcher"].py_func
        compiled.append(f"{function.__module__}.{function.__qualname__}")

    def on_end(self, happened):
        pass


@numba.njit
def first(out):  # what numba does once in a process is not counted
    out[0] = 1.0


@numba.njit
def by_slice(values, out):
    out[:] = values


@numba.njit
def of_number(values, out):
    out[:] = values[0]


@numba.njit
def of_tuple(values, out):
    out[:] = values[0], values[1], values[2]


@numba.njit
def by_loop(values, out):
    for i in range(len(out)):
        out[i] = values[i]


values, out = np.array([1.0, 2.0, 3.0]), np.zeros(3)
first(out)
event.register("numba:compile", Listener())
began = time.process_time()
globals()[sys.argv[1]](values, out)
took = time.process_time() - began
texts = sum("unicode" in name or "ol_str" in name or "ol_repr" in name for name in compiled)
print(sys.argv[1], len(compiled), texts, f"{took:.2f}")
PYTHON
cd "$folder"
for form in by_loop of_number by_slice of_tuple; do
    NUMBA_CACHE_DIR="$folder/cache" "$folder/venv/bin/python" measure.py "$form"
done > found.txt
echo "form, functions compiled, of which for texts, CPU seconds:"
cat found.txt
"$folder/venv/bin/python" - <<'PYTHON'
import sys

found = {name: (int(number), int(texts)) for name, number, texts, _ in map(str.split, open("found.txt"))}
holds = (
    found["by_loop"] == (1, 0)
    and found["of_number"][1] == 0
    and all(found[name][0] > 30 and found[name][1] > 5 for name in ("by_slice", "of_tuple"))
)
print("holds" if holds else "no longer so")
sys.exit(not holds)
PYTHON
