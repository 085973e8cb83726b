"""Writes a condition: a word of the domain, made of one relation or property."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, cast

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.scaffold.declared import (
    class_name,
    constant_name,
    read_constant,
    read_parameter,
    snake_case,
    words_of,
)
from skiros_py.scaffold.draft import Draft, literal, render
from skiros_py.scaffold.orders import NewCondition
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.stage import Stage
from skiros_py.skills.conditions import Compare, Computed, Has, Pattern, Related
from skiros_py.skills.parameters import Param
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import End, Family


def draft_condition(known: Knowledge, said: NewCondition) -> Draft:
    """Writes a condition, its test with a scene, and its entry point.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = class_name(said.name, "condition")
    known.check_free("condition", name)
    if bool(said.property) == bool(said.relation):
        raise UsageError(f"condition '{name}': give either --property or --relation, of which it is made")
    roles, pattern = (_of_relation if said.relation else _of_property)(known.ontology, said)
    stem, constant = snake_case(name), constant_name(name)
    help_ = said.help or _told(pattern, roles)
    values = known.project.names("conditions", name, stem, help_, constant=constant)
    stage = Stage(known, stem)
    yes, no = _cast(stage, known.ontology, roles, pattern)
    code = {
        "pattern_type": type(pattern).__name__,
        "roles": [f"Role({literal(role.key)}, {literal(role.type)})" for role in roles],
        "pattern": _written(pattern),
        "abstract": said.abstract,
    }
    answers = {"fact": not isinstance(pattern, Computed), "yes": _quoted(yes), "no": _quoted(no)}
    texts = (
        render("condition.py", **values, **code),
        render("condition_test.py", **values, **answers),
        stage.turtle(f"Something of which {name} holds."),
    )
    return known.project.module_draft("conditions", stem, {name: constant}, texts)


# ---------------------------------------------------------------- meaning


def _of_relation(ontology: Ontology, said: NewCondition) -> tuple[tuple[Param, ...], Pattern]:
    if said.value:
        raise UsageError(f"condition '{said.name}': --value goes with --property; a relation has none")
    name = ontology.resolve_relation(said.relation)
    relation = ontology.relations[name]
    roles = _roles(ontology, said, (relation.domains, relation.ranges), name)
    computed = relation.family is Family.COMPUTED
    return roles, (Computed if computed else Related)(name, roles[0].key, roles[1].key)


def _of_property(ontology: Ontology, said: NewCondition) -> tuple[tuple[Param, ...], Pattern]:
    name = _property(ontology, said.property)
    property_ = ontology.properties[name]
    (role,) = roles = _roles(ontology, said, (property_.domains,), name)
    if not said.value and property_.range != "xsd:boolean":
        return roles, Has(name, role.key)
    value = read_constant(said.value or "true", property_.range, f"--value of {name}")
    try:
        return roles, Compare(name, "=", role.key, value)
    except DescriptionError as error:
        raise UsageError(f"condition '{said.name}': {error}") from error


def _property(ontology: Ontology, name: str) -> str:
    found = [own for own in ontology.properties if name in (own, local_name(own))]
    if len(found) != 1:
        hint = "(skiros new ontology declares new ones)" if not found else f"of {' and '.join(found)}"
        raise UnknownName("property", name, ontology.properties, where=hint)
    return found[0]


def _roles(ontology: Ontology, said: NewCondition, ends: Sequence[End], word: str) -> tuple[Param, ...]:
    roles = tuple(read_parameter(text, ontology) for text in said.roles or _default_roles(ends))
    if len(roles) != len(ends):
        must = "one role: what bears it" if len(ends) == 1 else "two roles: its subject, then its object"
        raise UsageError(f"condition '{said.name}': {word} takes {must}; {len(roles)} given")
    if len({role.key for role in roles}) < len(roles):
        raise UsageError(f"condition '{said.name}': its roles must have different names")
    for role, end in zip(roles, ends, strict=True):
        if not role.is_element:
            raise UsageError(f"condition '{said.name}': role '{role.key}' must be of a class, not a {role.type}")
        if missed := ontology.missed_end(role.element_class, end):
            raise UsageError(
                f"condition '{said.name}': {word} is of {' or '.join(missed)}; {role.key} is a {role.type}"
            )
    return roles


def _default_roles(ends: Sequence[End]) -> tuple[str, ...]:
    classes = [end[0][0] if end else "sk:Element" for end in ends]
    keys = [snake_case(local_name(class_)) for class_ in classes]
    if len(set(keys)) < len(keys):
        keys = ["subject", "object"]
    return tuple(f"{key}:{class_}" for key, class_ in zip(keys, classes, strict=True))


# ---------------------------------------------------------------- code and test


def _written(pattern: Pattern) -> str:
    values = (getattr(pattern, field.name) for field in fields(cast(Any, pattern)))
    return f"{type(pattern).__name__}({', '.join(literal(value) for value in values if value is not None)})"


def _told(pattern: Pattern, roles: Sequence[Param]) -> str:
    subject = words_of(roles[0].key)
    match pattern:
        case Compare(property_, _, _, bool(value)):
            return f"The {subject} is {'' if value else 'not '}{words_of(local_name(property_))}"
        case Compare(property_, _, _, value):
            return f"The {words_of(local_name(property_))} of the {subject} is {value}"
        case Has(property_, _):
            return f"The {words_of(local_name(property_))} of the {subject} is known"
        case Related(relation) | Computed(relation):
            other = words_of(roles[1].key)
            return f"The {subject} is in the relation '{words_of(local_name(relation))}' to the {other}"
        case _:
            raise AssertionError(f"no words for {pattern}")


def _cast(
    stage: Stage, ontology: Ontology, roles: Sequence[Param], pattern: Pattern
) -> tuple[Sequence[str], Sequence[str]]:
    """Adds an element for which it holds, and one for which it does not.

    Returns:
        The arguments for which it holds (unknown where it is computed), and those for which it does not.
    """
    yes = {role.key: stage.cast(role.element_class, role.key) for role in roles}
    first = roles[0]
    other = {**yes, first.key: stage.add(first.element_class, first.key)}
    if stage.suppose(pattern, yes):
        return tuple(yes.values()), ()
    is_given = isinstance(pattern, Has | Compare) and ontology.class_value(first.element_class, pattern.property)
    return tuple(yes.values()), () if is_given not in (False, None) else tuple(other.values())


def _quoted(ids: Sequence[str]) -> str:
    return ", ".join(map(literal, ids))
