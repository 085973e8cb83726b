"""A name without an underscore is public; packages, and modules that hand on names of others, list what they export."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (ROOT / "src", ROOT / "primitives" / "src", ROOT / "skills" / "src")
MODULES = [file for package in PACKAGES for file in sorted(package.rglob("*.py"))]


def _name(file: Path) -> str:
    return next(str(file.relative_to(package)) for package in PACKAGES if file.is_relative_to(package))


def _exported(tree: ast.Module) -> list[str] | None:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            return list(ast.literal_eval(node.value))
    return None


def _own(tree: ast.Module) -> set[str]:
    """Names that a module defines itself."""
    names = set()
    for node in tree.body:
        match node:
            case ast.ClassDef(name) | ast.FunctionDef(name) | ast.AsyncFunctionDef(name):
                names.add(name)
            case ast.Assign(targets):
                names |= {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}
            case ast.AnnAssign(ast.Name(id)):
                names.add(id)
    return names


def _imported(tree: ast.Module) -> set[str]:
    imports = (node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom))
    return {(a.asname or a.name).partition(".")[0] for node in imports for a in node.names}


@pytest.mark.parametrize("file", MODULES, ids=_name)
def test_export_lists_are_sorted_and_exist_only_where_underscores_do_not_suffice(file: Path) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    exported = _exported(tree)
    if exported is None:
        return

    assert set(exported) <= _own(tree) | _imported(tree)
    assert exported == sorted(set(exported), key=_order)
    assert file.name == "__init__.py" or set(exported) - _own(tree), f"{_name(file)}: the list repeats its names"


def _order(name: str) -> tuple[int, str]:
    """Constants, then classes, then functions: the order that ruff's RUF022 keeps."""
    return (0 if name.isupper() and len(name) > 1 else 1 if name[:1].isupper() else 2), name
