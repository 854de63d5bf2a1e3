"""Length laws that users write: compiled one by one, called through their address, so that the kernel is compiled once.

The function at such an address writes six numbers: the force-free length with its first two time derivatives, and its
partial derivatives by l0, ldev and phi.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numba.extending
from llvmlite import ir
from numba.core import cgutils

from legspring.model.formula import VARIABLES, parse

compiler: Any = numba  # whose types leave out what is needed here
tools: Any = cgutils
NUMBERS = 6
Six = tuple[float, float, float, float, float, float]


@cache
def compiled(text: str) -> Any:
    """Compile a formula (see `legspring.model.formula`); what comes back has an ``address``, and must be kept."""
    import sympy

    variables = [sympy.Symbol(name, real=True) for name in VARIABLES]
    time, *coefficients = variables
    length = parse(text)
    rates = [length, length.diff(time), length.diff(time, 2)]
    partials = [length.diff(coefficient) for coefficient in coefficients]
    evaluate: Callable[..., Six] = sympy.lambdify(variables, tuple(rates + partials), modules="math", cse=True)
    law = compiler.njit(evaluate, error_model="numpy")

    def write(t: float, l0: float, ldev: float, phi: float, out: Any) -> None:
        numbers = compiler.carray(out, NUMBERS)
        numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5] = law(t, l0, ldev, phi)

    number = compiler.float64
    signature = compiler.void(number, number, number, number, compiler.types.CPointer(number))
    return compiler.cfunc(signature, error_model="numpy")(write)


def address(text: str | None) -> float:
    """Return the address of a formula in this process as a number of the kernel's kind, 0 for no formula.

    Addresses are below 2^53, and none of them is as low as 1.
    """
    return 0.0 if text is None else float(compiled(text).address)


def _call(_: Any, where: Any, t: Any, l0: Any, ldev: Any, phi: Any) -> Any:
    """Call the function at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number, pointer = ir.DoubleType(), ir.IntType(64)
        room = tools.alloca_once(builder, number, size=ir.Constant(pointer, NUMBERS))
        kind = ir.FunctionType(ir.VoidType(), [number] * 4 + [room.type])
        function = builder.inttoptr(builder.fptosi(arguments[0], pointer), kind.as_pointer())
        builder.call(function, [*arguments[1:], room])
        values = [builder.load(builder.gep(room, [ir.Constant(pointer, n)])) for n in range(NUMBERS)]
        return context.make_tuple(builder, signature.return_type, values)

    number = compiler.float64
    return compiler.types.UniTuple(number, NUMBERS)(number, number, number, number, number), generate


call: Any = compiler.extending.intrinsic(_call)
