"""The arrows between packages go one way, and heavy libraries are imported only where they are used."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
# what a folder of the package may import from the package itself at module level
ALLOWED = {
    "models": {"models"},
    "envs": {"models", "envs"},
    "rigid_body": {"models", "envs", "rigid_body"},
    "controllers": {"models", "envs", "controllers"},
    "evaluation": {"models", "envs", "controllers", "evaluation"},
    "render": {"models", "envs", "render"},
    "experiments": {"models", "envs", "evaluation", "render", "experiments"},
    "bench": {"models", "envs", "controllers", "rigid_body", "evaluation", "render", "bench"},
    "cli": {"models", "envs", "controllers", "evaluation", "render", "bench", "experiments", "cli"},
}
LIBRARIES = {
    "models": {"math", "numpy", "numba", "llvmlite"},
    "envs": {"numpy", "gymnasium"},
    "rigid_body": {"numpy", "pymunk"},
    "controllers": {"numpy", "scipy"},
}
STANDARD = set(sys.stdlib_module_names)


def imports(path, top_level):
    """Modules that a file imports, at module level only or anywhere."""
    tree = ast.parse(path.read_text())
    nodes = tree.body if top_level else ast.walk(tree)
    guarded = [n for node in tree.body if isinstance(node, ast.If) for n in node.body]  # TYPE_CHECKING
    for node in nodes:
        if node in guarded:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


FILES = [path for folder in ALLOWED for path in sorted((ROOT / "vr_envs" / folder).rglob("*.py"))]


def folder_of(path):
    """The folder of the package that a file stands in, at any depth."""
    return path.relative_to(ROOT / "vr_envs").parts[0]


def name_of(path):
    return path.relative_to(ROOT / "vr_envs").as_posix()


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_arrows_go_one_way(path):
    for module in imports(path, top_level=True):
        parts = module.split(".")
        if parts[0] == "vr_envs" and len(parts) > 1:
            assert parts[1] in ALLOWED[folder_of(path)], f"{path.name} imports {module}"
        assert parts[0] not in ("agents", "torch", "stable_baselines3"), f"{path.name} imports {module}"


@pytest.mark.parametrize("path", [p for p in FILES if folder_of(p) in LIBRARIES], ids=name_of)
def test_lower_layers_know_few_libraries(path):
    known = LIBRARIES[folder_of(path)] | STANDARD | {"vr_envs"}
    for module in imports(path, top_level=False):
        assert module.split(".")[0] in known, f"{path.name} imports {module}"


def test_importing_the_package_is_light():
    """No heavy library, and nothing of the package but its root; counted, because time is noisy."""
    code = (
        "import sys, gymnasium; before = set(sys.modules); import vr_envs; "
        "print(*sorted(set(sys.modules) - before)); "
        "print(*sorted({'numba', 'scipy', 'pymunk', 'matplotlib', 'torch', 'pygame'} & set(sys.modules)))"
    )
    new, heavy = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )[:2]
    assert new.split() == ["vr_envs"]
    assert heavy == ""
