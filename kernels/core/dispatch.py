"""Calls by number: a branch for each of some modules, written out, as Numba needs them."""

from collections.abc import Callable, Iterable
from typing import Any

from photonmap.kernels.core.jit import jit


def by_number(modules: Iterable[Any], name: str, parameters: str, number: str = "") -> Callable:
    """Return a function that calls the function of this name in one of some modules.

    Parameters
    ----------
    modules : all there are, by their numbers, of which there are no others
    parameters : of all functions, and of the one returned
    number : expression of the parameters that tells which; by default, a parameter before them

    Raises
    ------
    AttributeError : a module lacks the function
    """
    functions = {f"of_{place}": getattr(module, name) for place, module in enumerate(modules)}
    *branches, last = functions
    head = parameters if number else f"number, {parameters}"
    lines = [f"def {name}({head}):", *([f"    number = {number}"] if number else [])]
    for place, branch in enumerate(branches):
        lines += [f"    if number == {place}:", f"        return {branch}({parameters})"]
    lines += [f"    return {last}({parameters})"]
    scope: dict[str, Any] = dict(functions)
    exec(compile("\n".join(lines), f"<{name} by number>", "exec"), scope)
    return jit(scope[name])
