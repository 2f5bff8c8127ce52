"""How kernels and their functions are compiled: in fewer steps than Numba takes for any function.

Much of what Numba does is needed once, for the kernel that all its functions are linked into. This
rests on Numba's inside: where that is not as it was, `IS_KNOWN` is false, and all is compiled in
full, which takes longer. The machine code is the same.

And in one step more: a record's field that is None is a constant, so code that would use it is left
out, as Numba does for arguments that are None.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import ModuleRef
from numba.core import ir, typed_passes, types, untyped_passes
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, StateDict
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass
from numba.core.consts import ConstantInference
from numba.core.ir_utils import get_definition, guard
from numba.core.registry import CPUDispatcher

_NEEDLESS = {
    "WithLifting",
    "InlineClosureLikes",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "InlineInlinables",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "NopythonRewrites",
    "DumpParforDiagnostics",
}
"""Steps for what kernels do not contain: closures, comprehensions, expressions of whole arrays,
exceptions, `with`. After each, Numba finds the lifetimes of all variables anew."""


@register_pass(mutates_CFG=False, analysis_only=False)
class NoneFields(FunctionPass):
    """Make constants of fields that are None, of NamedTuples among the arguments."""

    _name = "none_fields"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: StateDict) -> bool:
        """Return whether the function was changed."""
        code, changed = state.func_ir, False
        blocks = code.blocks.values()
        for assigned in (each for block in blocks for each in block.find_insts(ir.Assign)):
            read = assigned.value
            if not isinstance(_kind_of(code, state.args, read), types.NoneType):
                continue
            definitions = code._definitions[assigned.target.name]
            assigned.value = ir.Const(None, loc=assigned.loc)
            definitions[definitions.index(read)] = assigned.value
            changed = True
        if changed:
            code._consts = ConstantInference(code)
        return changed


def _kind_of(code: ir.FunctionIR, kinds: tuple[types.Type, ...], read: object) -> object:
    """Return the type of a field of an argument, or of a field's field; else None."""
    if not isinstance(read, ir.Expr) or read.op != "getattr":
        return None
    holder = guard(get_definition, code, read.value)
    kind = kinds[holder.index] if isinstance(holder, ir.Arg) else _kind_of(code, kinds, holder)
    if isinstance(kind, types.NamedTuple) and read.attr in kind.fields:
        return kind.types[kind.fields.index(read.attr)]
    return None


class FullCompiler(CompilerBase):
    """All of Numba's steps, and ours."""

    def define_pipelines(self) -> list[PassManager]:
        """Return the one list of steps."""
        steps = PassManager("kernel")
        whole = DefaultPassBuilder.define_nopython_pipeline(self.state)
        for step, meaning in whole.passes:
            if step is untyped_passes.DeadBranchPrune:
                steps.add_pass(NoneFields, "fields that are None")
            if self.needs(step):
                steps.add_pass(step, meaning)
        steps.finalize()
        return [steps]

    def needs(self, step: type) -> bool:
        """Return whether a step of Numba's is taken."""
        return True


class KernelCompiler(FullCompiler):
    """The steps without those that are for what kernels do not contain."""

    def needs(self, step: type) -> bool:
        """Return whether a step of Numba's is taken."""
        return step.__name__ not in _NEEDLESS


class DisjointCompiler(KernelCompiler):
    """The same, for functions whose arrays do not overlap."""

    def define_pipelines(self) -> list[PassManager]:
        """Return the one list of steps; LLVM learns on the way that arrays do not overlap."""
        self.state.flags.noalias = True
        return super().define_pipelines()


class _LinkedLibrary(JITCodeLibrary):
    """Code that is only linked into its callers: compiling it further took half of all time."""

    _own: tuple[str, ...] = ()

    def add_ir_module(self, ir_module: Any) -> None:
        """Add code, and note the functions in it that others may call."""
        super().add_ir_module(ir_module)
        own = [each.name for each in ir_module.functions if not each.is_declaration]
        self._own += tuple(own)

    def finalize(self) -> None:
        """Link in what the code calls."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def _get_module_for_linking(self) -> ModuleRef:
        """Return the code itself: Numba's own would return a copy, whose original serves here."""
        self._ensure_finalized()
        if self._shared_module is None:
            for name in self._own:
                self._final_module.get_function(name).linkage = "linkonce_odr"
            self._shared_module = self._final_module
        return self._shared_module

    def _optimize_functions(self, module: ModuleRef) -> None:
        """Simplify what is defined: Numba's own makes a list of passes for each declaration too."""
        if not _MAKES_LISTS:
            super()._optimize_functions(module)
            return
        module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def get_pointer_to_function(self, name: str) -> int:
        """Return that it has no address."""
        return 0

    @property
    def codegen(self) -> "_NoEnvironments":
        """The code generator, which sets no Python environment."""
        return _NoEnvironments(self._codegen)


class _NoEnvironments:
    """A code generator for code that has no address: its Python environment is not set."""

    def __init__(self, codegen: object) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> object:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: object) -> None:
        """Do nothing."""


@contextmanager
def only_linked(codegen: JITCPUCodegen) -> Iterator[None]:
    """Let what is compiled be linked into its callers alone, while no other thread compiles."""
    with global_compiler_lock:
        before = codegen._library_class
        codegen._library_class = _LinkedLibrary
        try:
            yield
        finally:
            codegen._library_class = before


_MAKES_LISTS = hasattr(JITCPUCodegen, "_pass_builder")
"""Whether it does, as since LLVM's new pass managers; before, one list served a module"""
_INSIDE: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (
        JITCodeLibrary,
        ("_get_module_for_linking", "_optimize_functions", "_raise_if_finalized", "add_ir_module"),
    ),
    (JITCPUCodegen, ("_library_class",)),
    (CPUDispatcher, ("add_overload",)),
    (Flags, ("noalias",)),
)
_STEPS = {*vars(typed_passes), *vars(untyped_passes)}
IS_KNOWN = _NEEDLESS <= _STEPS and all(
    hasattr(kind, name) for kind, names in _INSIDE for name in names
)
"""Whether Numba's inside is as it was"""
