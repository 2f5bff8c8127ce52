"""The decorators of kernels, and calls by number: a branch for each of some modules."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numba
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types import unliteral

from photonmap.kernels.core.code_cache import SOURCES, USER_FOLDER, KernelCache, source_hash
from photonmap.kernels.core.linking import (
    IS_KNOWN,
    DisjointCompiler,
    FullCompiler,
    KernelCompiler,
    only_linked,
)

CACHE_FOLDER = USER_FOLDER / f"kernels-{source_hash(SOURCES)}"
"""Of tables that kernels make, and of marks that say what is compiled"""


def kernel(function: Callable) -> Callable:
    """Compile a function that Python calls: releases the GIL, divides as NumPy does, is cached.

    Kernels allocate nothing: without Numba's reference counts, whose atomic increments took half
    of the camera pass, arrays cost nothing to pass on.
    """
    compiled = _compile(function, no_cfunc_wrapper=True)
    if isinstance(compiled, CPUDispatcher):
        compiled._cache = KernelCache(function)
    return compiled


def jit(function: Callable) -> Callable:
    """Compile a function of kernels into its callers' machine code."""
    return _inner(_compile(function, forceinline=True, **_NO_WRAPPERS))


def outlined(function: Callable) -> Callable:
    """Compile a function of kernels that is large: it is called, not inlined.

    Left unset, Numba would take `forceinline` from the caller. Inlining them all took nine tenths
    of the compile time of rough and specular surfaces together.
    """
    return _inner(_compile(function, forceinline=False, **_NO_WRAPPERS))


def vectorized(function: Callable) -> Callable:
    """Compile a function as `outlined` does, for arrays that do not overlap.

    Told so, LLVM turns loops of any length into vector instructions: the checks that it would make
    else pay only for a dozen iterations and more.
    """
    compiler = DisjointCompiler if IS_KNOWN else FullCompiler
    return _inner(_compile(function, forceinline=False, **_NO_WRAPPERS, pipeline_class=compiler))


# Turning Python's objects into a scene's arrays takes more code than many a function itself.
_NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Inner(CPUDispatcher):
    """A function of kernels; one that Python calls after all, as tests do, gets a wrapper then."""

    def __call__(self, *arguments: object) -> object:
        return _wrapped(self)(*arguments)

    def get_call_template(self, args: tuple, kws: dict) -> object:
        """Return the one version for all constants of a type: inlined, they are constants."""
        kinds = {name: unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template(tuple(map(unliteral, args)), kinds)

    def compile(self, signature: object) -> object:
        """Compile for linking alone: callers optimise what they inline, and emit machine code.

        Numba's own would look for a file, and start two timers for every function on the way in,
        each of which hears of every step further in.
        """
        if not IS_KNOWN:
            return super().compile(signature)
        arguments, result = normalize_signature(signature)
        known = self.overloads.get(tuple(arguments))
        if known is not None:
            return known.entry_point
        with only_linked(self.targetctx.codegen()), self._compiling_counter:
            compiled = self._compiler.compile(arguments, result)
            self.add_overload(compiled)
        return compiled.entry_point


@cache
def _wrapped(function: Callable) -> Callable:
    @numba.njit(error_model="numpy", _nrt=False)
    def call(*arguments):
        return function(*arguments)

    return call


def _inner(compiled: Callable) -> Callable:
    if isinstance(compiled, CPUDispatcher):
        compiled.__class__ = _Inner
    return compiled


def _compile(function: Callable, **options: Any) -> Callable:
    options.setdefault("pipeline_class", KernelCompiler if IS_KNOWN else FullCompiler)
    return numba.njit(nogil=True, error_model="numpy", _nrt=False, **options)(function)


def by_number(modules: Iterable[Any], name: str, parameters: str, number: str = "") -> Callable:
    """Return a function that calls the function of this name in one of some modules, by number.

    `parameters` are those of all functions; `number` is an expression of them that tells which, by
    default a parameter before them. A module without the function is an AttributeError.
    """
    functions = {f"of_{index}": getattr(module, name) for index, module in enumerate(modules)}
    *branches, last = functions
    head = parameters if number else f"number, {parameters}"
    lines = [f"def {name}({head}):", *([f"    number = {number}"] if number else [])]
    for index, branch in enumerate(branches):
        lines += [f"    if number == {index}:", f"        return {branch}({parameters})"]
    lines += [f"    return {last}({parameters})"]
    scope: dict[str, Any] = dict(functions)
    exec(compile("\n".join(lines), f"<{name} by number>", "exec"), scope)
    return jit(scope[name])
