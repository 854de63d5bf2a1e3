"""Formulas that users write: Python's arithmetic, of known names only; nothing in them is ever run."""

import ast
from functools import cache
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator

from legspring.model._base import ModelError

if TYPE_CHECKING:
    import sympy

VARIABLES = ("t", "l0", "ldev", "phi")
"""Time since touch-down (step durations), nominal length (m), signed actuation (m), phase (rad)."""
FUNCTIONS = ("sin", "cos", "tan", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt")
LONGEST = 300
"""Characters."""
LARGEST_POWER = 20
MOST_NESTED = 8
LARGEST_NUMBER = 1e100
VALID = (
    f"must be a formula in {', '.join(VARIABLES)}, pi and numbers, with + - * /, ** (up to {LARGEST_POWER}) "
    f"and {', '.join(FUNCTIONS)}"
)


@cache
def parse(text: str) -> "sympy.Expr":
    """Return a formula as a SymPy expression in real symbols named as in `VARIABLES`.

    Parameters
    ----------
    text : str
        The formula.

    Returns
    -------
    sympy.Expr
        The expression.

    Raises
    ------
    ModelError
        If the text is no formula, or is too long.
    """
    if len(text) > LONGEST:
        raise ModelError(f"must be a formula of at most {LONGEST} characters, is {len(text)} long")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        if _nesting(tree) > MOST_NESTED:
            raise ModelError(f"functions and powers must be nested at most {MOST_NESTED} deep")
        return _checked_value(_expression(tree))
    except (SyntaxError, TypeError, ValueError, ArithmeticError, RecursionError, MemoryError) as error:
        reason = str(error) if isinstance(error, ModelError) else "it cannot be read"
        raise ModelError(f"{VALID}; {reason}") from None


def is_constant(text: str) -> bool:
    """Whether a formula's value is the same at all times."""
    import sympy

    return sympy.Symbol("t", real=True) not in parse(text).free_symbols


def _nesting(node: ast.AST) -> int:
    """How deep functions and powers are nested: the second rate of a deep one is too long to be compiled."""
    itself = isinstance(node, ast.Call) or (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow))
    return itself + max(map(_nesting, ast.iter_child_nodes(node)), default=0)


def _expression(node: ast.expr) -> "sympy.Expr":
    import sympy

    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return sympy.Float(float(number))
        case ast.Name(id="pi"):
            return sympy.pi
        case ast.Name(id=name) if name in VARIABLES:
            return sympy.Symbol(name, real=True)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_expression(operand)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _expression(operand)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return _expression(left) ** _power(right)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _expression(left) + _expression(right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            return _expression(left) - _expression(right)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _expression(left) * _expression(right)
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return _expression(left) / _expression(right)
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            return getattr(sympy, name)(_expression(argument))
    raise ModelError(f"{ast.unparse(node)!r} is none of these")


def _checked_value(expression: "sympy.Expr") -> "sympy.Expr":
    """Insist on a length whose rates are lengths, too: finite real numbers, but for where it is told otherwise by t."""
    import sympy

    never = (sympy.I, sympy.nan, sympy.oo, sympy.zoo, -sympy.oo)
    if any(sympy.sympify(part).has(*never) for part in (expression, expression.diff(sympy.Symbol("t", real=True)))):
        raise ModelError("it is no finite real number")
    if any(abs(number) > LARGEST_NUMBER for number in expression.atoms(sympy.Float)):
        raise ModelError(f"its numbers are beyond {LARGEST_NUMBER:g}")
    return expression


def _power(node: ast.expr) -> "sympy.Expr":
    """Exponents are small numbers: towers of powers would never end."""
    import sympy

    power = _expression(node)
    if not power.is_real or not power.is_number or not abs(power) <= LARGEST_POWER:
        raise ModelError(f"the power {ast.unparse(node)!r} is none of these")
    return sympy.Integer(power) if power == int(power) else power


def _checked(text: str) -> str:
    parse(text)
    return text


Formula = Annotated[str, AfterValidator(_checked)]
