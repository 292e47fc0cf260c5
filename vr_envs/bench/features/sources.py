"""The sources of kernels as definitions: what each file defines, and from which file it takes what it does not."""

from __future__ import annotations

import ast
import pkgutil
from collections.abc import Collection, Mapping
from importlib.util import find_spec
from pathlib import Path

import vr_envs

FOLDERS = ("vr_envs.models", "vr_envs.envs")
"""The packages that hold kernels."""
NEW = "NEW_PACKAGE"
"""Stands in texts for the name of the package that is made."""

Definition = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


class Module:
    """One file: its definitions by name, and where the names that it imports from other files come from.

    `imports`: name here -> (module, name there). A name of a module that is imported whole, `model.advance`, is
    rewritten as the plain name `model_advance`.
    """

    def __init__(self, name: str) -> None:
        """Read and parse the file."""
        self.name = name
        spec = find_spec(name)
        assert spec is not None and spec.origin is not None
        self.tree = ast.parse(Path(spec.origin).read_text())
        self.definitions: dict[str, Definition] = {}
        self.imports: dict[str, tuple[str, str]] = {}
        self.libraries: list[ast.Import | ast.ImportFrom] = []
        wholes: dict[str, str] = {}  # name here -> module
        for node in self.tree.body:
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(f"{vr_envs.__name__}."):
                for alias in node.names:
                    if node.module in FOLDERS:
                        wholes[alias.asname or alias.name] = f"{node.module}.{alias.name}"
                    else:
                        self.imports[alias.asname or alias.name] = (node.module, alias.name)
            elif isinstance(node, ast.Import) or (isinstance(node, ast.ImportFrom) and node.module != "__future__"):
                self.libraries.append(node)
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                self.definitions[node.name] = node
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    for part in ast.walk(target):
                        if isinstance(part, ast.Name):
                            self.definitions[part.id] = node
        _Flatten(self, wholes).visit(self.tree)

    def origin(self, name: str) -> tuple[str, str]:
        """Module and name of the definition behind a name in this file."""
        return self.imports.get(name, (self.name, name))

    def text(self, nodes: Mapping[str, Definition], new: set[tuple[str, str]]) -> str:
        """Source of definitions, by name, in the order of the file, and the imports that they use.

        What is among `new`, names with their modules, is taken from the package `NEW`.
        """
        body = list({id(self.definitions[name]): nodes[name] for name in self.definitions if name in nodes}.values())
        lines = ["from __future__ import annotations"]
        lines += [ast.unparse(node) for node in self.libraries]
        for name in sorted({name for node in body for name in names_in(node)} - set(nodes)):
            source, there = self.origin(name)
            if name in self.imports or name in self.definitions:
                package = f"{NEW}." if (source, there) in new else ""
                lines.append(f"from {package}{source} import {there} as {name}")
        return "\n".join([*lines, *(ast.unparse(ast.fix_missing_locations(node)) for node in body)]) + "\n"


class _Flatten(ast.NodeTransformer):
    """Rewrites `module.name` as `module_name`, an import of its own."""

    def __init__(self, module: Module, wholes: dict[str, str]) -> None:
        self.module, self.wholes = module, wholes

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        self.generic_visit(node)
        if not (isinstance(node.value, ast.Name) and node.value.id in self.wholes):
            return node
        flat = f"{node.value.id}_{node.attr}"
        self.module.imports[flat] = (self.wholes[node.value.id], node.attr)
        return ast.copy_location(ast.Name(flat, node.ctx), node)


def module_names() -> list[str]:
    """Every file of `FOLDERS`."""
    folders = [(folder, find_spec(folder)) for folder in FOLDERS]
    return [
        f"{folder}.{found.name}"
        for folder, spec in folders
        if spec is not None
        for found in pkgutil.iter_modules(spec.submodule_search_locations)
    ]


def names_in(node: ast.AST) -> set[str]:
    """The plain names that a piece of source takes from outside: in a function not its arguments and variables."""
    names = [n for n in ast.walk(node) if isinstance(n, ast.Name)]
    if not isinstance(node, ast.FunctionDef):
        return {n.id for n in names}
    own = {a.arg for n in ast.walk(node) if isinstance(n, ast.arguments) for a in (*n.args, n.vararg, n.kwarg) if a}
    return {n.id for n in names} - own - {n.id for n in names if isinstance(n.ctx, ast.Store)}


def taken(node: Definition | None) -> list[str]:
    """Names of what a call of a function or class takes, in order."""
    if isinstance(node, ast.FunctionDef):
        return [a.arg for a in node.args.args]
    if isinstance(node, ast.ClassDef):
        return [n.target.id for n in node.body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)]
    return []


def carriers(options: Collection[str], files: Mapping[str, Module]) -> set[str]:
    """The NamedTuples in which kernels carry options, by the name of their instances: the class' in lower case."""
    return {
        name.lower()
        for file in files.values()
        for name, node in file.definitions.items()
        if isinstance(node, ast.ClassDef) and any(ast.unparse(base) == "NamedTuple" for base in node.bases)
        if set(taken(node)) & set(options)
    }
