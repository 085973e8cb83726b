"""A skill's body as data: the same tree is run, shown live and exported."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from skiros_py.skills.conditions import Condition, Pattern
from skiros_py.skills.made_of import check_conditions, check_seconds, check_texts, check_times, require
from skiros_py.skills.parameters import IT

__all__ = [
    "AssertEffects",
    "Check",
    "Do",
    "Fallback",
    "ForEach",
    "Guard",
    "Node",
    "P",
    "Parallel",
    "Policy",
    "Repeat",
    "Retry",
    "Sequence",
    "Timeout",
    "Wait",
    "check_node",
    "children_of",
    "lines",
    "walk",
]


@dataclass(frozen=True, slots=True)
class P:
    """The value that the skill's parameter of this key has in this run, or the element a :class:`ForEach` is at."""

    key: str

    def __post_init__(self) -> None:
        check_texts("P", "the key of a parameter", self.key)


@dataclass(frozen=True, slots=True)
class Do:
    """Runs a module: a primitive, or another skill whose unspecified parameters are inferred when its turn comes.

    Attributes:
        module: Its name.
        arguments: Its parameters: constants, or :class:`P` for a parameter of the skill. The key is the module's own
            name for it, so parameters are renamed on the way: ``Do.of("pick", Object=P("Part"))``.
    """

    module: str
    arguments: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        check_texts("do", "the name of a module", self.module)
        require(isinstance(self.arguments, Mapping), "do", "its arguments by key", self.arguments)

    @classmethod
    def of(cls, module: str, **arguments: Any) -> Do:
        """Makes one: ``Do.of("locate", camera=P("Camera"), place=P("Container"))``."""
        return cls(module, MappingProxyType(arguments))


@dataclass(frozen=True, slots=True)
class Sequence:
    """One after the other; the first failure ends it."""

    children: tuple[Node, ...]

    def __post_init__(self) -> None:
        _check_parts("sequence", self.children)

    @classmethod
    def of(cls, *children: Node) -> Sequence:
        """Makes one."""
        return cls(children)


@dataclass(frozen=True, slots=True)
class Fallback:
    """One after the other until one succeeds."""

    children: tuple[Node, ...]

    def __post_init__(self) -> None:
        _check_parts("fallback", self.children)

    @classmethod
    def of(cls, *children: Node) -> Fallback:
        """Makes one."""
        return cls(children)


class Policy(enum.Enum):
    """When a :class:`Parallel` is over; what still runs then is broken off and makes up for it."""

    FIRST_FAILURE = "first failure"
    """With the first failure, or when all have succeeded."""
    FIRST_SUCCESS = "first success"
    """With the first success, or when all have failed."""
    ALL = "all"
    """When all have ended; a failure among them is its failure."""


@dataclass(frozen=True, slots=True)
class Parallel:
    """All at the same time, in this order within each cycle."""

    children: tuple[Node, ...]
    policy: Policy = Policy.FIRST_FAILURE

    def __post_init__(self) -> None:
        _check_parts("parallel", self.children)
        require(isinstance(self.policy, Policy), "parallel", "a policy such as Policy.ALL", self.policy)

    @classmethod
    def of(cls, *children: Node, policy: Policy = Policy.FIRST_FAILURE) -> Parallel:
        """Makes one."""
        return cls(children, policy)


@dataclass(frozen=True, slots=True)
class Retry:
    """The child again, until it succeeds or was tried so many times."""

    child: Node
    times: int

    def __post_init__(self) -> None:
        check_node("retry", self.child)
        check_times("retry", self.times)


@dataclass(frozen=True, slots=True)
class Repeat:
    """The child again and again, so many times, until it fails.

    Attributes:
        child: What is repeated.
        times: How often; None for until it fails or is broken off.
    """

    child: Node
    times: int | None = None

    def __post_init__(self) -> None:
        check_node("repeat", self.child)
        if self.times is not None:
            check_times("repeat", self.times)


@dataclass(frozen=True, slots=True)
class Timeout:
    """The child, broken off with a failure when it takes longer than so many seconds of run time."""

    child: Node
    seconds: float

    def __post_init__(self) -> None:
        check_node("timeout", self.child)
        check_seconds("timeout", self.seconds)
        require(self.seconds > 0.0, "timeout", "a time above 0 s", self.seconds)


@dataclass(frozen=True, slots=True)
class Guard:
    """The child, as long as the conditions hold; broken off with a failure as soon as one does not.

    Attributes:
        child: What is guarded.
        conditions: Over the skill's parameters, like those of its description; sensor conditions are seen each cycle.
    """

    child: Node
    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        check_node("guard", self.child)
        check_conditions("guard", self.conditions)

    @classmethod
    def of(cls, child: Node, *conditions: Condition) -> Guard:
        """Makes one."""
        return cls(child, conditions)


