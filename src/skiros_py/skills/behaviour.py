"""The protocol of behaviours: what a skill's body, a tree, a net or a task graph is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import Condition, Pattern
from skiros_py.skills.conditions.watch import Watch
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Execution, Outcome

if TYPE_CHECKING:
    from skiros_py.skills.plain import Reader

_NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class P:
    """A value of this run: the skill's parameter of this key, the element of a loop, or what an :class:`Out` wrote."""

    key: str

    def __post_init__(self) -> None:
        check_texts("P", "the key of a parameter", self.key)


@dataclass(frozen=True, slots=True)
class Out:
    """Among the arguments of a call: the value of that key in its outcome is written under this name.

    Nodes that run later read it with :class:`P`: ``Do.of("locate", pose=Out("seen"))``, then
    ``Do.of("move_arm", pose=P("seen"))``.
    """

    name: str

    def __post_init__(self) -> None:
        check_texts("Out", "the name of a value", self.name)


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a module by name.

    Attributes:
        module: Name of a primitive or skill.
        arguments: Its parameters: constants, or :class:`P`; :class:`Out` for values of its outcome.
    """

    module: str
    arguments: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)

    @property
    def inputs(self) -> Mapping[str, Any]:
        """The arguments that the module is given."""
        return {key: value for key, value in self.arguments.items() if not isinstance(value, Out)}

    @property
    def outputs(self) -> Mapping[str, str]:
        """Under which name each value of its outcome is written."""
        return {key: value.name for key, value in self.arguments.items() if isinstance(value, Out)}


@dataclass(frozen=True, slots=True)
class Edge:
    """An arrow in the drawing of a behaviour.

    Attributes:
        source: Key of a child; empty for the behaviour itself.
        target: Key of a child; empty for the behaviour itself.
        label: What is written on it.
    """

    source: str
    target: str
    label: str = ""


@dataclass(frozen=True, slots=True)
class Uses:
    """What a behaviour uses itself, without its children: checks, planning and explanation read it.

    Attributes:
        calls: Modules that it calls.
        names: Values that it reads, by name, and which part of it does so ("the call of 'drive'").
        writes: Names under which it writes values.
        conditions: Conditions over the skill's parameters.
        patterns: Patterns over parameters, each with its place for messages.
        binds: Class of the element by the name under which its children read it.
        pretends: Keys of the postconditions that it writes without sensing, empty for all; None where it does not.
        concurrent: True where its children run at the same time.
        in_order: True where its children run one after the other, each at most once.
        needs: How many of its children must succeed so that it does.
    """

    calls: tuple[Call, ...] = ()
    names: tuple[tuple[str, str], ...] = ()
    writes: tuple[str, ...] = ()
    conditions: tuple[Condition, ...] = ()
    patterns: tuple[tuple[str, Pattern], ...] = ()
    binds: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    pretends: tuple[str, ...] | None = None
    concurrent: bool = False
    in_order: bool = False
    needs: Literal["all", "any", "none"] = "all"


_NO_USES = Uses()


class Scope(Protocol):
    """What a running behaviour may reach; the kernel makes one for each run of a node."""

    @property
    def context(self) -> RunContext:
        """World, devices, adapters, the run's clock."""

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The values of this run: parameters of the skill, elements of loops around, values that were written."""

    @property
    def path(self) -> str:
        """Path of this node, from the module that was started: ``pick/body/0/2``."""

    @property
    def author(self) -> str:
        """Name of the module that this node is part of."""

    def run(self, child: Behaviour, key: str, elements: Mapping[str, Any] = ...) -> Execution[Outcome]:
        """Returns the run of a child.

        Args:
            child: The child.
            key: Its key: the last part of its path.
            elements: Values that only this child and its descendants read, by name.
        """

    def call(self, call: Call) -> Execution[Outcome]:
        """Returns the run of a module; its outputs are written when it has succeeded."""

    def launch(self, call: Call) -> Outcome:
        """Starts a module that runs on beside the skill and after it; one that runs with these inputs stays."""

    def write(self, name: str, value: Any) -> None:
        """Writes a value that later nodes of the same skill read with ``P(name)``."""

    def emit(self, event: str, value: Any = None) -> None:
        """Announces a named event of this node, with a value as plain data."""

    def watch(self, conditions: Sequence[Condition]) -> Watch:
        """Watches conditions over parameters; close it."""

    def apart(self) -> AbstractContextManager[Scope]:
        """Gives a scope of its own to children that may be cancelled alone; see :meth:`recover`."""

    def recover(self) -> Execution[None]:
        """Runs the recovery of what was cancelled in this scope, under a time limit for all together."""


class Behaviour(ABC):
    """Something that takes time and is run node by node: a leaf that does something, or one made of others.

    A behaviour is immutable data; each run is a generator of its own. The kernel runs children through
    :meth:`Scope.run`, which gives each run an id and a path, reports its start and end, and obeys breakpoints;
    pausing and stepping act on the whole task.

    Class attributes:
        kind: Name of its entry point in the group ``skiros.behaviours``, and its type in plain data.
    """

    __slots__ = ()

    kind: ClassVar[str]

    @property
    @abstractmethod
    def title(self) -> str:
        """One line for people."""

    @abstractmethod
    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs it once; each ``yield`` waits for the next control cycle."""

    def named_children(self) -> Mapping[str, Behaviour]:
        """Returns its children by key, in the order in which they are drawn; keys contain no slash."""
        return _NO_CHILDREN

    def edges(self) -> Sequence[Edge]:
        """Returns the arrows between itself and its children; by default one to each child."""
        return tuple(Edge("", key) for key in self.named_children())

    def uses(self) -> Uses:
        """Returns what it uses itself, without its children."""
        return _NO_USES

    def to_data(self) -> dict[str, Any]:
        """Returns it as plain data that JSON can carry; by default the fields of a dataclass.

        Raises:
            DescriptionError: A part cannot be written down, such as a condition with a function.
        """
        from skiros_py.skills.plain import fields_as_data

        return {"type": self.kind, **fields_as_data(self)}

    @classmethod
    def from_data(cls, data: Mapping[str, Any], reader: Reader) -> Behaviour:
        """Makes one from plain data, by default by the fields of a dataclass.

        Args:
            data: What :meth:`to_data` returned.
            reader: Reads the values in it.

        Raises:
            DescriptionError: Something in it is wrong; the text names the place.
        """
        return reader.dataclass(cls, data)


