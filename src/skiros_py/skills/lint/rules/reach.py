"""What a skill needs and promises must be possible; things are moved by placing them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import combinations

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import Compare, Has, Not, Nothing, Pattern, Related
from skiros_py.skills.conditions.effects import Assign, Effect, Relate, Unrelate, brought_about, effects_of
from skiros_py.skills.conditions.pattern import NumberChange
from skiros_py.skills.inference.search import conjuncts
from skiros_py.skills.lint.rule import Known, Problem, Severity, Source, rule
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family


@rule("impossible-effect", "A postcondition that no skill can achieve.", SkillDescription)
def impossible_effect(description: SkillDescription, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields postconditions that have no effects."""
    for condition in description.post:
        try:
            effects_of(condition)
        except DescriptionError as error:
            yield f"postcondition {error}"


@rule(
    "unreachable-precondition", "A precondition that never holds, or cannot be restored.", SkillDescription,
    severity=Severity.WARNING,
)  # fmt: skip
def unreachable_precondition(description: SkillDescription, known: Known) -> Iterator[str]:
    """Yields what cannot hold together, and what skills take away and none gives back.

    What the scene may say at the start counts as possible: this finds what is certain only.
    """
    needed = [(condition, atom) for condition in description.needs for atom in conjuncts(condition.pattern)]
    for (one, first), (other, second) in combinations(needed, 2):
        if _exclude(first, second, known.ontology):
            yield f"{one} and {other} can never hold together"
    effects = [e for s in known.skills for condition in s.description.post for e in brought_about(condition)]
    for condition, atom in needed:
        if _lost(atom, effects, known.ontology):
            yield f"{condition}: skills end it, and no skill restores it"


def _exclude(one: Pattern, other: Pattern, ontology: Ontology) -> bool:
    match one, other:
        case Not(inner), _ if inner == other:
            return True
        case _, Not(inner) if inner == one:
            return True
        case (Nothing(relation, place), Related(held, _, object_)) | (
            Related(held, _, object_),
            Nothing(relation, place),
        ):
            return place == object_ and _is_below(held, relation, ontology)
        case Related(first), Related(second) if first != second:
            return _two_places(one, other, ontology)
        case Compare(property_, "=", subject, value), Compare(another, "=", thing, wanted):
            return (property_, subject) == (another, thing) and value != wanted
        case _:
            return False


def _is_below(relation: str, above: str, ontology: Ontology) -> bool:
    return above in ontology.relations and relation in ontology.sub_relations(above)


def _two_places(one: Related, other: Related, ontology: Ontology) -> bool:
    """Tells whether one thing would have to be in two places by relations of which nothing can be both."""
    if not all(r in ontology.relations and ontology.is_placement(r) for r in (one.relation, other.relation)):
        return False
    if set(ontology.sub_relations(one.relation)) & set(ontology.sub_relations(other.relation)):
        return False
    return _placed(one, ontology) == _placed(other, ontology)


def _placed(said: Related, ontology: Ontology) -> str:
    return said.subject if ontology.relation(said.relation).place_end == "object" else said.object


def _lost(atom: Pattern, effects: list[Effect], ontology: Ontology) -> bool:
    """Tells whether skills take something away by name that none gives; placements end by moving, and count not."""
    match atom:
        case Related(relation) if relation in ontology.relations:
            below = ontology.sub_relations(relation)
            ended = any(isinstance(e, Unrelate) and e.relation == relation for e in effects)
            return ended and not any(isinstance(e, Relate) and e.relation in below for e in effects)
        case Compare(property_):
            values = [e.value for e in effects if isinstance(e, Assign) and e.property == property_]
            counted = any(isinstance(e, NumberChange) and e.property == property_ for e in effects)
            return bool(values) and not counted and not any(atom.allows(value) for value in values)
        case Has(property_):
            values = [e.value for e in effects if isinstance(e, Assign) and e.property == property_]
            return None in values and all(value is None for value in values)
        case _:
            return False


@rule("unplaced", "An effect removes a thing from its place, and no effect places it.", SkillDescription, disables=True)
def unplaced(description: SkillDescription, known: Known) -> Iterator[str]:
    """Yields effects that take something from its place without saying where it is then."""
    posts = [condition.pattern for condition in description.post]
    placed = [{p.subject, p.object} for p in posts if isinstance(p, Related)]
    for pattern in posts:
        match pattern:
            case Not(Related(relation, start, end)) if relation in known.ontology.relations:
                if known.ontology.is_placement(relation) and not any(ends & {start, end} for ends in placed):
                    yield f"postcondition not {relation}({start}, {end}): say where it is afterwards"
            case _:
                pass


@rule("moves-by-structure", "A thing is moved by changing the structure of another one.", SkillDescription, Source)
def moves_by_structure(subject: SkillDescription | Source, known: Known) -> Iterator[Problem]:
    """Yields effects, and calls such as ``tx.relate(box, HAS_A, part)``, that change what a thing is built of."""
    if isinstance(subject, SkillDescription):
        for condition in subject.post:
            for effect in brought_about(condition):
                if isinstance(effect, Relate | Unrelate) and _is_structure(effect.relation, known.ontology):
                    what = f"postcondition {condition} changes {effect.relation}"
                    yield f"{what}, which defines the structure of a thing; {_INSTEAD}"
        return
    for node in ast.walk(subject.tree):
        match node:
            case ast.Call(func=ast.Attribute(attr="relate" | "unrelate" | "place"), args=[_, relation, *_]):
                name = _value(relation, subject)
                if _is_structure(name, known.ontology):
                    yield f"it writes {name}, which defines the structure of a thing; {_INSTEAD}", node.lineno
            case _:
                pass


_INSTEAD = "a thing that is moved gets another placement (in, on, at, held by, …)"


def _value(node: ast.expr, source: Source) -> str:
    """Returns the text that an expression stands for, where that is plain."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.Name(id=name):
            return str(source.names.get(name, ""))
        case ast.Attribute(value=ast.Name(id=module), attr=name):
            return str(getattr(source.names.get(module), name, ""))
        case _:
            return ""


def _is_structure(relation: str, ontology: Ontology) -> bool:
    return relation in ontology.relations and ontology.family(relation) is Family.STRUCTURE
