"""Where patterns stand in a plug-in, and what they are made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.conditions import AllOf, AnyOf, Condition, ConditionType, Exists, Not, Pattern
from skiros_py.skills.lint.subject import Subject
from skiros_py.skills.parameters import IT
from skiros_py.skills.skill import Skill, SkillDescription

Classes = Mapping[str, str]
"""Class of the element that a variable stands for, by variable."""

_NONE: Classes = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Use:
    """A pattern at a place where it is used.

    Attributes:
        where: The place, for messages ("condition InKit(Object, Kit)").
        pattern: The pattern.
        classes: What its free variables stand for.
        condition: The condition that it is the pattern of, or None.
    """

    where: str
    pattern: Pattern
    classes: Classes
    condition: Condition | None = None


def classes_of(description: SkillDescription) -> Classes:
    """Returns the classes of a skill's element parameters."""
    return {p.key: p.type for p in description.params if isinstance(p.type, str) and p.is_element}


def uses_of(subject: Subject) -> Iterator[Use]:
    """Yields every pattern that a thing uses."""
    match subject:
        case SkillDescription():
            yield from _of_description(subject)
        case Skill():
            classes = classes_of(subject.description)
            yield from _of_conditions(subject.when, classes)
            for node in subject.nodes:
                yield from _of_body(node, classes)
        case ConditionType():
            yield Use("its pattern", subject.pattern, {role.name: role.class_ for role in subject.roles})
        case _:
            pass


def _of_description(description: SkillDescription) -> Iterator[Use]:
    classes = classes_of(description)
    yield from _of_conditions((*description.pre, *description.hold, *description.post), classes)
    for param in description.params:
        for pattern in (*param.described, *param.preferred):
            yield Use(f"parameter {param.key}", pattern, {**classes, IT: str(param.type)})


def _of_conditions(conditions: tuple[Condition, ...], classes: Classes) -> Iterator[Use]:
    yield from (Use(f"condition {c}", c.pattern, classes, c) for c in conditions)


def _of_body(node: Behaviour, classes: Classes) -> Iterator[Use]:
    for below, scope in walk_scoped(node, classes):
        uses = below.uses()
        yield from _of_conditions(uses.conditions, scope)
        for where, pattern in uses.patterns:
            yield Use(where, pattern, {**scope, **uses.binds})


def walk_scoped(node: Behaviour, classes: Classes = _NONE) -> Iterator[tuple[Behaviour, Classes]]:
    """Yields a node and all below it, each with the classes of the elements that it can refer to."""
    yield node, classes
    inner = {**classes, **node.uses().binds}
    for child in node.named_children().values():
        yield from walk_scoped(child, inner)


def leaves(pattern: Pattern, classes: Classes = _NONE) -> Iterator[tuple[Pattern, Classes]]:
    """Yields what a pattern is made of, also the quantifiers, each with the classes of its variables."""
    match pattern:
        case Not(inner):
            yield from leaves(inner, classes)
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from leaves(part, classes)
        case Exists(variable, class_, inner):
            yield pattern, classes
            yield from leaves(inner, {**classes, variable: class_})
        case _:
            yield pattern, classes
