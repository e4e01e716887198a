"""Expressions as straight-line code: one function in Python or in C99, each intermediate value computed once."""

from collections.abc import Callable, Mapping, Sequence

from observation.expression import Expression, in_order, power, sign

_INFIX = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
_PYTHON_CALLS = {
    "sqrt": "sqrt",
    "sin": "sin",
    "cos": "cos",
    "arctan": "atan",
    "arctan2": "atan2",
    "arccos": "acos",
    "arcsin": "asin",
    "exp": "exp",
    "expm1": "expm1",
    "log": "log",
    "tanh": "tanh",
    "absolute": "abs",
    "sign": "sign",
    "power": "power",
}
_C_CALLS = _PYTHON_CALLS | {"absolute": "fabs", "sign": "sign_of", "power": "power_of"}


def _python_choice(condition: str, chosen: str, other: str) -> str:
    return f"{chosen} if {condition} else {other}"


def _c_choice(condition: str, chosen: str, other: str) -> str:
    return f"{condition} ? {chosen} : {other}"


def _line(
    operation: str,
    args: Sequence[str],
    calls: Mapping[str, str],
    choice: Callable[[str, str, str], str],
    is_true: str,
) -> str:
    """The right side of an operation; is_true: what stands behind a number to ask whether it is not zero."""
    if operation in _INFIX:
        return f"{args[0]} {_INFIX[operation]} {args[1]}"
    if operation == "negative":
        return f"-{args[0]}"
    if operation in ("maximum", "minimum"):
        compared = ">" if operation == "maximum" else "<"
        return choice(f"{args[0]} {compared} {args[1]}", args[0], args[1])
    if operation == "greater":
        return choice(f"{args[0]} > {args[1]}", "1.0", "0.0")
    if operation == "where":
        return choice(f"{args[0]}{is_true}", args[1], args[2])
    return f"{calls[operation]}({', '.join(args)})"


def _python_line(operation: str, args: Sequence[str]) -> str:
    return _line(operation, args, _PYTHON_CALLS, _python_choice, "")


def _c_line(operation: str, args: Sequence[str]) -> str:
    return _line(operation, args, _C_CALLS, _c_choice, " != 0.0")


def _lines(
    outputs: Sequence[Expression], line: Callable[[str, Sequence[str]], str]
) -> tuple[list[tuple[str, str]], list[str]]:
    """Assignments (name, right side) and the names of the outputs. Equal right sides are computed once."""
    names: dict[Expression, str] = {}
    known: dict[str, str] = {}
    assigned: list[tuple[str, str]] = []
    for node in in_order(outputs, {}):
        if node.operation == "constant":
            text = repr(node.value)
            names[node] = f"({text})" if text.startswith("-") else text
        elif node.operation == "variable":
            names[node] = node.name
        else:
            right = line(node.operation, [names[argument] for argument in node.args])
            if right not in known:
                known[right] = f"t{len(assigned)}"
                assigned.append((known[right], right))
            names[node] = known[right]
    return assigned, [names[output] for output in outputs]


def python_function(inputs: Sequence[Sequence[str]], outputs: Sequence[Expression]) -> Callable[..., tuple[float, ...]]:
    """A function of sequences of numbers, one for each of `inputs`, which are the names that the numbers have in the outputs."""
    assigned, names = _lines(outputs, _python_line)
    arguments = [f"a{i}" for i in range(len(inputs))]
    body = [f"{', '.join(own)}, = {argument}" for own, argument in zip(inputs, arguments, strict=True) if own]
    body += [f"{name} = {right}" for name, right in assigned]
    body.append(f"return ({', '.join(names)},)")
    text = f"def evaluated({', '.join(arguments)}):\n" + "".join(f"    {one}\n" for one in body)
    import math

    calls = {name: getattr(math, name) for name in _PYTHON_CALLS.values() if hasattr(math, name)}
    scope: dict[str, object] = calls | {"abs": abs, "sign": sign, "power": power}
    exec(compile(text, "<observer>", "exec"), scope)
    return scope["evaluated"]  # type: ignore[return-value]


def c_function(name: str, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[Expression]]) -> str:
    """A C99 function `static void name(const double *in..., double *out...)`, pointers in the order of the mappings."""
    flat = [e for part in outputs.values() for e in part]
    assigned, names = _lines(flat, _c_line)
    given = [f"const double *{argument}" for argument in inputs] + [f"double *{argument}" for argument in outputs]
    lines = [f"static void {name}({', '.join(given)})", "{"]
    lines += [
        f"    const double {own} = {argument}[{i}];"
        for argument, own_names in inputs.items()
        for i, own in enumerate(own_names)
    ]
    lines += [f"    (void){own};" for own_names in inputs.values() for own in own_names]
    lines += [f"    (void){argument};" for argument in (*inputs, *outputs)]
    lines += [f"    const double {target} = {right};" for target, right in assigned]
    place = 0
    for argument, part in outputs.items():
        for i in range(len(part)):
            lines.append(f"    {argument}[{i}] = {names[place]};")
            place += 1
    return "\n".join([*lines, "}", ""])
