"""The ball's kernels without the options that a scene lacks, made by machine from the sources themselves.

A kernel takes an absent option as None, and Numba prunes what stands behind `if option is not None:`. Whether that
costs anything is measured against kernels that never had the option. They are made here: in the syntax tree of every
model file each `option is None` is decided, conditions are folded, the parameter, the field and the argument dropped,
and only what can still be reached is kept. The result is a package of its own, of plain kernels that know nothing of
the option.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import re
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

import vr_envs.models
from vr_envs.models.ball_options import OPTIONS

MODELS = "vr_envs.models"
KEPT = "jit"  # the decorator is the shipped one
FOLDER = Path(vr_envs.models.__file__).parent

Definition = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


class StripError(ValueError):
    """A model file uses an option in a way that this does not understand."""


class Module:
    """One model file: its definitions by name, and where the names that it imports from other model files come from."""

    def __init__(self, name: str) -> None:
        """Read and parse the file."""
        self.name = name
        self.tree = ast.parse((FOLDER / f"{name}.py").read_text())
        self.definitions: dict[str, Definition] = {}
        self.imports: dict[str, tuple[str, str]] = {}  # name here -> (module, name there)
        self.others: list[ast.stmt] = []  # imports of libraries
        for node in self.tree.body:
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(f"{MODELS}."):
                for alias in node.names:
                    self.imports[alias.asname or alias.name] = (node.module.removeprefix(f"{MODELS}."), alias.name)
            elif isinstance(node, ast.Import | ast.ImportFrom):
                self.others.append(node)
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                self.definitions[node.name] = node
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    for part in ast.walk(target):
                        if isinstance(part, ast.Name):
                            self.definitions[part.id] = node


def _names(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def _fields(node: Definition | None) -> list[str]:
    """Names of what a call of a function or class takes, in order."""
    if isinstance(node, ast.FunctionDef):
        return [a.arg for a in node.args.args]
    if isinstance(node, ast.ClassDef):
        return [n.target.id for n in node.body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)]
    return []


class _Strip(ast.NodeTransformer):
    """Takes the absent options out of one definition."""

    def __init__(self, absent: Collection[str], modules: dict[str, Module], module: Module) -> None:
        self.absent, self.modules, self.module = absent, modules, module
        # records of kernels whose fields are options, by the name that their instances have
        self.carriers = {
            name.lower()
            for m in modules.values()
            for name, node in m.definitions.items()
            if isinstance(node, ast.ClassDef) and any(ast.unparse(b) == "NamedTuple" for b in node.bases)
            if set(_fields(node)) & set(OPTIONS)
        }

    def is_absent(self, node: ast.AST) -> bool:
        """Whether an expression is an absent option."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in self.carriers:
            return node.attr in self.absent
        return isinstance(node, ast.Name) and node.id in self.absent

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        if self.is_absent(node.left) and isinstance(node.ops[0], ast.Is | ast.IsNot):
            return ast.Constant(isinstance(node.ops[0], ast.Is))
        return self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        decides = isinstance(node.op, ast.Or)  # True decides an `or`, False an `and`
        parts = []
        for part in node.values:
            part = self.visit(part)
            if isinstance(part, ast.Constant) and isinstance(part.value, bool):
                if part.value == decides:
                    return part
            else:
                parts.append(part)
        if not parts:
            return ast.Constant(not decides)
        return parts[0] if len(parts) == 1 else ast.BoolOp(node.op, parts)

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        test = self.visit(node.test)
        if isinstance(test, ast.Constant):
            return self.visit(node.body if test.value else node.orelse)
        return ast.IfExp(test, self.visit(node.body), self.visit(node.orelse))

    def visit_If(self, node: ast.If) -> ast.AST | list[ast.stmt]:
        test = self.visit(node.test)
        if isinstance(test, ast.Constant):
            return [s for kept in (node.body if test.value else node.orelse) for s in self._statements(kept)]
        body = [s for kept in node.body for s in self._statements(kept)] or [ast.Pass()]
        return ast.If(test, body, [s for kept in node.orelse for s in self._statements(kept)])

    def _statements(self, node: ast.stmt) -> list[ast.stmt]:
        found = self.visit(node)
        return found if isinstance(found, list) else [found]

    def visit_Call(self, node: ast.Call) -> ast.AST:
        called = node.func.id if isinstance(node.func, ast.Name) else ""
        module, name = self.module.imports.get(called, (self.module.name, called))
        taken = _fields(self.modules[module].definitions.get(name) if module in self.modules else None)
        args = list(node.args)
        if any(isinstance(a, ast.Starred) for a in args):
            # what stands behind a starred argument is counted from the end
            star = next(k for k, a in enumerate(args) if isinstance(a, ast.Starred))
            behind = len(args) - star - 1
            positions = [*taken[:star], "", *taken[len(taken) - behind :]]
        else:
            positions = taken
        node.args = [a for k, a in enumerate(args) if not (k < len(positions) and positions[k] in self.absent)]
        node.keywords = [k for k in node.keywords if k.arg not in self.absent]
        return self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        if ast.get_docstring(node) is not None:
            node.body = node.body[1:]
        node.args.args = [a for a in node.args.args if a.arg not in self.absent]
        self.generic_visit(node)
        node.body = node.body or [ast.Pass()]  # a kernel for an option alone
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        dropped = set(_fields(node)) & set(self.absent)
        node.body = [
            n
            for n in node.body
            if not (isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name) and n.target.id in dropped)
            and not isinstance(n, ast.Expr)
        ]
        return node


