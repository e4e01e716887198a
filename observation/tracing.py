"""Arrays of expressions that numpy takes for arrays: formulas written for numbers give the formulas themselves.

A law or the arm's dynamics, called with a `TracedArray`, returns one: numpy hands its functions over to this class (NEP 13, NEP
18). So each formula stands in one place, and what is exported to code is what the simulation computes. A function that is not
known here is refused by its name.
"""

from collections.abc import Callable, Mapping
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from observation.expression import (
    OPERATIONS,
    ComplexExpression,
    Expression,
    apply,
    as_complex,
    as_expression,
    raised,
)


class Untraceable(TypeError):
    """A formula calls a function of numpy that has no expression."""


def _by_name(name: str) -> Callable[..., Expression]:
    return lambda *args: apply(name, *map(as_expression, args))


def _sum_of(a: Any, b: Any) -> Any:
    return a + b


def _exp(a: Any) -> Any:
    if not isinstance(a, ComplexExpression):
        return apply("exp", as_expression(a))
    size = apply("exp", a.real)
    return ComplexExpression(size * apply("cos", a.imag), size * apply("sin", a.imag))


def _absolute(a: Any) -> Any:
    if not isinstance(a, ComplexExpression):
        return apply("absolute", as_expression(a))
    return apply("sqrt", a.real * a.real + a.imag * a.imag)


_ELEMENTWISE: Mapping[str, Callable[..., Any]] = {
    **{name: _by_name(name) for name in OPERATIONS},
    "add": _sum_of,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "negative": lambda a: -a,
    "power": lambda a, b: raised(as_expression(a), as_expression(b)),
    "exp": _exp,
    "absolute": _absolute,
    "square": lambda a: a * a,
    "less": lambda a, b: apply("greater", as_expression(b), as_expression(a)),
    "conjugate": lambda a: a if isinstance(a, Expression) else ComplexExpression(a.real, -a.imag),
}


class TracedArray(NDArrayOperatorsMixin):
    """An array of expressions, or of complex ones; of numpy's shape and indexing."""

    def __init__(self, elements: Any) -> None:
        self.elements = np.asarray(elements, dtype=object)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.elements.shape

    @property
    def ndim(self) -> int:
        return self.elements.ndim

    def __len__(self) -> int:
        return len(self.elements)

    def __getitem__(self, key: Any) -> "TracedArray":
        return TracedArray(self.elements[key])

    def __setitem__(self, key: Any, value: Any) -> None:
        self.elements[key] = elements_of(value)

    def copy(self) -> "TracedArray":
        return TracedArray(self.elements.copy())

    @property
    def real(self) -> "TracedArray":
        return self._each(lambda e: as_complex(e).real)

    @real.setter
    def real(self, value: Any) -> None:
        self.elements[...] = _elementwise(lambda e, v: ComplexExpression(as_expression(v), as_complex(e).imag))(
            self.elements, elements_of(value)
        )

    @property
    def imag(self) -> "TracedArray":
        return self._each(lambda e: as_complex(e).imag)

    @imag.setter
    def imag(self, value: Any) -> None:
        self.elements[...] = _elementwise(lambda e, v: ComplexExpression(as_complex(e).real, as_expression(v)))(
            self.elements, elements_of(value)
        )

    def _each(self, function: Callable[..., Any]) -> "TracedArray":
        return TracedArray(_elementwise(function)(self.elements))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, out: Any = None, **options: Any) -> Any:
        if method != "__call__" or options or ufunc.__name__ not in _ELEMENTWISE:
            raise Untraceable(f"numpy.{ufunc.__name__}")
        result = _elementwise(_ELEMENTWISE[ufunc.__name__])(*map(elements_of, inputs))
        if out is not None:
            out[0][...] = TracedArray(result)
            return out[0]
        return TracedArray(result)

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        if function.__name__ not in _FUNCTIONS:
            raise Untraceable(f"numpy.{function.__name__}")
        return _FUNCTIONS[function.__name__](*args, **options)


def symbols(elements: Any) -> Any:
    """A traced array, for formulas that are typed for arrays of numbers."""
    return TracedArray(elements)


def elements_of(x: Any) -> Any:
    """Elements of a traced array, or numbers."""
    return x.elements if isinstance(x, TracedArray) else np.asarray(x).astype(object)


def _elementwise(function: Callable[..., Any]) -> Callable[..., Any]:
    def applied(*arrays: Any) -> Any:
        shape = np.broadcast_shapes(*(a.shape for a in arrays))
        out = np.empty(shape, dtype=object)
        each = [np.broadcast_to(a, shape) for a in arrays]
        for place in np.ndindex(shape):
            out[place] = function(*(a[place] for a in each))
        return out

    return applied


def _where(condition: Any, a: Any, b: Any) -> TracedArray:
    return TracedArray(_elementwise(_ELEMENTWISE["where"])(*map(elements_of, (condition, a, b))))


def _clip(x: Any, low: Any, high: Any) -> Any:
    return np.minimum(np.maximum(x, low), high)


def _cumulative_sum(x: TracedArray, axis: int) -> TracedArray:
    sums = list(accumulate(np.moveaxis(x.elements, axis, 0), _elementwise(_ELEMENTWISE["add"])))
    return TracedArray(np.stack(sums, axis=axis))


def _joined(function: Callable[..., Any]) -> Callable[..., TracedArray]:
    return lambda arrays, axis=0: TracedArray(function([elements_of(a) for a in arrays], axis=axis))


def _like(value: float) -> Callable[..., TracedArray]:
    def made(x: TracedArray, dtype: Any = None, shape: tuple[int, ...] | None = None) -> TracedArray:
        return TracedArray(np.full(x.shape if shape is None else shape, as_expression(value), dtype=object))

    return made


_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "where": _where,
    "clip": _clip,
    "stack": _joined(np.stack),
    "concatenate": _joined(np.concatenate),
    "cumsum": _cumulative_sum,
    "broadcast_arrays": lambda *arrays: [
        TracedArray(a) for a in np.broadcast_arrays(*(elements_of(a) for a in arrays))
    ],
    "broadcast_to": lambda x, shape: TracedArray(np.broadcast_to(elements_of(x), shape)),
    "zeros_like": _like(0.0),
    "empty_like": _like(0.0),
    "shape": lambda x: x.shape,
    "ndim": lambda x: x.ndim,
}
