"""Four numbers in one register, for kernels whose arithmetic the compiler does not vectorise by itself.

Numba's compiler vectorises loops, but not the straight-line code of a small dense matrix. The functions here
are called from kernels alone. Products and sums may be fused, as in `otolith.core.jit.jit_fused`. On a
processor with shorter registers, the compiler splits the vectors.
"""

from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, register_model

WIDTH: Final = 4
_LANES: Final = ir.VectorType(ir.DoubleType(), WIDTH)
_INDEX: Final = ir.IntType(32)
_FREEDOMS: Final = ("contract", "nsz", "reassoc", "arcp")  # those of `jit_fused`


class LanesType(types.Type):
    """Numba's type of four numbers in a register."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES: Final = LanesType()


@register_model(LanesType)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _LANES)


def _pointer(context: Any, builder: Any, of: Any, array: Any, i: Any) -> Any:
    """Pointer to the vector at index i ≥ 0; numba's option to check bounds holds here, too."""
    W = context.make_array(of)(context, builder, array)
    if context.enable_boundscheck:
        (length,) = cgutils.unpack_tuple(builder, W.shape, 1)
        cgutils.do_boundscheck(context, builder, i, length)
        last = builder.add(i, ir.Constant(i.type, WIDTH - 1))
        cgutils.do_boundscheck(context, builder, last, length)
    return builder.bitcast(builder.gep(W.data, [i]), _LANES.as_pointer())


def _spread(builder: Any, number: Any) -> Any:
    """Vector with the same number in all lanes."""
    undefined = ir.Constant(_LANES, ir.Undefined)
    first = builder.insert_element(undefined, number, ir.Constant(_INDEX, 0))
    zeros = ir.Constant(ir.VectorType(_INDEX, WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, undefined, zeros)


def _times(builder: Any, s: Any, v: Any) -> Any:
    return builder.fmul(_spread(builder, s), v, flags=_FREEDOMS)


def _computed(signature: Any, compute: Callable[[Any, Any], Any]) -> Any:
    """Return what numba asks of an intrinsic whose value is `compute(builder, arguments)`."""

    def generate(context: Any, builder: Any, of: Any, arguments: Any) -> Any:
        del context, of
        return compute(builder, arguments)

    return signature, generate


@intrinsic
def load4(_: Any, W: Any, i: Any) -> Any:
    """Load W[i : i + 4]."""

    def generate(context: Any, builder: Any, of: Any, arguments: Any) -> Any:
        return builder.load(_pointer(context, builder, of.args[0], *arguments), align=8)

    del i
    return LANES(W, types.intp), generate


@intrinsic
def store4(_: Any, W: Any, i: Any, v: Any) -> Any:
    """Store v as W[i : i + 4]."""

    def generate(context: Any, builder: Any, of: Any, arguments: Any) -> Any:
        array, index, value = arguments
        builder.store(value, _pointer(context, builder, of.args[0], array, index), align=8)
        return context.get_dummy_value()

    del i
    return types.void(W, types.intp, v), generate


@intrinsic(prefer_literal=True)
def unit4(_: Any, lane: Any) -> Any:
    """Return one in this lane, a literal, and zero in the others."""
    row = ir.Constant(_LANES, [float(n == lane.literal_value) for n in range(WIDTH)])

    def compute(builder: Any, arguments: Any) -> Any:
        del builder, arguments
        return row

    return _computed(LANES(lane), compute)


@intrinsic(prefer_literal=True)
def lane4(_: Any, v: Any, lane: Any) -> Any:
    """Return the number in this lane, a literal."""
    place = ir.Constant(_INDEX, lane.literal_value)
    return _computed(types.float64(v, lane), lambda builder, of: builder.extract_element(of[0], place))


@intrinsic
def times4(_: Any, s: Any, v: Any) -> Any:
    """Return s v of a number s."""
    del s
    return _computed(LANES(types.float64, v), lambda builder, of: _times(builder, *of))


@intrinsic
def add4(_: Any, a: Any, b: Any) -> Any:
    """Return a + b."""
    return _computed(LANES(a, b), lambda builder, of: builder.fadd(*of, flags=_FREEDOMS))


@intrinsic
def add_times4(_: Any, a: Any, s: Any, v: Any) -> Any:
    """Return a + s v of a number s."""

    def compute(builder: Any, of: Any) -> Any:
        return builder.fadd(of[0], _times(builder, *of[1:]), flags=_FREEDOMS)

    del s
    return _computed(LANES(a, types.float64, v), compute)


@intrinsic
def less_times4(_: Any, a: Any, s: Any, v: Any) -> Any:
    """Return a − s v of a number s."""

    def compute(builder: Any, of: Any) -> Any:
        return builder.fsub(of[0], _times(builder, *of[1:]), flags=_FREEDOMS)

    del s
    return _computed(LANES(a, types.float64, v), compute)
