"""The project's own sources: its modules, what each imports, and the functions in it."""

import ast
import gc
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = {"photonmap": ROOT / "photonmap", "photonmap.kernels": ROOT / "kernels"}
"""Folders of modules by the name of their package."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    gc.disable()  # trees are kept: to look for garbage in them takes three times as long
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    finally:
        gc.freeze()
        gc.enable()


@cache
def lines(path: Path) -> list[str]:
    """Return the lines of a file."""
    return path.read_text(encoding="utf-8").splitlines()


@cache
def modules() -> dict[str, Path]:
    """Return the file of every module and package, by its full name."""
    found = {}
    for package, folder in PACKAGES.items():
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements right below a node: expressions hold none."""
    for block in ("body", "handlers", "orelse", "finalbody", "cases"):
        yield from getattr(node, block, ())


def every_statement(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements below a node."""
    for child in statements(node):
        yield child
        yield from every_statement(child)


def imports(path: Path) -> Iterator[str]:
    """Yield the full names that a file imports, wherever: in functions, for type checkers too."""
    for node in every_statement(parsed(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} has a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def imported_modules(name: str) -> set[str]:
    """Return the project's modules that a module imports: of `from a.b import c`, c or else b."""
    found = set()
    for target in imports(modules()[name]):
        while target not in modules() and "." in target:
            target = target.rpartition(".")[0]
        if target in modules():
            found.add(target)
    return found - {name}


def functions(path: Path) -> Iterator[tuple[str, Function]]:
    """Yield the qualified name and syntax tree of every function and method of a file."""

    def within(node: ast.AST, prefix: str) -> Iterator[tuple[str, Function]]:
        for child in statements(node):
            name = f"{prefix}{child.name}" if hasattr(child, "name") else prefix
            if isinstance(child, Function):
                yield name, child
            if isinstance(child, Function | ast.ClassDef):
                yield from within(child, f"{name}.")
            else:
                yield from within(child, prefix)

    return within(parsed(path), "")


def lines_of_code(path: Path, function: Function) -> int:
    """Count the lines of a function's body without its docstring, comments and empty lines."""
    body = (
        function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body
    )
    if not body:
        return 0
    text = lines(path)[body[0].lineno - 1 : body[-1].end_lineno]
    return sum(bool(line.strip()) and not line.strip().startswith("#") for line in text)


def parameters(function: Function) -> list[str]:
    """Return the names of a function's parameters, a method's `self` or `cls` left out."""
    arguments = function.args
    every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    every += [extra for extra in (arguments.vararg, arguments.kwarg) if extra is not None]
    return [argument.arg for argument in every if argument.arg not in ("self", "cls")]
