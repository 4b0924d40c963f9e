"""Small arrays on the stack of a compiled loop, of sizes that the compiler knows.

``np.zeros(n)`` in a kernel is an allocation of unknown size: loops over it are neither unrolled nor kept in
registers. ``vector`` and ``matrix`` take their sizes from the lengths of tuples, which are part of the kernel's
signature, so that it is compiled for each size. In plain Python they are NumPy arrays.

Such an array lives as long as the kernel that asked for it: never return one.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

Axis = tuple[int, ...]  # only its length counts


def axis(size: int) -> Axis:
    """What tells a kernel the size of a dimension."""
    return (0,) * size


def vector(rows: Axis) -> NDArray[np.float64]:
    """Zeros (rows,)."""
    return np.zeros(len(rows))


def matrix(rows: Axis, columns: Axis) -> NDArray[np.float64]:
    """Zeros (rows, columns)."""
    return np.zeros((len(rows), len(columns)))


@type_callable(vector)
def _type_of_vector(context: Any) -> Any:
    return lambda rows: types.Array(types.float64, 1, "C")


@type_callable(matrix)
def _type_of_matrix(context: Any) -> Any:
    return lambda rows, columns: types.Array(types.float64, 2, "C")


@lower_builtin(vector, types.BaseTuple)
@lower_builtin(matrix, types.BaseTuple, types.BaseTuple)
def _allocate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    shape = [len(axis.types) for axis in signature.args]
    size = int(np.prod(shape))
    memory = ir.ArrayType(ir.DoubleType(), max(size, 1))
    place = cgutils.alloca_once(builder, memory)
    builder.store(ir.Constant(memory, None), place)
    array = make_array(signature.return_type)(context, builder)
    strides = [8 * int(np.prod(shape[i + 1 :])) for i in range(len(shape))]
    populate_array(
        array,
        data=builder.bitcast(place, ir.DoubleType().as_pointer()),
        shape=[context.get_constant(types.intp, n) for n in shape],
        strides=[context.get_constant(types.intp, n) for n in strides],
        itemsize=context.get_constant(types.intp, 8),
        meminfo=None,
    )
    return array._getvalue()
