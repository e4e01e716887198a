"""Expressions of scalars: what a formula does, kept so that it can be differentiated and written as code.

An expression is a number, a named input, or an operation on other expressions. Sums and products with 0 and 1 are simplified as
they are formed, and numbers among themselves are computed. Conditions are expressions too, 1 where they hold and 0 elsewhere.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def power(x: float, exponent: float) -> float:
    """x^exponent; 0 where x is 0 and the exponent negative: such a slope stands beside a factor that is 0 there."""
    return 0.0 if x == 0.0 and exponent < 0.0 else float(x**exponent)


def sign(x: float) -> float:
    """-1, 0 or 1."""
    return float((x > 0) - (x < 0))


OPERATIONS: Mapping[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "negative": lambda a: -a,
    "power": power,
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "arctan": math.atan,
    "arctan2": math.atan2,
    "arccos": math.acos,
    "arcsin": math.asin,
    "exp": math.exp,
    "expm1": math.expm1,
    "log": math.log,
    "tanh": math.tanh,
    "absolute": math.fabs,
    "sign": sign,
    "maximum": lambda a, b: a if a > b else b,
    "minimum": lambda a, b: a if a < b else b,
    "greater": lambda a, b: float(a > b),
    "where": lambda condition, a, b: a if condition else b,
}
"""all that an expression may do, by numpy's name of it"""

Number = float | int


