"""A skill's body as data: the same tree is run, shown live and exported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from skiros_py.errors import DescriptionError

__all__ = ["AssertEffects", "Do", "Fallback", "Node", "P", "Retry", "Sequence", "lines"]


@dataclass(frozen=True, slots=True)
class P:
    """The value that the skill's parameter of this key has in this run."""

    key: str


@dataclass(frozen=True, slots=True)
class Do:
    """Runs a primitive.

    Attributes:
        primitive: Its name.
        arguments: Its parameters: constants, or :class:`P` for a parameter of the skill.
    """

    primitive: str
    arguments: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def of(cls, primitive: str, **arguments: Any) -> Do:
        """Makes one: ``Do.of("locate", camera=P("Camera"), place=P("Container"))``."""
        return cls(primitive, MappingProxyType(arguments))


@dataclass(frozen=True, slots=True)
class Sequence:
    """One after the other; the first failure ends it."""

    children: tuple[Node, ...]

    @classmethod
    def of(cls, *children: Node) -> Sequence:
        """Makes one."""
        return cls(children)


@dataclass(frozen=True, slots=True)
class Fallback:
    """One after the other until one succeeds."""

    children: tuple[Node, ...]

    @classmethod
    def of(cls, *children: Node) -> Fallback:
        """Makes one."""
        return cls(children)


@dataclass(frozen=True, slots=True)
class Retry:
    """The child again, until it succeeds or was tried so many times."""

    child: Node
    times: int

    def __post_init__(self) -> None:
        if self.times < 1:
            raise DescriptionError(f"retry: at least once, not {self.times} times")


@dataclass(frozen=True, slots=True)
class AssertEffects:
    """Writes all postconditions of the skill into the world after a while. Only fakes may do this.

    Attributes:
        seconds: How long the pretended work takes.
    """

    seconds: float = 1.0


Node = Do | Sequence | Fallback | Retry | AssertEffects


def lines(node: Node, indent: int = 0) -> list[str]:
    """Returns the tree as indented lines."""
    own = "  " * indent + _title(node)
    if isinstance(node, Sequence | Fallback):
        return [own, *(line for child in node.children for line in lines(child, indent + 1))]
    if isinstance(node, Retry):
        return [own, *lines(node.child, indent + 1)]
    return [own]


def _title(node: Node) -> str:
    match node:
        case Do(primitive, arguments):
            shown = ", ".join(f"{k}={v.key if isinstance(v, P) else v}" for k, v in arguments.items())
            return f"{primitive}({shown})"
        case Retry(_, times):
            return f"retry, at most {times} times"
        case AssertEffects(seconds):
            return f"pretend for {seconds:g} s"
        case Sequence():
            return "sequence"
        case Fallback():
            return "fallback"
