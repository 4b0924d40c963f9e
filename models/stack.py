"""Small arrays on the stack of a compiled loop, of sizes that the compiler knows.

``np.zeros(n)`` in a kernel is an allocation of unknown size: loops over it are neither unrolled nor kept in
registers. ``vector`` and ``matrix`` take their sizes from the lengths of tuples, which are part of the kernel's
signature, so that it is compiled for each size, and hold numbers like those of an array ``like``, floats or lanes
(``lanes.py``). In plain Python they are NumPy arrays.

Such an array lives as long as the kernel that asked for it: never return one.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, register_jitable, type_callable
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

Axis = tuple[int, ...]  # only its length counts


def axis(size: int) -> Axis:
    """What tells a kernel the size of a dimension."""
    return (0,) * size


def vector(rows: Axis, like: Any) -> NDArray[np.float64]:
    """Zeros (rows,)."""
    return np.zeros(len(rows))


def matrix(rows: Axis, columns: Axis, like: Any) -> NDArray[np.float64]:
    """Zeros (rows, columns)."""
    return np.zeros((len(rows), len(columns)))


@register_jitable(inline="always")
def copy(source: Any, target: Any) -> None:
    """Copy a matrix into one of the same shape."""
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] = source[i, j]


@register_jitable(inline="always")
def clear(target: Any, column: int) -> None:
    """Set a column of a matrix to zero."""
    for i in range(target.shape[0]):
        target[i, column] = 0.0


def borrowed(array: Any) -> Any:
    """The same array for as long as its owner keeps it: a loop need not count who holds it."""
    return array


@type_callable(borrowed)
def _type_of_borrowed(context: Any) -> Any:
    return lambda array: array


@lower_builtin(borrowed, types.Array)
def _borrow(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    source = make_array(signature.args[0])(context, builder, arguments[0])
    array = make_array(signature.return_type)(context, builder)
    populate_array(
        array,
        data=source.data,
        shape=source.shape,
        strides=source.strides,
        itemsize=source.itemsize,
        meminfo=None,
    )
    return array._getvalue()


@type_callable(vector)
def _type_of_vector(context: Any) -> Any:
    return lambda rows, like: types.Array(like.dtype, 1, "C")


@type_callable(matrix)
def _type_of_matrix(context: Any) -> Any:
    return lambda rows, columns, like: types.Array(like.dtype, 2, "C")


@lower_builtin(vector, types.BaseTuple, types.Array)
@lower_builtin(matrix, types.BaseTuple, types.BaseTuple, types.Array)
def _allocate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    shape = [len(axis.types) for axis in signature.args[:-1]]
    number = context.get_data_type(signature.return_type.dtype)
    itemsize = context.get_abi_sizeof(number)
    memory = ir.ArrayType(number, max(int(np.prod(shape)), 1))
    place = cgutils.alloca_once(builder, memory)
    builder.store(ir.Constant(memory, None), place)
    array = make_array(signature.return_type)(context, builder)
    strides = [itemsize * int(np.prod(shape[i + 1 :])) for i in range(len(shape))]
    populate_array(
        array,
        data=builder.bitcast(place, number.as_pointer()),
        shape=[context.get_constant(types.intp, n) for n in shape],
        strides=[context.get_constant(types.intp, n) for n in strides],
        itemsize=context.get_constant(types.intp, itemsize),
        meminfo=None,
    )
    return array._getvalue()