class Expression:
    """A scalar formula; compared by identity."""

    __slots__ = ("args", "name", "operation", "value")

    def __init__(
        self, operation: str, args: tuple["Expression", ...] = (), value: float | None = None, name: str = ""
    ) -> None:
        self.operation, self.args, self.value, self.name = operation, args, value, name

    @property
    def real(self) -> "Expression":
        return self

    @property
    def imag(self) -> "Expression":
        return ZERO

    def __add__(self, other: Any) -> Any:
        return _binary(add, self, other)

    def __radd__(self, other: Any) -> Any:
        return _binary(add, other, self)

    def __sub__(self, other: Any) -> Any:
        return _binary(subtract, self, other)

    def __rsub__(self, other: Any) -> Any:
        return _binary(subtract, other, self)

    def __mul__(self, other: Any) -> Any:
        return _binary(multiply, self, other)

    def __rmul__(self, other: Any) -> Any:
        return _binary(multiply, other, self)

    def __truediv__(self, other: Any) -> Any:
        return _binary(divide, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _binary(divide, other, self)

    def __neg__(self) -> "Expression":
        return subtract(ZERO, self)


def constant(value: Number) -> Expression:
    """A number."""
    return Expression("constant", value=float(value))


def variable(name: str) -> Expression:
    """An input, by the name that code gives it."""
    return Expression("variable", name=name)


ZERO, ONE = constant(0.0), constant(1.0)


def as_expression(x: Any) -> Expression:
    """An expression, or a real number as one."""
    return x if isinstance(x, Expression) else constant(float(x))


def _binary(operation: Callable[[Expression, Expression], Expression], a: Any, b: Any) -> Any:
    """An operation on real operands; complex ones are left to ComplexExpression."""
    if isinstance(a, ComplexExpression) or isinstance(b, ComplexExpression):
        return NotImplemented
    if isinstance(a, complex) or isinstance(b, complex):
        return _COMPLEX[operation](as_complex(a), as_complex(b))
    return operation(as_expression(a), as_expression(b))


def add(a: Expression, b: Expression) -> Expression:
    """a + b."""
    if a.value == 0:
        return b
    if b.value == 0:
        return a
    return apply("add", a, b)


def subtract(a: Expression, b: Expression) -> Expression:
    """a - b."""
    if b.value == 0:
        return a
    if a.value == 0:
        return b.args[0] if b.operation == "negative" else apply("negative", b)
    return apply("subtract", a, b)


def multiply(a: Expression, b: Expression) -> Expression:
    """a b."""
    if a.value == 0 or b.value == 0:
        return ZERO
    if a.value == 1:
        return b
    return a if b.value == 1 else apply("multiply", a, b)


def divide(a: Expression, b: Expression) -> Expression:
    """a / b."""
    if a.value == 0:
        return ZERO
    return a if b.value == 1 else apply("divide", a, b)


def raised(a: Expression, b: Expression) -> Expression:
    """a^b: small whole powers as products."""
    if b.value in (1.0, 2.0, 3.0):
        return a if b.value == 1 else multiply(a, a if b.value == 2 else multiply(a, a))
    return apply("power", a, b)


def apply(operation: str, *args: Expression) -> Expression:
    """An operation of OPERATIONS; computed where all its operands are numbers."""
    values = [a.value for a in args]
    if all(value is not None for value in values):
        return constant(OPERATIONS[operation](*values))
    if operation == "where" and values[0] is not None:
        return args[1] if values[0] else args[2]
    return Expression(operation, args)


class ComplexExpression:
    """A complex number of two expressions, as the arm's dynamics take points of the plane."""

    __slots__ = ("imag", "real")

    def __init__(self, real: Expression, imag: Expression) -> None:
        self.real, self.imag = real, imag

    def __add__(self, other: Any) -> "ComplexExpression":
        b = as_complex(other)
        return ComplexExpression(add(self.real, b.real), add(self.imag, b.imag))

    __radd__ = __add__

    def __sub__(self, other: Any) -> "ComplexExpression":
        b = as_complex(other)
        return ComplexExpression(subtract(self.real, b.real), subtract(self.imag, b.imag))

    def __rsub__(self, other: Any) -> "ComplexExpression":
        return as_complex(other) - self

    def __mul__(self, other: Any) -> "ComplexExpression":
        b = as_complex(other)
        return ComplexExpression(
            subtract(multiply(self.real, b.real), multiply(self.imag, b.imag)),
            add(multiply(self.real, b.imag), multiply(self.imag, b.real)),
        )

    __rmul__ = __mul__

    def __neg__(self) -> "ComplexExpression":
        return ComplexExpression(subtract(ZERO, self.real), subtract(ZERO, self.imag))


def as_complex(x: Any) -> ComplexExpression:
    """A complex expression, or any number or expression as one."""
    if isinstance(x, ComplexExpression):
        return x
    if isinstance(x, Expression):
        return ComplexExpression(x, ZERO)
    return ComplexExpression(constant(complex(x).real), constant(complex(x).imag))


_COMPLEX: Mapping[Any, Callable[[ComplexExpression, ComplexExpression], ComplexExpression]] = {
    add: lambda a, b: a + b,
    subtract: lambda a, b: a - b,
    multiply: lambda a, b: a * b,
}

_SLOPES: Mapping[str, Callable[..., tuple[Expression, ...]]] = {
    "add": lambda e, a, b: (ONE, ONE),
    "subtract": lambda e, a, b: (ONE, -ONE),
    "multiply": lambda e, a, b: (b, a),
    "divide": lambda e, a, b: (divide(ONE, b), -divide(e, b)),
    "negative": lambda e, a: (constant(-1.0),),
    "power": lambda e, a, b: (multiply(b, raised(a, subtract(b, ONE))), ZERO),
    "sqrt": lambda e, a: (multiply(constant(0.5), apply("power", a, constant(-0.5))),),
    "sin": lambda e, a: (apply("cos", a),),
    "cos": lambda e, a: (-apply("sin", a),),
    "arctan": lambda e, a: (divide(ONE, add(ONE, multiply(a, a))),),
    "arctan2": lambda e, a, b: (divide(b, _square(a, b)), -divide(a, _square(a, b))),
    "arccos": lambda e, a: (-divide(ONE, apply("sqrt", subtract(ONE, multiply(a, a)))),),
    "arcsin": lambda e, a: (divide(ONE, apply("sqrt", subtract(ONE, multiply(a, a)))),),
    "exp": lambda e, a: (e,),
    "expm1": lambda e, a: (add(e, ONE),),
    "log": lambda e, a: (divide(ONE, a),),
    "tanh": lambda e, a: (subtract(ONE, multiply(e, e)),),
    "absolute": lambda e, a: (apply("sign", a),),
    "sign": lambda e, a: (ZERO,),
    "maximum": lambda e, a, b: (apply("greater", a, b), subtract(ONE, apply("greater", a, b))),
    "minimum": lambda e, a, b: (apply("greater", b, a), subtract(ONE, apply("greater", b, a))),
    "greater": lambda e, a, b: (ZERO, ZERO),
    "where": lambda e, c, a, b: (ZERO, apply("where", c, ONE, ZERO), apply("where", c, ZERO, ONE)),
}
"""derivatives of an operation by its operands; e is the operation itself. Exponents are numbers."""


def _square(a: Expression, b: Expression) -> Expression:
    return add(multiply(a, a), multiply(b, b))


class Derivatives:
    """Derivatives by one input; what formulas share is differentiated once."""

    def __init__(self, by: Expression) -> None:
        self._known: dict[Expression, Expression] = {by: ONE}
        self._by = by

    def of(self, e: Expression) -> Expression:
        """The derivative of an expression."""
        for node in in_order([e], self._known):
            if node.args:
                slopes = _SLOPES[node.operation](node, *node.args)
                total = ZERO
                for argument, slope in zip(node.args, slopes, strict=True):
                    total = add(total, multiply(slope, self._known[argument]))
                self._known[node] = total
            else:
                self._known[node] = ZERO
        return self._known[e]


def in_order(roots: Sequence[Expression], known: Mapping[Expression, Any]) -> list[Expression]:
    """All that roots consist of and is not `known`, operands before what takes them."""
    out: list[Expression] = []
    done = set(known)
    stack = [(root, False) for root in reversed(roots)]
    while stack:
        node, ready = stack.pop()
        if node in done:
            continue
        if ready:
            done.add(node)
            out.append(node)
        else:
            stack.append((node, True))
            stack += [(argument, False) for argument in node.args]
    return out
