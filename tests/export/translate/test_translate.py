"""Small kernels, in C and in Python, with arguments that tell the two apart if they can be."""

import ctypes
import math
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import kernel
from otolith.core.methods import INTEGER, VECTOR, Method, Role
from otolith.export.header import header
from otolith.export.program import Port, Program
from otolith.export.translate.render import Rendered
from otolith.export.translate.unit import translated
from otolith.export.translate.values import NotTranslated
from tests.export.in_c import COMPILER, STRICT, Stepper, needs_compiler

ROLE = Role(INTEGER, (VECTOR,))
_call = ROLE.call


class Data(NamedTuple):
    """What the kernels below read and write."""

    given: Vec  # (8,)
    out: Vec  # (12,)
    table: Mat  # (2, 3)
    sizes: Ints  # (2,)
    at: Ints  # (2,)
    on: bool = True


def _data(on: bool = True) -> Data:
    given = np.array([0.3, -1.7, 2.5, -0.0, 4.0, 1e-3, 7.0, -3.5])
    table = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    return Data(given, np.zeros(12), table, np.array([1, 3]), np.array([0, 5]), on)


def _in_c(function: Any, values: Any, folder: Path) -> tuple[int, Vec]:
    """Run a kernel in C; return its result, and `out`."""
    unit, entry = translated(function.py_func, values)
    rendered = Rendered(unit, entry, "tried", [values.out])
    struct, implementation = rendered.struct(), rendered.implementation()
    initial = "\n".join(rendered.initial())
    text = f"""
#include <math.h>
#include <string.h>
typedef struct tried tried;
{struct}
{implementation}
int run(double *out) {{
    static tried it;
    tried *const me = &it;
    memset(me, 0, sizeof *me);
{initial}
    const int result = tried_{entry.name}({"me" if entry in rendered._using else ""});
    memcpy(out, {rendered.of(values.out)}, sizeof(double) * {values.out.size});
    return result;
}}
"""
    (folder / "tried.c").write_text(text)
    line = [str(COMPILER), *STRICT, "-O1", "-ffp-contract=off", "-shared", "-fPIC", str(folder / "tried.c")]
    done = subprocess.run([*line, "-o", str(folder / "tried.so"), "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    out = np.zeros(values.out.size)
    result = ctypes.CDLL(str(folder / "tried.so")).run(ctypes.c_void_p(out.ctypes.data))
    return result, out


@kernel
def _pair(x: float, n: int) -> tuple[float, int]:
    return x * n, n + 1


@kernel
def _arithmetic(of: Any) -> int:
    g, out = of.given, of.out
    out[0] = min(g[0], math.nan)  # Python's min: the first, unless another is smaller
    out[1] = max(math.nan, g[0])
    out[2] = -(g[1] - (g[2] - g[4])) / (g[4] / g[2]) * 2.0 - g[0] ** 3
    out[3] = math.copysign(1.0, g[3])
    k = of.at[1] - 9  # −4
    out[4], out[5] = k // 3, k % 3  # floored, as Python does
    out[6], out[7] = g[0], g[1]
    out[6], out[7] = out[7], out[6]  # both are computed before either is stored
    y, n = _pair(g[2], 4)
    out[8], out[9] = y, n
    out[10] = int(g[7]) + abs(k) + float(len(g))
    a, b = 1.0, 2.0
    a, b = b, a
    out[11] = a - b if g[0] < g[2] <= g[4] and not g[4] <= 0.0 else 0.0
    of.at[1] += 1
    return k


@kernel
def _part(of: Any, row: int) -> float:
    n = of.sizes[row]
    part = np.zeros(n)  # so there is a function for each row, and the loop over rows is written out
    part[:] = of.table[row, :n] - 2.0 * of.table[0, :n]
    largest: float = np.max(np.abs(part))
    return largest


@kernel
def _loops(of: Any) -> int:
    total, seen = 0, 0
    for i in range(8):
        if of.given[i] < 0.0:
            continue
        if i == 7:
            break
        total += i
    n = 0
    while True:
        n += 1
        if n >= 5:
            break
    for row in range(2):
        for size in of.sizes:
            seen += size
            of.out[row] += of.table[row, size - 1]
        of.out[2 + row] = _part(of, row)
    for k in range(6, 2, -2):
        of.out[k] = k
    return 1000 * total + 10 * n + seen


class Pair(NamedTuple):
    """Two arrays that a kernel makes, handed over as one argument."""

    first: Vec  # (2,)
    second: Vec  # (2,)


@kernel
def _weigh(pair: Any, of: tuple[float, float], sign: int) -> float:
    pair.second[0] += 1.0
    x, y = of
    return sign * (pair.first[0] * x + pair.second[0] * y)


@kernel
def _halve(values: Vec) -> None:
    values *= 0.5  # in place: the caller sees it


@kernel
def _handed(of: Any) -> int:
    g, out = of.given, of.out
    one, other = Pair(g[:2].copy(), g[2:4].copy()), Pair(g[4:6].copy(), g[6:].copy())
    out[0], out[1] = _weigh(one, (g[1], 2.0), 1), _weigh(other, (g[2], -1.0), -1)
    out[2], out[3] = one.second[0], other.second[0]
    halved = g[:3].copy()
    _halve(halved)
    halved -= 1.0
    out[4], out[5] = halved[0], g[0]
    x = g[0]
    before = (x + 1.0, 2.0 * x)
    for k in range(2):
        x += k
        if x > 0.5:
            late = x  # assigned in a block first, and later outside it
            out[6] = late
        late = 3.0 * x
        out[7] = late
    out[8], out[9] = before[0], before[1]
    out[10] = _pair(g[2], 4)[0]
    nearest = 0
    for x in (0.5, 1.5, 2.5, -0.5, -1.5, -2.6, 0.49999999999999994, 1e6 + 0.25):
        nearest = 3 * nearest + round(x * of.at[1] / 5)
    return nearest


@kernel
def _branches(of: Any) -> int:
    if of.on:
        return int(of.given[2] * 10.0)
    return _not_there(of)  # type: ignore[name-defined]  # noqa: F821


@kernel
def _add(of: Any, x: Vec) -> int:
    for i in range(2):
        of.out[i] += x[i]
    return 7


class Called(NamedTuple):
    """Two methods of the same role."""

    methods: Ints  # (2, 2)
    out: Vec
    x: Vec


@kernel
def _by_address(of: Any) -> int:
    found = 0
    for k in range(len(of.methods)):
        found += _call(Method(of.methods[k, 0], of.methods[k, 1]), (of.x,))
    return found


@needs_compiler
@pytest.mark.parametrize("function", [_arithmetic, _loops, _handed])
def test_a_kernel_gives_the_same_in_c(function: Any, tmp_path: Path) -> None:
    result, out = _in_c(function, _data(), tmp_path)
    expected = _data()
    assert result == function(expected)
    np.testing.assert_array_equal(out, expected.out)
    assert np.count_nonzero(out) > 3


@needs_compiler
def test_a_branch_that_the_data_rule_out_is_not_translated(tmp_path: Path) -> None:
    assert _in_c(_branches, _data(), tmp_path)[0] == 25
    with pytest.raises(NotTranslated, match=r"line \d+ of _branches .*_not_there has no value"):
        translated(_branches.py_func, _data(on=False))  # type: ignore[attr-defined]


@needs_compiler
def test_methods_that_are_called_by_address_become_functions(tmp_path: Path) -> None:
    data = [_data(), _data()]
    bound = [ROLE.bind(_add, one) for one in data]
    called = Called(np.array([one.method for one in bound]), data[0].out, np.array([2.0, 3.0]))
    result, out = _in_c(_by_address, called, tmp_path)
    assert result == 14
    np.testing.assert_array_equal(out[:2], [2.0, 3.0])
    text = Rendered(*translated(_by_address.py_func, called), "tried", [data[0].out])  # type: ignore[attr-defined]
    assert "tried_add_2(me" in text.implementation()  # one function for each set of data


@kernel
def _given_up(of: Any) -> int:
    of.out[0] += 1.0
    if of.given[0] > 5.0:
        raise ValueError("no answer")
    return 0


@needs_compiler
def test_where_a_kernel_raises_a_program_says_so_until_it_begins_anew(tmp_path: Path) -> None:
    data = _data()
    ports = [(Port("x", "", ""),)]
    text = header(
        Rendered(*translated(_given_up.py_func, data), "raising", [data.given, data.out]),  # type: ignore[attr-defined]
        "a program",
        "A step counts.",
        returns="0",
        period=0.01,
        inputs=ports,
        outputs=ports,
        read=[(data.given, 0, 1)],
        write=[(data.out, 0, 1)],
    )
    stepper = Stepper(
        Program(name="raising", period=0.01, inputs=ports[0], outputs=ports[0], header=text), tmp_path
    )
    assert [stepper.step([x])[0] for x in (1.0, 6.0, 1.0)] == [0, -1, -1]
    stepper.begin()
    assert stepper.step([1.0]) == (0, [1.0])
    with pytest.raises(ValueError, match="no answer"):
        _given_up(data._replace(given=np.full(8, 6.0)))


@kernel
def _unsaid(of: Any) -> int:
    of.out[0] = np.linalg.norm(of.given)
    return 0


def test_what_cannot_be_said_names_function_and_line() -> None:
    with pytest.raises(NotTranslated, match=r"line \d+ of _unsaid \(.*test_translate.py\): a call of norm"):
        translated(_unsaid.py_func, _data())  # type: ignore[attr-defined]
