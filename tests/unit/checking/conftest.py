from __future__ import annotations

import ast
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

Package = Callable[[str], Path]

_NUMBERS = itertools.count(1)


def entry_points(code: str) -> Iterator[tuple[str, str, str]]:
    """Yields (group, name, object) for the skills, conditions and primitives that a module defines."""
    for node in ast.parse(code).body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Call(func=ast.Name(id="Skill" | "pretend"))):
                yield "skiros.skills", name.lower(), name
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Call(func=ast.Name(id="ConditionType"))):
                yield "skiros.conditions", name, name
            case ast.ClassDef(name=name, body=body):
                named = (n for n in body if isinstance(n, ast.AnnAssign) and getattr(n.target, "id", "") == "name")
                yield from (("skiros.primitives", ast.literal_eval(n.value), name) for n in named if n.value)
            case _:
                pass


@pytest.fixture
def package(tmp_path: Path) -> Package:
    """Writes a package with one module, and entry points for all that it defines; returns its folder."""

    def write(code: str) -> Path:
        name = f"checked_{next(_NUMBERS)}"  # modules stay imported: each needs a name of its own
        folder = tmp_path / name
        (folder / "src").mkdir(parents=True)
        (folder / "src" / f"{name}.py").write_text(code, encoding="utf-8")
        groups: dict[str, list[str]] = {}
        for group, key, attribute in entry_points(code):
            groups.setdefault(group, []).append(f'{key} = "{name}:{attribute}"')
        tables = [f'[project.entry-points."{group}"]\n' + "\n".join(points) for group, points in groups.items()]
        head = f'[project]\nname = "{name}"\nversion = "1.2"\ndependencies = ["skiros-py"]\n'
        (folder / "pyproject.toml").write_text("\n".join([head, *tables]) + "\n", encoding="utf-8")
        return folder

    return write
