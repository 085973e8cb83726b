"""The code of primitives: it yields, never blocks, imports only the public API, and pretends only in fakes."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from skiros_py.skills.behaviour import walk
from skiros_py.skills.lint.rule import Known, Problem, Severity, Source, rule
from skiros_py.skills.primitive import Primitive, generator_problem
from skiros_py.skills.skill import Skill


@rule("motion-in-finally", "Motion in the cleanup of a primitive, which must take no time.", Source)
def motion_in_finally(source: Source, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    """Yields motion in code that runs when a primitive is stopped."""
    for what, body in _endings(source.tree) if source.has_primitives else ():
        for node in _own_nodes(body):
            if moves := _moves(node):
                text = f"{moves} in {what}: stopping must be instantaneous; motion that must follow goes into recover()"
                yield text, node.lineno


def _endings(tree: ast.AST) -> Iterator[tuple[str, list[ast.stmt]]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Try | ast.TryStar) and node.finalbody:
            yield "finally", node.finalbody
        elif isinstance(node, ast.ExceptHandler) and node.type is not None and _catches_exit(node.type):
            yield "except GeneratorExit", node.body


def _catches_exit(type_: ast.expr) -> bool:
    return any(isinstance(n, ast.Name) and n.id in ("GeneratorExit", "BaseException") for n in ast.walk(type_))


def _own_nodes(body: Iterable[ast.AST]) -> Iterator[ast.expr]:
    """Yields the expressions of statements, without those of functions that are only defined there."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.expr):
            yield node
        yield from _own_nodes(ast.iter_child_nodes(node))


def _moves(node: ast.expr) -> str:
    match node:
        case ast.Yield() | ast.YieldFrom():
            return "a yield"
        case ast.Call(func=ast.Attribute(attr="command")):
            return "a command to a device"
        case ast.Call(func=ast.Attribute(value=ast.Name(id="self"), attr="call")):
            return "a call of another module"
        case _:
            return ""


@rule("yield-never", "A primitive whose execute is not a generator.", type)
def yield_never(primitive: type[Primitive[object]], known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields a problem where execute is no generator."""
    if problem := generator_problem(primitive.execute):
        yield f"execute {problem}"


@rule("blocking-call", "A call that blocks the control cycle.", Source)
def blocking_call(source: Source, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    """Yields calls in primitives that wait."""
    for node in ast.walk(source.tree) if source.has_primitives else ():
        if isinstance(node, ast.Call):
            name = source.dotted(node.func)
            if name in _BLOCKING or name.startswith(_BLOCKING_MODULES):
                yield f"{name}() blocks the control cycle of all robots; {_INSTEAD.get(name, _WORKER)}", node.lineno


_BLOCKING = frozenset({"time.sleep", "input", "os.system", "os.wait", "os.waitpid", "select.select", "signal.pause"})
_BLOCKING_MODULES = ("subprocess.", "requests.", "httpx.", "urllib.request.", "socket.create_connection", "asyncio.run")


_INSTEAD = {
    "time.sleep": "write yield from self.context.sleep(seconds)",
    "input": "ask by self.context.questions",
}
_WORKER = "let a worker do it and wait for its answer by self.wait(pending)"


@rule("placeholder", "Code as `skiros new` wrote it, which does nothing yet.", Source, severity=Severity.WARNING)
def placeholder(source: Source, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    """Yields primitives and skills that still do what the scaffold wrote: wait, and assert their effects."""
    for node in ast.walk(source.tree):
        if isinstance(node, ast.ClassDef):
            lines = [c.lineno for c in ast.walk(node) if isinstance(c, ast.Constant) and c.value == _PLACEHOLDER]
            if lines:
                yield f"{node.name} does nothing yet but assert its effects: let it command and ask a device", lines[0]


_PLACEHOLDER = "assumed: no device was asked yet"

_PACKAGE = "skiros_py"
_OPEN = frozenset(
    {
        "authoring",
        "behaviours",
        "devices",
        "errors",
        "geometry",
        "messages",
        "ports",
        "skills",
        "testing",
        "world",
        "workers",
        "__version__",
    }
)
"""What plug-ins may import; and, of the package itself, the few names it offers."""
_PORTS = ("skiros_py.planning.planners.planner",)
"""Ports that lie elsewhere."""
_PACKAGES = ("skiros_py.recording",)
"""Of these, plug-ins may import what the package itself lists, not its modules."""


@rule("private-import", "An import of an internal module, which may change at any time.", Source)
def private_import(source: Source, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    """Yields imports of modules that are not for plug-ins."""
    for node in ast.walk(source.tree):
        for name in _imported(node):
            is_open = name.split(".")[1] in _OPEN or name.startswith(_PORTS) or name in _PACKAGES
            if not is_open:
                yield f"it imports {name}, which may change at any time; use {_DOORS}", getattr(node, "lineno", 1)


_DOORS = (
    "skiros_py.authoring, .skills, .behaviours, .devices, .ports, .world, .geometry, .messages, .recording, .errors"
    " (and .testing in tests)"
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


@rule("pretends", "A skill for a real robot asserts effects without sensing them.", Skill, disables=True)
def pretends(skill: Skill, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields a problem where a skill that is not for the fake writes effects without sensing them."""
    if skill.driver == "fake":
        return
    if any(node.uses().pretends is not None for root in skill.nodes for node in walk(root)):
        said = "every driver" if skill.driver is None else f"driver '{skill.driver}'"
        yield (
            f"it is for {said} and asserts effects without sensing them: only skills for driver 'fake' may; let the "
            "primitive that senses an effect call self.assert_effects(…)"
        )
