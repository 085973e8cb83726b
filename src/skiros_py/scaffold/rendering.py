"""Fills in templates; the output is formatted as linters require."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

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


def listed(items: Sequence[str], head: str, indent: int = 0) -> str:
    """Writes a tuple: one of a single item on one line where it fits, any other with one item a line."""
    line = f"{head}({items[0]},),"
    if len(items) == 1 and indent + len(line) <= _WIDTH:
        return line
    inner = "".join(f"{' ' * (indent + 4)}{item},\n" for item in items)
    return f"{head}(\n{inner}{' ' * indent}),"


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
