"""Kernels without the options that a scene lacks, made by machine from the sources themselves.

A kernel takes an absent option as None, and Numba prunes what stands behind `if option is not None:`. Whether that
costs anything is found by comparing with kernels that never had the option. They are made here: in the syntax tree of
every file each `option is None` is decided, conditions are folded, and the parameter, the field and the argument
dropped. The result is a package of its own, of plain kernels that know nothing of the option; it takes what never had
anything to do with the option from the package itself.
"""

from __future__ import annotations

import ast
import copy
import dataclasses
import hashlib
import importlib
import importlib.util
import re
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

from vr_envs.bench.features.sources import NEW, Definition, Module, carriers, module_names, names_in, taken
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.task import Task

Name = tuple[str, str]  # module and name
parsed = cache(Module)  # not to be changed


class StripError(ValueError):
    """A kernel uses an option in a way that this does not understand."""


class _Strip(ast.NodeTransformer):
    """Takes the absent options out of one definition."""

    def __init__(
        self, absent: Collection[str], carriers: Collection[str], files: Mapping[str, Module], module: Module
    ) -> None:
        self.absent, self.carriers, self.files, self.module = absent, carriers, files, module

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
            return self._statements(node.body if test.value else node.orelse)
        return ast.If(test, self._statements(node.body) or [ast.Pass()], self._statements(node.orelse))

    def _statements(self, nodes: list[ast.stmt]) -> list[ast.stmt]:
        """What is left of a block: nothing behind a statement that leaves it."""
        kept: list[ast.stmt] = []
        for node in nodes:
            found = self.visit(node)
            kept += found if isinstance(found, list) else [found]
            if kept and isinstance(kept[-1], ast.Return | ast.Raise | ast.Break | ast.Continue):
                break
        return kept

    def visit_Call(self, node: ast.Call) -> ast.AST:
        called = node.func.id if isinstance(node.func, ast.Name) else ""
        module, name = self.module.origin(called)
        positions = taken(self.files[module].definitions.get(name) if module in self.files else None)
        args = list(node.args)
        if any(isinstance(a, ast.Starred) for a in args):
            # what stands behind a starred argument is counted from the end
            star = next(k for k, a in enumerate(args) if isinstance(a, ast.Starred))
            behind = len(args) - star - 1
            positions = [*positions[:star], "", *positions[len(positions) - behind :]]
        node.args = [a for k, a in enumerate(args) if not (k < len(positions) and positions[k] in self.absent)]
        node.keywords = [k for k in node.keywords if k.arg not in self.absent]
        return self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.args.args = [a for a in node.args.args if a.arg not in self.absent]
        node.args = self.visit(node.args)
        node.body = self._statements(node.body) or [ast.Pass()]  # a kernel for an option alone
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        dropped = set(self.absent) if node.name.lower() in self.carriers else set()
        node.body = [
            n
            for n in node.body
            if not (isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name) and n.target.id in dropped)
        ]
        return node


def stripped_sources(entries: Sequence[Name], absent: Collection[str], options: Collection[str]) -> dict[str, str]:
    """Text of kernels without the options `absent`, and of the kernels that they use: module name -> source.

    What is no kernel, and not changed either, is imported from where it stands.

    Args:
        entries: (module, kernel), for instance ("vr_envs.models.ball_on_bar", "interval").
        absent: names among `options`.
        options: every option of the system, by the name that kernels give it.

    Raises:
        StripError: an absent option is still there.
    """
    unknown = set(absent) - set(options)
    if unknown:
        raise StripError(f"there are no options {', '.join(sorted(unknown))}; choose among {', '.join(options)}")
    files = {name: parsed(name) for name in {*module_names(), *(module for module, _ in entries)}}
    carried_in = carriers(options, files)
    nodes: dict[Name, Definition] = {}
    uses: dict[Name, set[Name]] = {}
    changed = set(entries)
    waiting = list(entries)
    while waiting:
        module, name = here = waiting.pop()
        if here in uses or module not in files or name not in files[module].definitions:
            continue
        whole = files[module].definitions[name]
        nodes[here] = _Strip(absent, carried_in, files, files[module]).visit(copy.deepcopy(whole))
        if _is_kernel(whole) or ast.dump(nodes[here]) != ast.dump(whole):
            changed.add(here)
        used = names_in(nodes[here])
        if left := {n.id for n in ast.walk(nodes[here]) if isinstance(n, ast.Name)} & set(absent):
            raise StripError(f"{module}.{name} still uses {', '.join(sorted(left))} without the option")
        uses[here] = {files[module].origin(one) for one in used}
        waiting += uses[here]
    while more := {name for name, used in uses.items() if used & changed} - changed:
        changed |= more
    made = sorted({module for module, _ in changed})
    return {m: files[m].text({name: nodes[at, name] for at, name in changed if at == m}, changed) for m in made}


