"""Conditions: named patterns in the words of the domain, and comparisons of a property with a constant."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from operator import eq, ge, gt, le, lt, ne
from types import MappingProxyType
from typing import Literal

from skiros_py.errors import DescriptionError
from skiros_py.interruptions import not_the_authors
from skiros_py.messages import Message, all_of
from skiros_py.skills.conditions.pattern import AllOf, Atom, Binding, Exists, Not, Pattern, Verdict
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.element import Element, Value, is_abstract
from skiros_py.world.literals import shown
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Compare(Atom):
    """A property of an element (or of its class) compares as wanted with a constant.

    Of an element without a value none of the comparisons holds, "!=" neither; ask that by ``Not(Has(...))``.

    Attributes:
        property: CURIE of the property.
        op: ``=``, ``!=``, and for numbers ``<``, ``<=``, ``>``, ``>=``.
        subject: Variable.
        value: A number, a text (also the name of a class or of a state), or true or false.

    Raises:
        DescriptionError: There is no such comparison, or not of such a value.
    """

    property: str
    op: Operator
    subject: str
    value: Constant

    def __post_init__(self) -> None:
        Comparison(self.op, self.value)

    def allows(self, value: Value | None) -> bool:
        """Tells whether it would hold of an element with this value, or with none."""
        return Comparison(self.op, self.value).allows(value)

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Compares."""
        subject = binding[self.subject]
        value = view.value(subject, self.property)
        said = {"property": local_name(self.property), "thing": subject}
        what, missing = Message("the {property} of {thing}", **said), Message("{thing} has no {property}", **said)
        return Comparison(self.op, self.value).judge(what, value, missing)


Operator = Literal["=", "!=", "<", "<=", ">", ">="]
"""How two values are compared; numbers all ways, texts and truth values by the first two."""

Constant = str | bool | int | float
"""What something may be compared with."""

OPERATORS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {"=": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge}
)
OPPOSITE: Mapping[Operator, Operator] = MappingProxyType(
    {"=": "!=", "!=": "=", "<": ">=", "<=": ">", ">": "<=", ">=": "<"}
)
"""The comparison that holds of a value where another one does not."""
_WORDS: Mapping[str, Callable[..., Message]] = MappingProxyType(
    {
        "=": partial(Message, "{value}"),
        "!=": partial(Message, "other than {value}"),
        "<": partial(Message, "less than {value}"),
        "<=": partial(Message, "at most {value}"),
        ">": partial(Message, "more than {value}"),
        ">=": partial(Message, "at least {value}"),
    }
)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Something held against a constant; ``"{op} {value}"`` of the patterns that compare.

    Attributes:
        op: How.
        value: With what.
    """

    op: Operator
    value: Constant

    def __post_init__(self) -> None:
        kind = kind_of(self.value)
        if kind is None or (isinstance(self.value, float) and not math.isfinite(self.value)):
            raise DescriptionError(f"compare with a text, a finite number, true or false, not with {shown(self.value)}")
        if self.op not in OPERATORS:
            raise DescriptionError(f"'{self.op}' does not compare: use one of {' '.join(OPERATORS)}")
        if kind != "number" and self.op not in ("=", "!="):
            raise DescriptionError(f"'{self.op}' compares numbers, and {_said(self.value)} is a {kind}: use = or !=")

    def __str__(self) -> str:
        return _WORDS[self.op](value=_said(self.value))

    def judge(self, what: str, present: Value | None, missing: str) -> Verdict:
        """Compares a value that is there with the constant.

        Nothing can be said of what is missing or of another kind: it is neither equal, nor other, nor less.

        Args:
            what: What has the value, for the reason ("the mass of ball_1").
            present: The value; None for none.
            missing: The reason where there is none.
        """
        if present is None:
            return Verdict(False, missing)
        if kind_of(present) != kind_of(self.value):
            kind = kind_of(present) or "no text, number or truth value"
            said = {"what": what, "value": _said(present), "kind": kind, "other": _said(self.value)}
            return Verdict(False, Message("{what} is {value} ({kind}): it cannot be compared with {other}", **said))
        if self.allows(present):
            return Verdict(True, Message("{what} is {value}", what=what, value=_said(present)))
        said = {"what": what, "value": _said(present), "wanted": str(self)}
        return Verdict(False, Message("{what} is {value}, not {wanted}", **said))

    def allows(self, present: Value | None) -> bool:
        """Tells whether a value that is there, or None, compares as wanted."""
        if present is None or kind_of(present) != kind_of(self.value):
            return False
        return OPERATORS[self.op](present, self.value)  # type: ignore[arg-type]  # both of one kind


def kind_of(value: object) -> str | None:
    """Returns what a value is ("truth value", "number", "text"); None for anything else."""
    if isinstance(value, bool):  # before int, of which it is a subclass
        return "truth value"
    if isinstance(value, int | float):
        return "number"
    return "text" if isinstance(value, str) else None


def _said(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return shown(value).removesuffix(".0") if isinstance(value, float) else shown(value)


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
        return self.closed_pattern(None)

    def closed_pattern(self, ontology: Ontology | None) -> Pattern:
        """Its pattern with a quantifier for each abstract argument: "there is a starter such that ..."."""
        pattern = self._positive(ontology)
        return Not(pattern) if self.negated else pattern

    def _positive(self, ontology: Ontology | None) -> Pattern:
        names = {role.name: argument for role, argument in zip(self.type.roles, self.arguments, strict=True)}
        pattern = self.type.pattern.rename(names)
        if ontology is not None:
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
            missing = all_of([Message("no {kind}", kind=name) for name in gone])
            return Verdict(self.negated, str(grounded), (Verdict(False, Message("there is {kind}", kind=missing)),))
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
    except BaseException as error:  # an author's code: whatever it raises, it said nothing about the world
        if not_the_authors(error):
            raise
        _log.error("condition %s broke", condition, exc_info=error)
        name = str(condition.bind(binding or {}))
        return Verdict(False, Message("{name} broke: {error}", name=name, error=f"{type(error).__name__}: {error}"))
