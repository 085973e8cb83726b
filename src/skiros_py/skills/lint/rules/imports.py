"""Plug-ins use the door: what authors may rely on is skills, world, robot ports and geometry."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from skiros_py.skills.lint.rule import Problem, Rule, Severity, Spot
from skiros_py.skills.lint.subject import Known, Source, Subject

_PACKAGE = "skiros_py"
_OPEN = frozenset(
    {"behaviours", "devices", "errors", "geometry", "ports", "skills", "testing", "world", "workers", "__version__"}
)
"""What plug-ins may import; and, of the package itself, the few names it offers."""
_PORTS = ("skiros_py.planning.planners.planner",)
"""Ports that lie elsewhere."""
_PACKAGES = ("skiros_py.recording",)
"""Of these, plug-ins may import what the package itself lists, not its modules."""


def _private(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, Source):
        return
    for node in ast.walk(subject.tree):
        for name in _imported(node):
            if not _is_open(name):
                text = f"it imports {name}, which may change at any time; use {_DOORS}"
                yield Problem(text, Spot(subject.file, getattr(node, "lineno", 1)))


_DOORS = (
    "skiros_py.skills, .behaviours, .devices, .ports, .world, .geometry, .recording, .errors (and .testing in tests)"
)


def _imported(node: ast.AST) -> Iterator[str]:
    """Yields the modules of the platform that a statement imports."""
    match node:
        case ast.Import(names=names):
            yield from (alias.name for alias in names if alias.name.startswith(f"{_PACKAGE}."))
        case ast.ImportFrom(module="skiros_py", names=names, level=0):
            yield from (f"{_PACKAGE}.{alias.name}" for alias in names if alias.name[:1].islower())
        case ast.ImportFrom(module=str(module), level=0) if module.startswith(f"{_PACKAGE}."):
            yield module
        case _:
            pass


def _is_open(name: str) -> bool:
    return name.split(".")[1] in _OPEN or name.startswith(_PORTS) or name in _PACKAGES


PRIVATE_IMPORT = Rule(
    "private-import", Severity.ERROR, "An import of the platform's inside, which may change at any time.", _private
)
