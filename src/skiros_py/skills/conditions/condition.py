"""Conditions: named patterns in the words of the domain, over a skill's parameters or over elements."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from skiros_py.errors import DescriptionError
from skiros_py.interruptions import Interruption
from skiros_py.skills.conditions.compare import Compare
from skiros_py.skills.conditions.pattern import AllOf, Binding, Exists, Not, Pattern
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.element import Element, is_abstract
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Role:
    """One argument of a condition: its name and the class that may fill it."""

    name: str
    class_: str


@dataclass(frozen=True, slots=True)
class ConditionType:
    """A word of the domain: "RobotAtLocation", "InKit". Calling it with argument names makes a condition.

    Attributes:
        name: The word.
        roles: Its arguments, in order; the pattern's free variables are their names.
        pattern: What it means.
        help: One sentence for people.
        abstract: True when a goal may give a class instead of an element ("any starter").
    """

    name: str
    roles: tuple[Role, ...]
    pattern: Pattern
    help: str
    abstract: bool = False

    def __call__(self, *arguments: str) -> Condition:
        """Applies it to a skill's parameter keys, to element ids, or (where abstract) to classes.

        Raises:
            DescriptionError: Wrong number of arguments.
        """
        if len(arguments) != len(self.roles):
            expected = ", ".join(role.name for role in self.roles)
            raise DescriptionError(f"{self.name} takes ({expected}), got ({', '.join(arguments)})")
        return Condition(self, arguments)


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition type applied to arguments; ``~condition`` is its negation.

    Attributes:
        type: The word.
        arguments: Parameter keys in a skill; element ids or class CURIEs in a goal.
        negated: True when it must *not* hold.
        name: What its author calls it, or None; conditions that say the same are equal, whatever they are called.
    """

    type: ConditionType
    arguments: tuple[str, ...]
    negated: bool = False
    name: str | None = field(default=None, compare=False)

    def __invert__(self) -> Condition:
        return replace(self, negated=not self.negated, name=None)

    def named(self, name: str) -> Condition:
        """Returns the same condition under a name of the author's: ``HOLDING("Gripper", "Object").named("held")``.

        Raises:
            DescriptionError: The name is empty.
        """
        if not name.strip():
            raise DescriptionError(f"the name of {self} must not be empty")
        return replace(self, name=name)

    @property
    def key(self) -> str:
        """The name that tells it apart from a skill's other conditions: its author's, else its text."""
        return str(self) if self.name is None else self.name

    def __str__(self) -> str:
        return self.written(_short)

    def written(self, naming: Callable[[str], str]) -> str:
        """Returns it as text, as goals are written.

        Args:
            naming: How an argument or a class is written.
        """
        return f"{'not ' if self.negated else ''}{self.type.name}({', '.join(map(naming, self.arguments))})"

    @property
    def names(self) -> tuple[str, ...]:
        """Everything it speaks of: its arguments, and the classes over which its quantifiers range."""
        return self.arguments

    @property
    def pattern(self) -> Pattern:
        """Its pattern, over its arguments."""
        return Not(self._positive) if self.negated else self._positive

    @property
    def _positive(self) -> Pattern:
        names = {role.name: argument for role, argument in zip(self.type.roles, self.arguments, strict=True)}
        return self.type.pattern.rename(names)

    def closed_pattern(self, ontology: Ontology) -> Pattern:
        """Its pattern with a quantifier for each abstract argument: "there is a starter such that ..."."""
        pattern = self._closed(ontology)
        return Not(pattern) if self.negated else pattern

    def _closed(self, ontology: Ontology) -> Pattern:
        pattern = self._positive
        for argument in dict.fromkeys(self.arguments):
            pattern = some_such(argument, pattern, ontology, described=self.type.abstract)
        return pattern

    def bind(self, binding: Mapping[str, str]) -> Condition:
        """Replaces parameter keys by the ids they are bound to."""
        return replace(self, arguments=tuple(binding.get(argument, argument) for argument in self.arguments))

    def evaluate(self, view: WorldView, binding: Binding | None = None) -> Verdict:
        """Tells whether it holds.

        Args:
            view: The world as believed, a snapshot, or an overlay.
            binding: Element ids by parameter key; None when the arguments are ids or classes already.
        """
        grounded = self.bind(binding) if binding else self
        gone = [a for a in grounded.arguments if a not in view.ontology.classes and not view.has(a)]
        if gone:
            return Verdict(self.negated, str(grounded), (Verdict(False, f"there is no {' and no '.join(gone)}"),))
        pattern = grounded.closed_pattern(view.ontology)
        try:
            inner = pattern.evaluate(view, {argument: argument for argument in grounded.arguments})
        except BaseException as error:
            error.add_note(f"in condition {grounded}")
            raise
        return Verdict(inner.holds, str(grounded), (inner,))


def _short(name: str) -> str:
    return name.partition(":")[2] or name


def some_such(name: str, pattern: Pattern, ontology: Ontology, *, described: bool) -> Pattern:
    """Returns "there is something such that ...", where an argument is a class or an individual of the ontology.

    An individual describes things: whatever is of its class and has its own texts, numbers and truth values. Poses and
    sizes are no description of others.

    Args:
        name: The argument; any but an abstract one stands for itself.
        pattern: What is said of it.
        ontology: Tells what is abstract.
        described: Whether an individual describes things; else it is meant itself (a material, a maker).
    """
    if name in ontology.classes:
        return Exists(name, name, pattern)
    if not described or not is_abstract(name) or name not in ontology.individuals:
        return pattern
    element = abstract_individuals(ontology, NO_REASONERS).element(name)
    return Exists(name, element.type, AllOf((*_described(element), pattern)))


def _described(element: Element) -> tuple[Pattern, ...]:
    values = sorted(element.properties.items())
    return tuple(
        Compare(name, "=", element.id, value) for name, value in values if isinstance(value, str | int | float)
    )


_log = logging.getLogger(__name__)


def judge(condition: Condition, view: WorldView, binding: Binding | None = None) -> Verdict:
    """Tells whether a condition holds; one that breaks does not hold, negated or not, and the verdict says so.

    Args:
        condition: The condition.
        view: The world as believed, a snapshot, or an overlay.
        binding: Element ids by parameter key; None when the arguments are ids or classes already.
    """
    try:
        return condition.evaluate(view, binding)
    except (KeyboardInterrupt, Interruption):
        raise
    except BaseException as error:  # noqa: BLE001 - an author's code: whatever it raises, it said nothing about the world
        _log.error("condition %s broke", condition, exc_info=error)
        name = str(condition.bind(binding or {}))
        text = f"{name} broke: {type(error).__name__}: {error}"
        return Verdict(False, text)
