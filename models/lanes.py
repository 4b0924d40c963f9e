r"""Parameter sets side by side in one number of the compiler, so that each instruction serves them all.

A compiled law takes ``LANES`` floats, one of each set, where it takes a float: laws and loops stay as they are. What
is added to, multiplied with or compared to them is a float or as many lanes. A law may leave out an effect whose
constant is zero: ``constant != 0.0`` holds if any lane differs, ``constant == 0.0`` if none does. Any other comparison gives a
truth of each lane, which ``elementary.where`` takes and which no ``if`` can: such a law does not compile for lanes.
``elementary.whole`` gives the first lane's number, ``require_alike`` what all lanes must have in common.

Powers, sines and cosines are those of the C library, one lane after the other.
"""

import operator
from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_borrowed
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import make_array, populate_array

LANES = 16

# numba's types take the argument of typing for one of the caller.
intrinsic: Any = extending.intrinsic

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_TRUTHS = ir.VectorType(ir.IntType(1), LANES)


class Lanes(types.Type):
    """``LANES`` floats."""

    def __init__(self) -> None:
        super().__init__(name=f"lanes{LANES}")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """A float or integer is the same in all lanes."""
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Lanes and floats make lanes."""
        return self if isinstance(other, (types.Float, types.Integer)) else None


class Truths(types.Type):
    """As many truths."""

    def __init__(self) -> None:
        super().__init__(name=f"truths{LANES}")


lanes, truths = Lanes(), Truths()


@extending.register_model(Lanes)
class _LanesModel(extending.models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


@extending.register_model(Truths)
class _TruthsModel(extending.models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _TRUTHS)


@extending.lower_cast(types.Float, Lanes)
@extending.lower_cast(types.Integer, Lanes)
def _in_all_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    number = context.cast(builder, value, source, types.float64)
    first = builder.insert_element(
        ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0)
    )
    mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(_VECTOR, ir.Undefined), mask)


def _constant(value: float) -> Any:
    return ir.Constant(_VECTOR, [value] * LANES)


def _operator(functions: Any, result: Any, lower: Any) -> None:
    """Type and lower operators of two numbers of which one at least is of lanes."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            if lanes in args and len(args) == 2:
                return signature(result, lanes, lanes)
            return None

    def implement(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return lower(builder, *args)

    for function in functions:
        infer_global(function)(Template)
        extending.lower_builtin(function, lanes, lanes)(implement)


for _names, _instruction in (
    (("add", "iadd"), ir.IRBuilder.fadd),
    (("sub", "isub"), ir.IRBuilder.fsub),
    (("mul", "imul"), ir.IRBuilder.fmul),
    (("truediv", "itruediv"), ir.IRBuilder.fdiv),
):
    _operator([getattr(operator, name) for name in _names], lanes, _instruction)


def _compare(sign: str) -> Any:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


for _function, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
):
    _operator([_function], truths, _compare(_sign))


def _differs(builder: Any, a: Any, b: Any) -> Any:
    """Whether any lane differs."""
    bits = builder.bitcast(builder.fcmp_unordered("!=", a, b), ir.IntType(LANES))
    return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))


_operator([operator.ne], types.boolean, _differs)
_operator([operator.eq], types.boolean, lambda builder, a, b: builder.not_(_differs(builder, a, b)))
_operator([min], lanes, lambda builder, a, b: builder.select(builder.fcmp_ordered("<", b, a), b, a))
_operator([max], lanes, lambda builder, a, b: builder.select(builder.fcmp_ordered(">", b, a), b, a))


@infer_global(operator.neg)
class _Negation(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(lanes, lanes) if args == (lanes,) else None


@extending.lower_builtin(operator.neg, lanes)
def _negative(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


def _call(name: str, arguments: int) -> Any:
    """An intrinsic of LLVM as a function of lanes."""
    kind = ir.FunctionType(_VECTOR, [_VECTOR] * arguments)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function = cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{LANES}f64")
        return builder.call(function, args)

    return generate


@intrinsic
def magnitude(typing_context: Any, x: Any) -> Any:
    """Absolute values."""
    return lanes(lanes), _call("llvm.fabs", 1)


@intrinsic
def with_sign(typing_context: Any, x: Any, sign: Any) -> Any:
    """Magnitudes of ``x`` with the signs of ``sign``."""
    return lanes(lanes, lanes), _call("llvm.copysign", 2)


@intrinsic
def rounded_down(typing_context: Any, x: Any) -> Any:
    """Largest whole numbers below."""
    return lanes(lanes), _call("llvm.floor", 1)


def _power(builder: Any, base: Any, exponent: Any) -> Any:
    """The C library's, one lane after the other."""
    double, index = ir.DoubleType(), ir.IntType(32)
    kind = ir.FunctionType(double, [double, double])
    function = cgutils.get_or_insert_function(builder.module, kind, "llvm.pow.f64")
    place = cgutils.alloca_once_value(builder, base)
    with cgutils.for_range(builder, ir.Constant(index, LANES)) as loop:
        vector = builder.load(place)
        pair = [builder.extract_element(one, loop.index) for one in (vector, exponent)]
        value = builder.call(function, pair)
        builder.store(builder.insert_element(vector, value, loop.index), place)
    return builder.load(place)


_operator([operator.pow], lanes, _power)


@intrinsic
def square_root(typing_context: Any, x: Any) -> Any:
    """Square roots."""
    return lanes(lanes), _call("llvm.sqrt", 1)


@intrinsic
def sine(typing_context: Any, x: Any) -> Any:
    """Sines."""
    return lanes(lanes), _one_by_one("llvm.sin.f64")


@intrinsic
def cosine(typing_context: Any, x: Any) -> Any:
    """Cosines."""
    return lanes(lanes), _one_by_one("llvm.cos.f64")


def _one_by_one(name: str) -> Any:
    """A function of the C library in a loop over the lanes: in place it would be many calls."""
    double, index = ir.DoubleType(), ir.IntType(32)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(double, [double])
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        place = cgutils.alloca_once_value(builder, args[0])
        with cgutils.for_range(builder, ir.Constant(index, LANES)) as loop:
            vector = builder.load(place)
            value = builder.call(function, [builder.extract_element(vector, loop.index)])
            builder.store(builder.insert_element(vector, value, loop.index), place)
        return builder.load(place)

    return generate


@intrinsic
def select(typing_context: Any, condition: Any, a: Any, b: Any) -> Any:
    """``a`` where the condition holds, ``b`` elsewhere."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(*args)

    return lanes(truths, lanes, lanes), generate


@intrinsic
def first_lane(typing_context: Any, x: Any) -> Any:
    """The first lane's number."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], ir.Constant(ir.IntType(32), 0))

    return types.float64(lanes), generate


@intrinsic
def in_lanes(typing_context: Any, array: Any) -> Any:
    """A contiguous array of floats (..., LANES) as one of lanes (...)."""
    target = types.Array(lanes, array.ndim - 1, "C", aligned=False)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source = make_array(array)(context, builder, args[0])
        found = make_array(target)(context, builder)
        shape = cgutils.unpack_tuple(builder, source.shape)[:-1]
        strides = cgutils.unpack_tuple(builder, source.strides)[:-1]
        populate_array(
            found,
            data=builder.bitcast(source.data, _VECTOR.as_pointer()),
            shape=shape,
            strides=strides,
            itemsize=context.get_constant(types.intp, 8 * LANES),
            meminfo=source.meminfo,
        )
        return impl_ret_borrowed(context, builder, target, found._getvalue())

    return target(array), generate
