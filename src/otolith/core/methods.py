"""Compiled objects: data that kernels hold by reference, and kernels that are called by address.

A closed loop is compiled once, whatever algorithm and plant take part in it, and whatever the structure of
the problem that is solved. For that, the parts that differ are handed to it as *methods*: the address of a
kernel's machine code, and the address of the data that this kernel works on. A kernel that was compiled long
ago, or loaded from the cache, is so called from another one without compiling either again.

`hold` puts a named tuple of arrays into memory of its own and returns a handle. To pass such a tuple to a
kernel, numba unpacks every array, which takes 5 µs for the fifty arrays of an MPC; to pass the handle takes
0.4 µs.

All methods of one *role* have the same arguments, so that a caller knows how to call them. Numba checks the
types on both sides when it compiles them: the caller's against the role, the kernel's in `Role.method`.
"""

from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple
from weakref import WeakValueDictionary

import numba
from numba import types
from numba.core import cgutils
from numba.experimental import structref
from numba.extending import intrinsic, overload

from otolith.core.jit import kernel

VECTOR: Final = types.Array(types.float64, 1, "C")  # argument types of roles
MATRIX: Final = types.Array(types.float64, 2, "C")
CUBE: Final = types.Array(types.float64, 3, "C")
INTEGER: Final = types.int64
NUMBER: Final = types.float64


class Method(NamedTuple):
    """A kernel and its data, as other kernels take them; zeros where there is none."""

    code: int  # address of the machine code
    data: int  # address of the data, which somebody else keeps alive


NO_METHOD: Final = Method(0, 0)
_METHOD: Final = types.NamedUniTuple(types.int64, 2, Method)


@structref.register
class HeldType(types.StructRef):
    """Numba's type of a handle; one for every type of named tuple."""


class Held(structref.StructRefProxy):
    """Handle of a named tuple; kernels read and write the tuple's fields as its own."""

    __slots__ = ()


structref.define_attributes(HeldType)
structref.define_boxing(HeldType, Held)


@overload(Held)
def _construct(values: Any):  # type: ignore[no-untyped-def]
    """Make a handle in a kernel: numba wants a function that names the fields, so its text is written."""
    kept = HeldType(
        tuple((name, types.unliteral(of)) for name, of in zip(values.fields, values, strict=True))
    )
    fields = "\n".join(f"    held.{name} = values.{name}" for name in values.fields)
    names = {"new": structref.new, "kept": kept, "Any": Any}
    exec(  # noqa: S102 (numba asks for a function; the names are those of a class's fields)
        f"def construct(values: Any):\n    held = new(kept)\n{fields}\n    return held\n",
        names,
    )
    return names["construct"]


@intrinsic
def _address(_: Any, held: Any) -> Any:
    """Return the address of a handle's data."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        struct = cgutils.create_struct_proxy(signature.args[0])(context, builder, value=arguments[0])
        return builder.ptrtoint(struct.meminfo, context.get_value_type(types.int64))

    return types.int64(held), generate


@intrinsic
def _pointer(_typing: Any, block: Any, _index: Any) -> Any:
    """Return the address block[index] as a pointer: LLVM trusts no loop over a number that became one."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        address = context.get_value_type(types.voidptr)
        return builder.load(builder.gep(builder.bitcast(array.data, address.as_pointer()), [arguments[1]]))

    return types.voidptr(block, types.intp), generate


array_at: Final[Any] = numba.carray  # type: ignore[attr-defined]
"""In kernels, `array_at(pointer(block, index), shape, dtype)` is the array at the address block[index]."""
pointer: Final[Any] = _pointer


@kernel
def hold(values: Any) -> Any:
    """Put a named tuple into memory of its own; return its handle, and the address of its data."""
    held = Held(values)
    return held, _address(held)  # type: ignore[call-arg]


def address_of(dispatcher: Any, *arguments: Any) -> int:
    """Return the address of a kernel's machine code for arguments of these types; compile it if needed."""
    dispatcher.compile(arguments)
    result = dispatcher.overloads[arguments]
    address: int = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    _kernels[address] = dispatcher
    return address


def kernel_at(code: int) -> Any:
    """Return the kernel whose machine code is at an address that `address_of` gave."""
    return _kernels[code]


def values_at(data: int) -> Any:
    """Return the named tuple whose handle's data are at an address, while its `Bound` is alive."""
    return _bound[data].values


_kernels: Final[dict[int, Any]] = {}


@dataclass(frozen=True, slots=True)
class Role:
    """The types of a method's result and of its arguments after the data."""

    returned: Any
    arguments: tuple[Any, ...]

    def bind(self, dispatcher: Any, values: tuple[Any, ...]) -> "Bound":
        """Make a method of a kernel and a named tuple, the data that it takes as its first argument."""
        held, data = hold(values)
        code = address_of(dispatcher, numba.typeof(held), *self.arguments)
        bound = Bound(held, Method(code, data), values)
        _bound[data] = bound
        return bound

    @property
    def call(self) -> Any:
        """Return the function with which kernels call a method: `call(method, (argument, …))`."""
        return _caller(self.returned, self.arguments)


@dataclass(frozen=True, slots=True, weakref_slot=True, eq=False)
class Bound:
    """A method together with the handle that keeps its data alive, and the named tuple held by it."""

    held: Any
    method: Method
    values: tuple[Any, ...]


_bound: Final[MutableMapping[int, Bound]] = WeakValueDictionary()


def call_at(returned: Any, *arguments: Any) -> Any:
    """Make a function for kernels, `call(address, (argument, …))`, that calls machine code at an address."""

    @intrinsic
    def call_address(_typing: Any, _address: Any, _given: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            unpacked = cgutils.unpack_tuple(builder, values[1], len(arguments))
            return _generate_call(context, builder, values[0], returned, arguments, unpacked)

        return returned(types.int64, types.Tuple(arguments)), generate

    return call_address


def _caller(returned: Any, arguments: tuple[Any, ...]) -> Any:
    """Make the function of `Role.call`."""

    @intrinsic
    def call_method(_typing: Any, _method: Any, _given: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            code, data = cgutils.unpack_tuple(builder, values[0], 2)
            data = builder.inttoptr(data, context.get_value_type(types.voidptr))
            unpacked = [data, *cgutils.unpack_tuple(builder, values[1], len(arguments))]
            of_kernel = (types.voidptr, *arguments)
            return _generate_call(context, builder, code, returned, of_kernel, unpacked)

        return returned(_METHOD, types.Tuple(arguments)), generate

    return call_method


def _generate_call(
    context: Any, builder: Any, code: Any, returned: Any, arguments: tuple[Any, ...], values: list[Any]
) -> Any:
    """Call a kernel's machine code as other compiled functions would; what it raises is raised here."""
    convention = context.call_conv
    function = builder.inttoptr(code, convention.get_function_type(returned, arguments).as_pointer())
    status, result = convention.call_function(builder, function, returned, arguments, values)
    with cgutils.if_unlikely(builder, status.is_error):
        convention.return_status_propagate(builder, status)
    return result
