"""The code of primitives: it yields, never blocks, imports only the public API, and pretends only in fakes."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterable, Iterator

from skiros_py.skills.behaviour import walk
from skiros_py.skills.lint.rule import Known, Problem, Rule, Severity, Source, Spot, Subject
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill


def _motion(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, Source) or not subject.has_primitives:
        return
    for what, body in _endings(subject.tree):
        for node in _own_nodes(body):
            moves = _moves(node)
            if moves:
                text = f"{moves} in {what}: stopping must be instantaneous; motion that must follow goes into recover()"
                yield Problem(text, Spot(subject.file, node.lineno))


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


def _never(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, type) or not issubclass(subject, Primitive):
        return
    if inspect.isgeneratorfunction(subject.execute) or _hands_on(subject):
        return
    if inspect.iscoroutinefunction(subject.execute) or inspect.isasyncgenfunction(subject.execute):
        yield Problem("execute must be a plain generator, not async: each yield waits for the next control cycle")
        return
    yield Problem("execute never yields, so it is no generator: each yield waits for the next control cycle")


def _hands_on(primitive: type[Primitive[object]]) -> bool:
    """Tells whether execute returns what another method makes (``return self.call(…)``), which may be a generator."""
    if getattr(primitive.execute, "__isabstractmethod__", False):
        return True
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(primitive.execute)))
    except (OSError, TypeError, SyntaxError):
        return True  # nothing is known of it
    returned = [node.value for node in ast.walk(tree) if isinstance(node, ast.Return)]
    return any(isinstance(v, ast.Call) and isinstance(v.func, ast.Attribute) for v in returned)


def _blocks(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, Source) or not subject.has_primitives:
        return
    for node in ast.walk(subject.tree):
        if isinstance(node, ast.Call) and _is_blocking(subject.dotted(node.func)):
            name = subject.dotted(node.func)
            text = f"{name}() stops the control cycle of the whole robot; {_instead(name)}"
            yield Problem(text, Spot(subject.file, node.lineno))


_BLOCKING = frozenset({"time.sleep", "input", "os.system", "os.wait", "os.waitpid", "select.select", "signal.pause"})
_BLOCKING_MODULES = ("subprocess.", "requests.", "httpx.", "urllib.request.", "socket.create_connection", "asyncio.run")


def _is_blocking(name: str) -> bool:
    return name in _BLOCKING or name.startswith(_BLOCKING_MODULES)


def _instead(name: str) -> str:
    if name == "time.sleep":
        return "yield until self.context.now has come that far"
    if name == "input":
        return "ask by self.context.questions"
    return "let a worker do it and wait for its answer by self.wait(pending)"


MOTION_IN_FINALLY = Rule("motion-in-finally", Severity.ERROR, "Motion where a primitive must only let go.", _motion)
YIELD_NEVER = Rule("yield-never", Severity.ERROR, "A primitive that is no generator.", _never)
BLOCKING_CALL = Rule("blocking-call", Severity.ERROR, "A call that stops the control cycle.", _blocks)


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


def _pretended(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    if not isinstance(subject, Skill) or subject.driver == "fake":
        return
    if any(node.uses().pretends is not None for root in subject.nodes for node in walk(root)):
        said = "every driver" if subject.driver is None else f"driver '{subject.driver}'"
        yield Problem(
            f"it is for {said} and asserts effects without sensing them: only skills for driver 'fake' may; let the "
            "primitive that senses an effect call self.assert_effects(…)"
        )


PRETENDS = Rule(
    "pretends", Severity.ERROR, "A skill for a real robot asserts effects without sensing them.", _pretended, True
)
