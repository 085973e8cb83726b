"""What a relation, a property, a role or a parameter asks for must be something that can be given."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from skiros_py.skills.behaviour import Call, P
from skiros_py.skills.conditions import (
    ClassRelated,
    Compare,
    Computed,
    Condition,
    ConditionType,
    Expression,
    Has,
    IsA,
    Nothing,
    Pattern,
    Related,
)
from skiros_py.skills.conditions.pattern import Classes, leaves
from skiros_py.skills.lint.rule import Known, Place, Subject, Use, rule, uses_of
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.literals import CLASS_NAME, DATATYPES
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import End


@rule(
    "wrong-range", "A condition or module gets an element that can never fit.",
    SkillDescription, Skill, Place, ConditionType,
)  # fmt: skip
def wrong_range(subject: Subject, known: Known) -> Iterator[str]:
    """Yields conditions and arguments of modules with elements that can never fit."""
    for use in uses_of(subject):
        wrong = list(_roles(use.condition, use.classes, known.ontology)) if use.condition is not None else []
        yield from (f"{use.where}: {text}" for text in wrong or _wrong_ends(use, known.ontology))
    if isinstance(subject, Place):
        for call in subject.node.uses().calls:
            yield from _passed(call, subject, known)


def _roles(condition: Condition, classes: Classes, ontology: Ontology) -> Iterator[str]:
    for role, argument in zip(condition.type.roles, condition.arguments, strict=True):
        class_ = classes.get(argument)
        if class_ is not None and not overlap(ontology, class_, role.class_):
            yield f"its {role.name} is a {role.class_}, and {argument} is a {class_}: nothing is both"


def overlap(ontology: Ontology, one: str, other: str) -> bool:
    """Tells whether something can be of both classes; of what is not declared nothing is known."""
    if one not in ontology.classes or other not in ontology.classes:
        return True
    return any(ontology.is_a(below, other) for below in ontology.subclasses(one))


def _wrong_ends(use: Use, ontology: Ontology) -> Iterator[str]:
    for leaf, classes in leaves(use.pattern, use.classes):
        match leaf:
            case Related() | Computed() | ClassRelated():
                relation, subject, object_ = leaf.relation, leaf.subject, leaf.object
                yield from _end("subject", relation, subject, classes, ontology)
                yield from _end("object", relation, object_, classes, ontology)
            case Nothing(relation, object_):
                yield from _end("object", relation, object_, classes, ontology)
            case Has() | Compare():
                yield from _property(leaf, classes, ontology)
            case Expression() if problem := leaf.problem(partial(_kinds_of, classes)):
                yield problem
            case IsA(subject, class_) if not overlap(ontology, classes.get(subject, class_), class_):
                yield f"{subject} is a {classes[subject]}, and can never be a {class_}"
            case _:
                pass


_SIGNAL = frozenset({"number", "truth value", "vector"})


def _kinds_of(classes: Classes, name: str) -> frozenset[str]:
    """Returns what the value of a name in an expression can be; of a value parameter nothing is known here."""
    if "." in name or name.startswith("`"):
        return _SIGNAL
    return frozenset({"text"}) if name in classes else _SIGNAL | {"text"}


def _end(end: str, relation: str, variable: str, classes: Classes, ontology: Ontology) -> Iterator[str]:
    class_ = classes.get(variable)
    if class_ is None or relation not in ontology.relations:
        return
    below = [ontology.relations[name] for name in ontology.sub_relations(relation)]
    asked = [r.domains if end == "subject" else r.ranges for r in below]
    if not any(_fits(ontology, class_, one) for one in asked):
        yield f"the {end} of {relation} is a {_said(asked[0])}, and {variable} is a {class_}: nothing is both"


def _fits(ontology: Ontology, class_: str, end: End) -> bool:
    if class_ not in ontology.classes:
        return True
    return any(not ontology.missed_end(below, end) for below in ontology.subclasses(class_))


def _said(end: End) -> str:
    return " and a ".join(" or ".join(group) for group in end)


def _property(leaf: Pattern, classes: Classes, ontology: Ontology) -> Iterator[str]:
    assert isinstance(leaf, Has | Compare)
    declared = ontology.properties.get(leaf.property)
    class_ = classes.get(leaf.subject)
    if declared is None:
        return
    if class_ is not None and not _fits(ontology, class_, declared.domains):
        yield f"{leaf.property} is borne by a {_said(declared.domains)}, and {leaf.subject} is a {class_}"
    if isinstance(leaf, Compare) and not _comparable(leaf, declared.range, ontology):
        yield f"{leaf.property} has {DATATYPES[declared.range].says}, never {leaf.value!r}"


def _comparable(leaf: Compare, range_: str, ontology: Ontology) -> bool:
    if range_ == CLASS_NAME and isinstance(leaf.value, str):
        return leaf.value in ontology.classes
    # A whole number may well lie above 0.5 or below 1.5: only the kind of value counts for an order.
    values = (leaf.value,) if leaf.op in ("=", "!=") else (leaf.value, 1, 0.5, -1)
    return any(map(DATATYPES[range_].fits, values))


def _passed(call: Call, place: Place, known: Known) -> Iterator[str]:
    """Yields parameters that are passed on as something they can never be."""
    wanted = {param.key: param for param in known.params(call.module) or ()}
    for key, value in call.arguments.items():
        if not isinstance(value, P) or key not in wanted:
            continue
        param, class_ = wanted[key], place.classes.get(value.key)
        if class_ is not None and not param.is_element:
            yield f"'{call.module}' takes {param.type_name} as {key}, and {value.key} is a {class_}"
        elif param.is_element and value.key in place.values:
            yield f"'{call.module}' takes a {param.type_name} as {key}, and {value.key} is no element"
        elif class_ is not None and param.is_element and not overlap(known.ontology, class_, param.element_class):
            yield f"'{call.module}' takes a {param.type_name} as {key}, and {value.key} is a {class_}: nothing is both"
