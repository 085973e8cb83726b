"""Every module says what it exports, sorted, and exports all of its public names."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (ROOT / "src", ROOT / "primitives" / "src", ROOT / "skills" / "src")
MODULES = [file for package in PACKAGES for file in sorted(package.rglob("*.py"))]
OPEN_FOR_COMPOSITION = {"config.py": {"scene_paths"}, "session.py": {"open_world", "scene_title"}}
"""Public to their neighbours, not exported: each is reported to its author."""


def _name(file: Path) -> str:
    return next(str(file.relative_to(package)) for package in PACKAGES if file.is_relative_to(package))


def _exported(tree: ast.Module) -> list[str] | None:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            return list(ast.literal_eval(node.value))
    return None


def _registers(decorator: ast.expr) -> bool:
    return ast.unparse(decorator).startswith(("router.", "command.command"))


def _defined(tree: ast.Module) -> set[str]:
    """Names of public classes and functions that a module defines itself; decorators register commands and routes."""
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    found = (node for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_"))
    return {node.name for node in found if not any(_registers(d) for d in node.decorator_list)}


def _bound(tree: ast.Module) -> set[str]:
    names = _defined(tree)
    for node in ast.walk(tree):
        match node:
            case ast.Import(aliases) | ast.ImportFrom(_, aliases):
                names |= {(a.asname or a.name).partition(".")[0] for a in aliases}
            case ast.Assign(targets):
                names |= {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}
            case ast.AnnAssign(ast.Name(id)):
                names.add(id)
    return names


def _order(name: str) -> tuple[int, str]:
    """Constants, then classes, then functions: the order that ruff's RUF022 keeps."""
    return (0 if name.isupper() and len(name) > 1 else 1 if name[:1].isupper() else 2), name


@pytest.mark.parametrize("file", MODULES, ids=_name)
def test_a_module_that_defines_something_public_exports_all_of_it_and_nothing_else(file: Path) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    exported = _exported(tree)
    missing = _defined(tree) - set(exported or ()) - OPEN_FOR_COMPOSITION.get(file.name, set())

    assert not missing, f"{_name(file)} does not export {', '.join(sorted(missing))}"
    assert set(exported or ()) <= _bound(tree) | {"__version__"}


@pytest.mark.parametrize("file", MODULES, ids=_name)
def test_exports_are_sorted(file: Path) -> None:
    exported = _exported(ast.parse(file.read_text(encoding="utf-8"))) or []

    assert exported == sorted(exported, key=_order)
    assert len(exported) == len(set(exported))
