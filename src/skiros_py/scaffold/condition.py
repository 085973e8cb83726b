"""Writes a condition: a word of the domain, made of one relation or property."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.scaffold.declared import (
    Declared,
    check_distinct,
    class_name,
    constant_name,
    read_constant,
    read_parameter,
    sentence,
    snake_case,
    words_of,
)
from skiros_py.scaffold.draft import Draft, literal, render
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.stage import Stage
from skiros_py.skills.conditions import Compare, Computed, Has, Pattern, Related
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import End, Family


@dataclass(frozen=True, slots=True)
class NewCondition:
    """The author's options for a condition.

    Attributes:
        name: The word ("Scanned").
        help: One sentence; derived from the word if omitted.
        roles: Its arguments (``part:sk:Manipulatable``); derived from the relation or property if omitted.
        property: The property that it checks.
        value: Required value of the property; if omitted, true for a boolean, any value for others.
        relation: The relation between its two arguments.
        abstract: True when a goal may give a class instead of an element.
    """

    name: str
    help: str = ""
    roles: tuple[str, ...] = ()
    property: str = ""
    value: str = ""
    relation: str = ""
    abstract: bool = False


def draft_condition(known: Knowledge, said: NewCondition) -> Draft:
    """Writes a condition, its test with a scene, and its entry point.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = class_name(said.name, "condition")
    known.check_free("condition", name)
    check_distinct([constant_name(name)], f"condition '{name}'")
    if bool(said.property) == bool(said.relation):
        raise UsageError(f"condition '{name}': give either --property or --relation, of which it is made")
    roles, pattern = _meaning(known.ontology, said)
    help_ = sentence(said.help or _told(pattern, roles), "--help-text")
    stem, package = snake_case(name), known.project.package
    module = f"{package}.conditions.{stem}"
    project = known.project.with_entries("skiros.conditions", {name: f"{module}:{constant_name(name)}"})
    stage, yes, no = _staged(known.ontology, stem, roles, pattern)
    values = {"name": name, "help": help_, "stem": stem, "module": module, "constant": constant_name(name)}
    answers = {"fact": not isinstance(pattern, Computed), "yes": _quoted(yes), "no": _quoted(no)}
    new = {
        **known.project.init_file("conditions"),
        f"src/{package}/conditions/{stem}.py": _module(values, roles, pattern, abstract=said.abstract),
        f"tests/conditions/test_{stem}.py": render("condition_test.py", **values, **answers),
        f"tests/conditions/scenes/{stem}.ttl": stage.turtle(f"Something of which {name} holds."),
    }
    return Draft(project.root, new, project.changes(known.project))


def _module(values: dict[str, str], roles: Sequence[Declared], pattern: Pattern, *, abstract: bool) -> str:
    names = (type(pattern).__name__, "ConditionType", "Role")
    return render(
        "condition.py",
        **values,
        needed=[("skiros_py.skills.conditions", name) for name in names],
        roles=[f"Role({literal(role.key)}, {literal(role.type)})" for role in roles],
        pattern=_written(pattern),
        abstract=abstract,
    )


# ---------------------------------------------------------------- meaning


def _meaning(ontology: Ontology, said: NewCondition) -> tuple[tuple[Declared, ...], Pattern]:
    if said.relation:
        return _of_relation(ontology, said)
    return _of_property(ontology, said)


def _of_relation(ontology: Ontology, said: NewCondition) -> tuple[tuple[Declared, ...], Pattern]:
    if said.value:
        raise UsageError(f"condition '{said.name}': --value goes with --property; a relation has none")
    name = ontology.resolve_relation(said.relation)
    relation = ontology.relations[name]
    roles = _roles(ontology, said, (relation.domains, relation.ranges), name)
    computed = relation.family is Family.COMPUTED
    return roles, (Computed if computed else Related)(name, roles[0].key, roles[1].key)


def _of_property(ontology: Ontology, said: NewCondition) -> tuple[tuple[Declared, ...], Pattern]:
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


def _roles(ontology: Ontology, said: NewCondition, ends: Sequence[End], word: str) -> tuple[Declared, ...]:
    roles = tuple(read_parameter(text, ontology) for text in said.roles or _default_roles(ends))
    if len(roles) != len(ends):
        must = "one role: what bears it" if len(ends) == 1 else "two roles: its subject, then its object"
        raise UsageError(f"condition '{said.name}': {word} takes {must}; {len(roles)} given")
    if len({role.key for role in roles}) < len(roles):
        raise UsageError(f"condition '{said.name}': its roles must have different names")
    for role, end in zip(roles, ends, strict=True):
        if not role.is_element:
            raise UsageError(f"condition '{said.name}': role '{role.key}' must be of a class, not a {role.type}")
        if missed := ontology.missed_end(role.type, end):
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
    match pattern:
        case Compare(property_, op, subject, value):
            arguments = [literal(part) for part in (property_, op, subject, value)]
        case Has(property_, subject):
            arguments = [literal(property_), literal(subject)]
        case Related(relation, subject, object_) | Computed(relation, subject, object_):
            arguments = [literal(relation), literal(subject), literal(object_)]
        case _:
            raise AssertionError(f"no template writes {pattern}")
    return f"{type(pattern).__name__}({', '.join(arguments)})"


def _told(pattern: Pattern, roles: Sequence[Declared]) -> str:
    subject = words_of(roles[0].key)
    match pattern:
        case Compare(property_, _, _, bool(value)):
            return f"The {subject} is {'' if value else 'not '}{words_of(local_name(property_))}"
        case Compare(property_, _, _, value):
            return f"The {words_of(local_name(property_))} of the {subject} is {value}"
        case Has(property_, _):
            return f"The {words_of(local_name(property_))} of the {subject} is known"
        case Related(relation, _, _) | Computed(relation, _, _):
            return (
                f"The {subject} is in the relation '{words_of(local_name(relation))}' to the {words_of(roles[1].key)}"
            )
        case _:
            raise AssertionError(f"no words for {pattern}")


def _staged(
    ontology: Ontology, name: str, roles: Sequence[Declared], pattern: Pattern
) -> tuple[Stage, tuple[str, ...], tuple[str, ...]]:
    """Builds a scene with one element for which it holds, and one for which it does not.

    Returns:
        The scene, the arguments for which it holds (unknown where it is computed), and those for which it does not.
    """
    stage = Stage(ontology, name)
    yes = {role.key: stage.cast(role.type, role.key) for role in roles}
    other = {**yes, roles[0].key: stage.add(roles[0].type, roles[0].key)}
    if stage.suppose(pattern, yes):
        return stage, tuple(yes.values()), ()
    by_class = isinstance(pattern, Has | Compare) and ontology.class_value(roles[0].type, pattern.property) is not None
    return stage, tuple(yes.values()), () if by_class else tuple(other.values())


def _quoted(ids: Sequence[str]) -> str:
    return ", ".join(map(literal, ids))