@dataclass(frozen=True, slots=True)
class ForEach:
    """The child once for each element that a query finds when its turn comes, in the order of their ids.

    Attributes:
        key: Name by which the child refers to the element: ``P(key)``; no parameter of the skill has it.
        class_: Class of the elements.
        child: What is done; its first failure ends it.
        where: What must hold of an element, which is called ``it`` there or by its ``key``, and of the skill's
            parameters; None for every one of the class.
    """

    key: str
    class_: str
    child: Node
    where: Pattern | None = None

    def __post_init__(self) -> None:
        check_texts("for each", "the name of its element, then a class such as sk:Box", self.key, self.class_)
        require(":" in self.class_, "for each", "a class such as sk:Box", self.class_)
        check_node("for each", self.child)
        if self.where is not None:
            is_pattern = hasattr(self.where, "rename") and hasattr(self.where, "evaluate")
            require(is_pattern, "for each", "where is a pattern such as Nothing('sk:in', 'it')", self.where)
            object.__setattr__(self, "where", self.where.rename({IT: self.key}))


@dataclass(frozen=True, slots=True)
class Check:
    """Succeeds where the conditions hold, else fails with the reason; takes no time."""

    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        check_conditions("check", self.conditions)

    @classmethod
    def of(cls, *conditions: Condition) -> Check:
        """Makes one."""
        return cls(conditions)


@dataclass(frozen=True, slots=True)
class Wait:
    """Lets so many seconds of run time pass."""

    seconds: float

    def __post_init__(self) -> None:
        check_seconds("wait", self.seconds)


@dataclass(frozen=True, slots=True)
class AssertEffects:
    """Writes postconditions of the skill into the world after a while. Only fakes may do this.

    Attributes:
        seconds: How long the pretended work takes.
        only: Keys of the postconditions to write (:attr:`Condition.key`); all of them where left out.
    """

    seconds: float = 1.0
    only: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_seconds("assert effects", self.seconds)
        require(isinstance(self.only, tuple), "assert effects", "a tuple of keys such as ('held',)", self.only)
        check_texts("assert effects", "the key of a postcondition", *self.only)


Node = Do | Sequence | Fallback | Parallel | Retry | Repeat | Timeout | Guard | ForEach | Check | Wait | AssertEffects


def check_node(what: str, node: object) -> None:
    """Looks whether something that a body is made of is a node.

    Args:
        what: Whose part it is, for messages ("retry").
        node: The part.

    Raises:
        DescriptionError: It is none.
    """
    require(isinstance(node, Node), what, "it is made of nodes, given one by one, such as Do.of('drive')", node)


def _check_parts(what: str, children: tuple[Node, ...]) -> None:
    require(isinstance(children, tuple), what, "its parts are a tuple", children)
    require(bool(children), what, "at least one part: with none, nobody knows whether it has worked", children)
    for child in children:
        check_node(what, child)


def children_of(node: Node) -> tuple[Node, ...]:
    """Returns what a node is composed of."""
    match node:
        case Sequence(children) | Fallback(children) | Parallel(children):
            return children
        case Retry(child) | Repeat(child) | Timeout(child) | Guard(child) | ForEach(_, _, child):
            return (child,)
        case _:
            return ()


def walk(node: Node) -> Iterator[Node]:
    """Yields a node and all below it, from the top."""
    yield node
    for child in children_of(node):
        yield from walk(child)


def lines(node: Node, indent: int = 0) -> list[str]:
    """Returns the tree as indented lines."""
    own = "  " * indent + _title(node)
    return [own, *(line for child in children_of(node) for line in lines(child, indent + 1))]


def _title(node: Node) -> str:
    match node:
        case Do(module, arguments):
            shown = ", ".join(f"{k}={v.key if isinstance(v, P) else v}" for k, v in arguments.items())
            return f"{module}({shown})"
        case Parallel(_, policy):
            return f"parallel, until {_UNTIL[policy]}"
        case Guard(_, conditions):
            return f"while {_all(conditions)}"
        case ForEach(key, class_):
            return f"for each {key} of {class_.partition(':')[2] or class_}{' that fits' if node.where else ''}"
        case Check(conditions):
            return f"check {_all(conditions)}"
        case _:
            return _plain_title(node)


def _plain_title(node: Sequence | Fallback | Retry | Repeat | Timeout | Wait | AssertEffects) -> str:
    match node:
        case Sequence():
            return "sequence"
        case Fallback():
            return "fallback"
        case Retry(_, times):
            return f"retry, at most {times} times"
        case Repeat(_, times):
            return "repeat until it fails" if times is None else f"repeat {times} times"
        case Timeout(_, seconds):
            return f"within {seconds:g} s"
        case Wait(seconds):
            return f"wait {seconds:g} s"
        case AssertEffects(seconds, only):
            return f"pretend for {seconds:g} s{': ' + ', '.join(only) if only else ''}"


_UNTIL = {
    Policy.FIRST_FAILURE: "one fails",
    Policy.FIRST_SUCCESS: "one succeeds",
    Policy.ALL: "all have ended",
}


def _all(conditions: tuple[Condition, ...]) -> str:
    return " and ".join(map(str, conditions))
