"""Conditions made of conditions: all of them, any of them, for all elements of a class, or for some."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Literal

from skiros_py.errors import DescriptionError
from skiros_py.messages import Message
from skiros_py.skills.conditions.condition import Condition, ConditionType, Role
from skiros_py.skills.conditions.pattern import (
    ALL_OF_THESE,
    ANY_OF_THESE,
    AllOf,
    AnyOf,
    Binding,
    Exists,
    Not,
    Pattern,
    Verdict,
)
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView

_VARIABLE = re.compile(r"[^\W\d]\w*")
_JOINED = {"and": AllOf, "or": AnyOf}
_TRIED_SHOWN = 5
"""How many of the elements for which a condition did not hold are listed."""


@dataclass(frozen=True, slots=True)
class Junction(Condition):
    """Conditions joined by "and" or "or"; made by :func:`all_of` and :func:`any_of`.

    Attributes:
        type: Derived from the parts.
        arguments: Those of the parts, each once.
        word: What joins them.
        parts: At least two conditions.
    """

    type: ConditionType = field(compare=False)
    arguments: tuple[str, ...] = field(compare=False)
    word: Literal["and", "or"] = field(kw_only=True)
    parts: tuple[Condition, ...] = field(kw_only=True)

    def written(self, naming: Callable[[str], str]) -> str:
        """Returns it as text; parts that are joined themselves stand in parentheses."""
        text = f" {self.word} ".join(_enclosed(part, naming) for part in self.parts)
        return f"not ({text})" if self.negated else text

    @property
    def names(self) -> tuple[str, ...]:
        """Everything its parts speak of."""
        return tuple(dict.fromkeys(name for part in self.parts for name in part.names))

    def _positive(self, ontology: Ontology | None) -> Pattern:
        """Joins the closed patterns of the parts: "any starter" in two of them may be two starters."""
        return _JOINED[self.word](tuple(part.closed_pattern(ontology) for part in self.parts))

    def bind(self, binding: Mapping[str, str]) -> Condition:
        """Replaces parameter keys in all parts by the ids they are bound to."""
        bound = _joined([part.bind(binding) for part in self.parts], self.word)
        return replace(bound, negated=self.negated, name=self.name)

    def evaluate(self, view: WorldView, binding: Binding | None = None) -> Verdict:
        """Tells whether it holds; the verdict has that of each part."""
        parts = tuple(part.evaluate(view, binding) for part in self.parts)
        is_and = self.word == "and"
        holds, text = (all(parts), ALL_OF_THESE) if is_and else (any(parts), ANY_OF_THESE)
        together = Verdict(holds, text, parts)
        return Verdict(together.holds is not self.negated, self.written(_naming(binding or {})), (together,))


@dataclass(frozen=True, slots=True)
class Quantified(Condition):
    """A condition for all elements of a class, or for at least one; made by :func:`for_all` and :func:`exists`.

    Attributes:
        type: Derived from the part.
        arguments: Those of the part without the variable.
        quantifier: For how many it must hold.
        variable: An argument of the part, which stands for the elements.
        class_: CURIE of their class.
        part: What must hold of them.
    """

    type: ConditionType = field(compare=False)
    arguments: tuple[str, ...] = field(compare=False)
    quantifier: Literal["for all", "exists"] = field(kw_only=True)
    variable: str = field(kw_only=True)
    class_: str = field(kw_only=True)
    part: Condition = field(kw_only=True)

    def written(self, naming: Callable[[str], str]) -> str:
        """Returns it as text."""
        head = f"{self.quantifier} {self.variable}: {naming(self.class_)}"
        inner = self.part.written(lambda name: name if name == self.variable else naming(name))
        return f"{'not ' if self.negated else ''}{head} ({inner})"

    @property
    def names(self) -> tuple[str, ...]:
        """The class it ranges over, and everything its part speaks of but the variable."""
        return tuple(dict.fromkeys((self.class_, *(name for name in self.part.names if name != self.variable))))

    def _positive(self, ontology: Ontology | None) -> Pattern:
        inner = self.part.closed_pattern(ontology)
        if self.quantifier == "exists":
            return Exists(self.variable, self.class_, inner)
        return Not(Exists(self.variable, self.class_, Not(inner)))

    def bind(self, binding: Mapping[str, str]) -> Condition:
        """Replaces parameter keys by the ids they are bound to; the variable gives way to an id of that name."""
        outer = {key: name for key, name in binding.items() if key in self.arguments}
        variable = self.variable
        while variable in outer.values() or (variable != self.variable and variable in self.part.arguments):
            variable += "_"
        part = self.part.bind({**outer, self.variable: variable})
        bound = _quantified(self.quantifier, variable, self.class_, part)
        return replace(bound, negated=self.negated, name=self.name)

    def evaluate(self, view: WorldView, binding: Binding | None = None) -> Verdict:
        """Tells whether it holds: tries the elements of the class in the order of their ids until one decides."""
        tried: list[Verdict] = []
        exists, class_ = self.quantifier == "exists", local_name(self.class_)
        candidates = view.instances(self.class_)
        for candidate in candidates:
            verdict = self.part.evaluate(view, {**(binding or {}), self.variable: candidate})
            if verdict.holds is exists:
                text = Message("{thing} is the {kind}", thing=candidate, kind=class_)
                if not exists:
                    text = Message("it does not hold for the {kind} {thing}", kind=class_, thing=candidate)
                inner = Verdict(exists, text, (verdict,))
                break
            tried = [*tried, verdict][:_TRIED_SHOWN]
        else:
            text = Message("no {kind} makes it true ({count} tried)", kind=class_, count=len(candidates))
            if not candidates and exists:
                text = Message("there is no {kind}", kind=class_)
            elif not candidates:
                text = Message("there is no {kind}, so it holds for all", kind=class_)
            elif not exists:
                text = Message("it holds for each {kind} ({count})", kind=class_, count=len(candidates))
            inner = Verdict(not exists, text, tuple(tried))
        return Verdict(inner.holds is not self.negated, self.written(_naming(binding or {})), (inner,))


def any_of(*conditions: Condition) -> Condition:
    """Makes a condition that holds when at least one of the given ones does.

    Raises:
        DescriptionError: None is given.
    """
    return _joined(conditions, "or")


def all_of(*conditions: Condition) -> Condition:
    """Makes a condition that holds when all of the given ones do.

    Raises:
        DescriptionError: None is given.
    """
    return _joined(conditions, "and")


def for_all(variable: str, class_: str, condition: Condition) -> Condition:
    """Makes a condition that holds when another one does for each element of a class, also when there is none.

    Args:
        variable: Stands for the element among the arguments of the condition.
        class_: CURIE of the class; elements of its subclasses count.
        condition: What must hold of each.

    Raises:
        DescriptionError: The variable is no name, or no argument of the condition.
    """
    return _quantified("for all", variable, class_, condition)


def exists(variable: str, class_: str, condition: Condition) -> Condition:
    """Makes a condition that holds when another one does for at least one element of a class.

    Args:
        variable: Stands for the element among the arguments of the condition.
        class_: CURIE of the class; elements of its subclasses count.
        condition: What must hold of it.

    Raises:
        DescriptionError: The variable is no name, or no argument of the condition.
    """
    return _quantified("exists", variable, class_, condition)


def _joined(conditions: Sequence[Condition], word: Literal["and", "or"]) -> Condition:
    several = (c.parts if isinstance(c, Junction) and c.word == word and not c.negated else (c,) for c in conditions)
    parts = tuple(chain.from_iterable(several))
    if not parts:
        raise DescriptionError(f"nothing is joined by '{word}': give at least one condition")
    if len(parts) == 1:
        return parts[0]
    name, help_ = f" {word} ".join(p.type.name for p in parts), f" {word} ".join(p.type.help for p in parts)
    roles = {argument: role for part in parts for argument, role in _roles(part)}
    pattern = _JOINED[word](tuple(part.pattern for part in parts))
    return Junction(ConditionType(name, tuple(roles.values()), pattern, help_), tuple(roles), word=word, parts=parts)


def _quantified(quantifier: Literal["for all", "exists"], variable: str, class_: str, part: Condition) -> Condition:
    if not _VARIABLE.fullmatch(variable):
        raise DescriptionError(f"'{variable}' cannot be a variable: use a letter, then letters, digits and '_'")
    if variable not in part.arguments:
        raise DescriptionError(f"{quantifier} {variable}: {variable} is no argument of {part}")
    roles = {argument: role for argument, role in _roles(part) if argument != variable}
    type_ = ConditionType(f"{quantifier} {variable}", tuple(roles.values()), part.pattern, part.type.help)
    whole = Quantified(type_, tuple(roles), quantifier=quantifier, variable=variable, class_=class_, part=part)
    return replace(whole, type=replace(type_, pattern=whole.pattern))


def _roles(condition: Condition) -> Iterator[tuple[str, Role]]:
    for role, argument in zip(condition.type.roles, condition.arguments, strict=True):
        yield argument, Role(argument, role.class_)


def _enclosed(condition: Condition, naming: Callable[[str], str]) -> str:
    text = condition.written(naming)
    return f"({text})" if isinstance(condition, Junction) and not condition.negated else text


def _naming(binding: Binding) -> Callable[[str], str]:
    """Writes what parameters are bound to; quicker than binding all parts for the sake of the text."""
    return lambda name: local_name(binding.get(name, name))