def _is_kernel(node: ast.AST) -> bool:
    return isinstance(node, ast.FunctionDef) and "kernel" in {ast.unparse(mark) for mark in node.decorator_list}


@contextmanager
def stripped(entries: Sequence[Name], absent: Collection[str], options: Collection[str]) -> Iterator[list[Any]]:
    """The kernels `entries` without the options `absent`, imported from a folder that is removed in the end."""
    sources = stripped_sources(entries, absent, options)
    # named by its text: a compiled loop over these kernels that is found on disk is over the same ones
    stamp = hashlib.sha256(repr(sources).encode()).hexdigest()[:16]
    package = f"vr_envs_stripped_{stamp}"
    # Numba takes unions of types for one another by their names, so records must not have those of the shipped ones
    records = "|".join(re.findall(r"^class (\w+)", "\n".join(sources.values()), re.MULTILINE))
    if records:
        sources = {name: re.sub(rf"\b({records})\b", rf"\1_{stamp}", text) for name, text in sources.items()}
    with TemporaryDirectory(prefix=package) as folder:
        for module, text in sources.items():
            place = Path(folder).joinpath(*module.split(".")).with_suffix(".py")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text.replace(NEW, package))
        spec = importlib.util.spec_from_loader(package, None, is_package=True)
        assert spec is not None
        spec.submodule_search_locations = [folder]
        sys.modules[package] = importlib.util.module_from_spec(spec)
        try:
            made = {module: importlib.import_module(f"{package}.{module}") for module in sources}
            for value in [value for module in made.values() for value in vars(module).values()]:
                if isinstance(value, Dispatcher) and value.py_func.__module__.startswith(package):
                    vars(value)["_cache"] = NullCache()  # its types are gone in the next process
            yield [getattr(made[module], name) for module, name in entries]
        finally:
            for name in [n for n in sys.modules if n.split(".")[0] == package]:
                del sys.modules[name]


def kernels_of(value: Any) -> list[Any]:
    """The compiled functions in a dataclass, and in the dataclasses that it holds, in order."""
    found = []
    for field in dataclasses.fields(value):
        part = getattr(value, field.name)
        if isinstance(part, Dispatcher):
            found.append(part)
        elif dataclasses.is_dataclass(part) and not isinstance(part, type):
            found += kernels_of(part)
    return found


def with_kernels(value: Any, made: Mapping[Any, Any]) -> Any:
    """A dataclass with other compiled functions in place of those that `kernels_of` finds."""
    changes = {}
    for field in dataclasses.fields(value):
        part = getattr(value, field.name)
        if isinstance(part, Dispatcher):
            changes[field.name] = made[part]
        elif dataclasses.is_dataclass(part) and not isinstance(part, type):
            changes[field.name] = with_kernels(part, made)
    return dataclasses.replace(value, **changes)


@contextmanager
def stripped_task(task: Task, changes: dict[str, Any]) -> Iterator[Task]:
    """`task` as if it had only the options that its scene `changes` has, which is its only scene."""
    scene = resolve(task, changes)
    present = [name for name, option in scene.options.items() if option is not None]
    kernels = kernels_of(task)
    entries = [(k.py_func.__module__, k.py_func.__name__) for k in kernels]
    with stripped(entries, set(task.options) - set(present), list(task.options)) as made:
        yield dataclasses.replace(
            with_kernels(task, dict(zip(kernels, made, strict=True))),
            options={name: task.options[name] for name in present},
            scenes={scene.name: {k: v for k, v in scene.as_dict().items() if v is not None and k != "base"}},
            default_scene=scene.name,
            observation_channels=_constantly(task.observation_channels(scene)),
            action_channels=_constantly(task.action_channels(scene)),
            validate=_constantly(None),
            engines={},
            sensors=(),
            rivals=(),
        )


def _constantly(value: Any) -> Any:
    def of(_scene: Scene) -> Any:
        return value

    return of