def stripped_sources(entry: tuple[str, str], absent: Collection[str]) -> dict[str, str]:
    """Text of the model files that a kernel needs without the options `absent`: module name -> source.

    Args:
        entry: (module, kernel), for instance ("ball_on_bar", "interval").
        absent: names in `OPTIONS`.

    Raises:
        StripError: an absent option is still there.
    """
    unknown = set(absent) - set(OPTIONS)
    if unknown:
        raise StripError(f"there are no options {', '.join(sorted(unknown))}; choose among {', '.join(OPTIONS)}")
    modules = {p.stem: Module(p.stem) for p in sorted(FOLDER.glob("*.py")) if p.stem != "__init__"}
    whole = {p.stem: Module(p.stem) for p in sorted(FOLDER.glob("*.py")) if p.stem != "__init__"}  # for the positions
    needed: dict[str, set[str]] = {}
    seen: set[tuple[str, str]] = set()
    waiting = [entry]
    while waiting:
        module, name = waiting.pop()
        here = modules[module]
        module, name = here.imports.get(name, (module, name))
        here = modules.get(module, here)
        if module == KEPT or (module, name) in seen or name not in here.definitions:
            continue
        seen.add((module, name))
        needed.setdefault(module, set()).add(name)
        node = _Strip(absent, whole, whole[module]).visit(here.definitions[name])
        left = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} & set(absent)
        if left:
            raise StripError(f"{module}.{name} still uses {', '.join(sorted(left))} without the option")
        waiting += [(module, used) for used in _names(node)]
    return {module: _text(modules[module], names) for module, names in sorted(needed.items())}


def _text(module: Module, names: set[str]) -> str:
    """Source of the definitions `names` of a module, with the imports that they use."""
    body: list[ast.stmt] = []
    for node in module.tree.body:
        defined = [name for name, known in module.definitions.items() if known is node]
        if names & set(defined):
            body.append(node)
    used = {name for node in body for name in _names(node)}
    lines = ["from __future__ import annotations"]
    lines += [ast.unparse(node) for node in module.others if "__future__" not in ast.unparse(node)]
    for name, (source, there) in module.imports.items():
        if name in used:
            package = f"{MODELS}." if source == KEPT else "."
            lines.append(f"from {package}{source} import {there} as {name}")
    return "\n".join([*lines, *(ast.unparse(ast.fix_missing_locations(node)) for node in body)]) + "\n"


@contextmanager
def stripped(entry: tuple[str, str], absent: Collection[str]) -> Iterator[ModuleType]:
    """The module of `entry` without the options `absent`, imported from a folder that is removed in the end."""
    sources = stripped_sources(entry, absent)
    # named by its text: a compiled loop over these kernels that is found on disk is over the same ones
    stamp = hashlib.sha256(repr(sources).encode()).hexdigest()[:16]
    package = f"vr_envs_stripped_{stamp}"
    # Numba takes unions of types for one another by their names, so records must not have those of the shipped ones
    records = "|".join(re.findall(r"^class (\w+)", "\n".join(sources.values()), re.MULTILINE))
    sources = {name: re.sub(rf"\b({records})\b", rf"\1_{stamp}", text) for name, text in sources.items()}
    with TemporaryDirectory(prefix=package) as folder:
        for module, text in sources.items():
            (Path(folder) / f"{module}.py").write_text(text)
        (Path(folder) / "__init__.py").touch()
        spec = importlib.util.spec_from_file_location(
            package, Path(folder) / "__init__.py", submodule_search_locations=[folder]
        )
        assert spec is not None and spec.loader is not None
        sys.modules[package] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(sys.modules[package])
            yield importlib.import_module(f"{package}.{entry[0]}")
        finally:
            for name in [n for n in sys.modules if n.split(".")[0] == package]:
                del sys.modules[name]
