"""What a relation, a property, a role or a parameter asks for must be something that can be given."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from skiros_py.errors import UsageError
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
from skiros_py.skills.conditions.pattern import Classes, NumberChange, leaves
from skiros_py.skills.lint.rule import Known, Place, Subject, Use, rule, uses_of
from skiros_py.skills.parameters import Param
from skiros_py.skills.parameters.values import read_constant
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.literals import CLASS_NAME, DATATYPES
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import End


@rule(
    "wrong-range", "A condition or module gets an element or value that can never fit.",
    SkillDescription, Skill, Place, ConditionType,
)  # fmt: skip
def wrong_range(subject: Subject, known: Known) -> Iterator[str]:
    """Yields conditions and arguments of modules with elements and values that can never fit."""
    for use in uses_of(subject):
        wrong = list(_roles(use.condition, use.classes, known.ontology)) if use.condition is not None else []
        yield from (f"{use.where}: {text}" for text in wrong or _wrong_ends(use, known.ontology))
    if isinstance(subject, Place):
        for call in subject.node.uses().calls:
            yield from _passed(call, subject, known)


def _roles(condition: Condition, classes: Classes, ontology: Ontology) -> Iterator[str]:
    for role, argument in zip(condition.type.roles, condition.arguments, strict=True):
        class_ = classes.get(argument)
        if class_ is not None and not ontology.overlap(class_, role.class_):
            yield f"its {role.name} is a {role.class_}, and {argument} is a {class_}: nothing is both"


def _wrong_ends(use: Use, ontology: Ontology) -> Iterator[str]:
    for leaf, classes in leaves(use.pattern, use.classes):
        match leaf:
            case Related() | Computed() | ClassRelated():
                relation, subject, object_ = leaf.relation, leaf.subject, leaf.object
                yield from _end("subject", relation, subject, classes, ontology)
                yield from _end("object", relation, object_, classes, ontology)
            case Nothing(relation, object_):
                yield from _end("object", relation, object_, classes, ontology)
            case Has() | Compare() | NumberChange():
                yield from _property(leaf, classes, ontology)
            case Expression() if problem := leaf.problem(partial(_kinds_of, classes)):
                yield problem
            case IsA(subject, class_) if not ontology.overlap(classes.get(subject, class_), class_):
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
    assert isinstance(leaf, Has | Compare | NumberChange)
    declared = ontology.properties.get(leaf.property)
    class_ = classes.get(leaf.subject)
    if declared is None:
        return
    if class_ is not None and not _fits(ontology, class_, declared.domains):
        yield f"{leaf.property} belongs to a {_said(declared.domains)}, and {leaf.subject} is a {class_}"
    if isinstance(leaf, Compare) and not _comparable(leaf, declared.range, ontology):
        yield f"{leaf.property} has {DATATYPES[declared.range].says}, never {leaf.value!r}"
    if isinstance(leaf, NumberChange) and not any(map(DATATYPES[declared.range].fits, (1, 0.5))):
        yield f"{leaf.property} has {DATATYPES[declared.range].says}: it cannot grow or fall"


def _comparable(leaf: Compare, range_: str, ontology: Ontology) -> bool:
    if range_ == CLASS_NAME and isinstance(leaf.value, str):
        return leaf.value in ontology.classes
    # A whole number may well lie above 0.5 or below 1.5: only the kind of value counts for an order.
    values = (leaf.value,) if leaf.op in ("=", "!=") else (leaf.value, 1, 0.5, -1)
    return any(map(DATATYPES[range_].fits, values))


def _passed(call: Call, place: Place, known: Known) -> Iterator[str]:
    """Yields parameters that are given what they can never be."""
    wanted = {param.key: param for param in known.params(call.module) or ()}
    for key, value in call.inputs.items():
        if key not in wanted or value is None:
            continue
        if isinstance(value, P):
            given = _given(value.key, place, known)
            wrong = [why for one in given if (why := _misfit(wanted[key], one, value.key, known.ontology))]
            if wrong and len(wrong) == len(given):
                yield f"'{call.module}' takes {wrong[0]}"
        elif why := _refused(wanted[key], value, known.ontology):
            yield f"'{call.module}': {why}"


def _given(name: str, place: Place, known: Known) -> tuple[Param, ...]:
    """Returns what a value may be that a node reads: a parameter, the element of a loop, or one of several outputs."""
    if name in place.classes:
        return (Param(name, place.classes[name], ""),)
    return (place.values[name],) if name in place.values else known.types(place.written.get(name, ()))


def _misfit(wanted: Param, given: Param, name: str, ontology: Ontology) -> str:
    """Returns why a value never fits a parameter; an empty text where it may."""
    takes = f"{wanted.type_name} as {wanted.key}"
    if wanted.is_element:
        if not given.is_element:
            return f"a {takes}, and {name} is not an element"
        both = ontology.overlap(given.element_class, wanted.element_class)
        return "" if both else f"a {takes}, and {name} is a {given.type}: nothing is both"
    if not _may_be(given, wanted):
        return f"{takes}, and {name} is a {given.type_name}"
    if wanted.unit and given.unit and wanted.unit != given.unit:
        return f"{takes} in {wanted.unit}, and {name} is in {given.unit}"
    return ""


_FITTING = {
    "number": ("number", "integer"),
    "integer": ("number", "integer"),
    "text": ("text", "class"),
    "class": ("text", "class"),
    "pose": ("pose", "vector"),
}


def _may_be(given: Param, wanted: Param) -> bool:
    """Returns whether values of one type may be of another; of Python classes nothing is known before a run."""
    if given.is_element:
        return False
    shape = _shape(wanted)
    return "" in (shape, _shape(given)) or _shape(given) in _FITTING.get(shape, (shape,))


def _shape(param: Param) -> str:
    """Returns what the values of a parameter are, one or several; an empty text for those of Python classes."""
    if not isinstance(param.type, str) or param.length == 1:
        return param.type if isinstance(param.type, str) else ""
    return "vector" if param.type in ("number", "integer") else f"several {param.type}"


def _refused(param: Param, value: object, ontology: Ontology) -> str:
    """Returns why a constant is no value of a parameter; an empty text where it is one."""
    if param.is_element:
        why = f"parameter {param.key} takes the id of a {param.type}, not {value!r:.100}"
        return "" if isinstance(value, str) else why
    try:
        read = read_constant(param, value)
        if param.type == "class":
            for name in read if isinstance(read, tuple) else (read,):
                ontology.resolve_class(name)
    except UsageError as error:
        return str(error).rstrip(".")
    return ""