_NO_CHILDREN: Mapping[str, Behaviour] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Node:
    """One node in the drawing of a behaviour.

    Attributes:
        path: Its path below the root: the root's own is given, a child's is ``{parent}/{key}``.
        behaviour: The behaviour.
    """

    path: str
    behaviour: Behaviour

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The arrows that it draws, with paths for keys."""
        return tuple(Edge(self._of(e.source), self._of(e.target), e.label) for e in self.behaviour.edges())

    def _of(self, key: str) -> str:
        return f"{self.path}/{key}" if key else self.path


def nodes_of(root: Behaviour, path: str) -> Iterator[Node]:
    """Yields a behaviour and all its descendants with their paths, from the top."""
    yield Node(path, root)
    for key, child in root.named_children().items():
        yield from nodes_of(child, f"{path}/{key}")


def walk(root: Behaviour) -> Iterator[Behaviour]:
    """Yields a behaviour and all its descendants, from the top."""
    yield from (node.behaviour for node in nodes_of(root, ""))


def check_nodes(root: Behaviour, path: str = "", where: str = "") -> None:
    """Looks whether a behaviour and all its descendants say what they are: title, children, arrows, uses.

    Args:
        root: The behaviour.
        path: Its path, for messages ("body").
        where: Whose it is, for messages ("of skill 'pick'").

    Raises:
        DescriptionError: A node does not; the text begins with its path.
    """
    what = f"{path or 'the root'} ({getattr(root, 'kind', type(root).__name__)}){where and f' {where}'}"

    def read(name: str, right: str, type_: type, given: Callable[[], Any]) -> Any:
        try:
            value = given()
        except Exception as error:
            raise DescriptionError(f"{what}: its {name} raises {type(error).__name__}: {error}") from error
        require(isinstance(value, type_), what, f"its {name} must be {right}", value)
        return value

    read("title", "a text", str, lambda: root.title)
    read("uses()", "Uses(…)", Uses, root.uses)
    children = read("named_children()", "behaviours by key", Mapping, root.named_children)
    for key, child in children.items():
        require(isinstance(key, str) and key != "" and "/" not in key, what, "the key of a child has no '/'", key)
        check_behaviour(what, child)
        check_nodes(child, f"{path}/{key}".lstrip("/"), where)
    for edge in read("edges()", "a sequence of Edge", tuple, lambda: tuple(root.edges())):
        require(isinstance(edge, Edge), what, "its edges() must be a sequence of Edge", edge)
        for end in (edge.source, edge.target):
            require(not end or end in children, what, "its edges() join itself ('') and its children", end)


def calls_of(*roots: Behaviour) -> Iterator[Call]:
    """Yields the calls in behaviours, from the top."""
    for root in roots:
        for node in walk(root):
            yield from node.uses().calls


def lines(root: Behaviour, indent: int = 0) -> list[str]:
    """Returns a tree as indented lines, for people."""
    own = "  " * indent + root.title
    return [own, *(line for child in root.named_children().values() for line in lines(child, indent + 1))]


def check_behaviour(what: str, behaviour: object) -> None:
    """Refuses what is no behaviour.

    Args:
        what: What it is part of, for messages ("retry").
        behaviour: The part.

    Raises:
        DescriptionError: It is none.
    """
    right = "it is made of nodes, given one by one, such as Do.of('drive')"
    require(isinstance(behaviour, Behaviour), what, right, behaviour)


def require(good: bool, what: str, right: str, given: object) -> None:
    """Refuses a wrong field of a node.

    Args:
        good: Whether it is right.
        what: The node, for messages ("retry").
        right: What would be right.
        given: What was given.

    Raises:
        DescriptionError: It is not right.
    """
    if not good:
        raise DescriptionError(f"{what}: {right}, not {given!r:.100}")


def check_texts(what: str, right: str, *texts: object) -> None:
    """Refuses values that are not texts, or empty."""
    for text in texts:
        require(isinstance(text, str) and text != "", what, right, text)
