"""Files to be written from templates: all of them, or none; formatted as linters require."""

from __future__ import annotations

import ast
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from skiros_py.errors import UsageError
from skiros_py.world.scene.files import write_atomically

_WIDTH = 120


def render(template: str, **values: Any) -> str:
    """Fills in a template of this package.

    Args:
        template: Name of its file, without the suffix.
        **values: Its variables; none may be missing.
    """
    return _environment().get_template(f"{template}.j2").render(**values)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("skiros_py.scaffold"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # noqa: S701 - the output is code, not web pages
    )
    environment.filters |= {"literal": literal, "call": call, "imports": imports, "listed": listed}
    return environment


def literal(value: Any) -> str:
    """Writes a value as Python does, texts in double quotes."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple):
        inner = ", ".join(map(literal, value))
        return f"({inner},)" if len(value) == 1 else f"({inner})"
    return repr(value)


def call(arguments: Sequence[str], head: str, indent: int = 0, tail: str = ",") -> str:
    """Writes a call on one line, or with one argument a line where it is too long for that.

    Args:
        arguments: Its arguments as they are written.
        head: What stands before the bracket.
        indent: Blanks that stand before the head already.
        tail: What follows the call on its line.
    """
    line = f"{head}({', '.join(arguments)})"
    if indent + len(line) + len(tail) <= _WIDTH:
        return line + tail
    inner = "".join(f"{' ' * (indent + 4)}{argument},\n" for argument in arguments)
    return f"{head}(\n{inner}{' ' * indent}){tail}"


def listed(items: Sequence[str], head: str, indent: int = 0, tail: str = "") -> str:
    """Writes a tuple: on one line where it fits with what follows it there, or with one item a line."""
    line = f"{head}({', '.join(items)}{',' if len(items) == 1 else ''})"
    if indent + len(line) + len(tail) <= _WIDTH:
        return line
    inner = "".join(f"{' ' * (indent + 4)}{item},\n" for item in items)
    return f"{head}(\n{inner}{' ' * indent})"


def imports(pairs: Iterable[tuple[str, str]]) -> str:
    """Writes imports of (module, name), sorted as linters sort them."""
    names: dict[str, set[str]] = {}
    for module, name in pairs:
        names.setdefault(module, set()).add(name)
    return "\n".join(_import(module, sorted(names[module], key=_order)) for module in sorted(names))


def _import(module: str, names: Sequence[str]) -> str:
    line = f"from {module} import {', '.join(names)}"
    if len(line) <= _WIDTH:
        return line
    return f"from {module} import (\n" + "".join(f"    {name},\n" for name in names) + ")"


def _order(name: str) -> tuple[int, str]:
    """Constants, then classes, then functions."""
    return (0 if name.isupper() and len(name) > 1 else 1 if name[:1].isupper() else 2), name


def check_names(path: str, code: str) -> None:
    """Checks that a generated module does not define a name twice.

    Raises:
        UsageError: It does.
    """
    names = [name for node in ast.parse(code).body for name in _defined(node)]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"{path} would have two things called {twice}; choose another name")


def _defined(node: ast.stmt) -> list[str]:
    match node:
        case ast.ImportFrom():
            return [alias.name for alias in node.names]
        case ast.Assign():
            return [ast.unparse(target) for target in node.targets]
        case ast.ClassDef() | ast.FunctionDef():
            return [node.name]
        case _:
            return []


@dataclass(frozen=True, slots=True)
class Draft:
    """The files to be written below one folder.

    Attributes:
        root: The folder.
        new: Text of new files, by path below it.
        changed: Text of existing files, by path.
        notes: Notes for the author.
        copied: Files that are copied, by path.
    """

    root: Path
    new: Mapping[str, str] = field(default_factory=dict)
    changed: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    copied: Mapping[str, Path] = field(default_factory=dict)

    def check(self) -> None:
        """Checks that everything can be written.

        Raises:
            UsageError: A file already exists, or there is no folder to write to.
        """
        there = [path for path in (*self.new, *self.copied) if os.path.lexists(self.root / path)]
        if there:
            raise UsageError(f"{', '.join(there)}: there already below {self.root}, and nothing is overwritten")

    def write(self) -> None:
        """Writes the new files first, so that changed files never refer to missing ones.

        Missing folders are created. A new root is renamed from a temporary folder: it is there as a whole, or not.

        Raises:
            UsageError: A file already exists, or cannot be written; nothing was changed.
            FileError: An existing file cannot be changed; nothing was changed.
        """
        self.check()
        written: list[Path] = []
        try:
            if not self.root.exists():
                self.root.parent.mkdir(parents=True, exist_ok=True)
                with tempfile.TemporaryDirectory(prefix=".skiros-new-", dir=self.root.parent) as folder:
                    (inner := Path(folder) / self.root.name).mkdir()
                    replace(self, root=inner).write()
                    inner.rename(self.root)
                return
            for path, text in self.new.items():
                _write_new(self.root / path, text, written)
            for path, file in self.copied.items():
                _write_new(self.root / path, file.read_bytes(), written)
            for path, text in self.changed.items():
                write_atomically(self.root / path, text)
        except BaseException as error:
            _undo(written)
            if isinstance(error, OSError):
                raise UsageError(f"{error.filename}: cannot be written ({error.strerror}); nothing was") from error
            raise


def _write_new(path: Path, content: str | bytes, written: list[Path]) -> None:
    for folder in reversed([f for f in path.parents if not f.exists()]):
        folder.mkdir()
        written.append(folder)
    with path.open("xb") as file:
        written.append(path)
        file.write(content.encode() if isinstance(content, str) else content)


def _undo(written: list[Path]) -> None:
    for path in reversed(written):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
