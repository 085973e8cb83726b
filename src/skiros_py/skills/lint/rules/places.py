"""Everything is somewhere, and things are moved by placing them, never by rebuilding them."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from skiros_py.skills.conditions import Condition, Not, Relate, Related, Unrelate
from skiros_py.skills.lint.rule import Problem, Rule, Severity, Spot
from skiros_py.skills.lint.rules.reach import brought_about
from skiros_py.skills.lint.subject import Known, Source, Subject
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family


def _unplaced(subject: Subject, known: Known) -> Iterator[Problem]:
    """Yields effects that take something from its place without saying where it is then."""
    if not isinstance(subject, SkillDescription):
        return
    posts = [condition.pattern for condition in subject.post]
    placed = [{p.subject, p.object} for p in posts if isinstance(p, Related)]
    for pattern in posts:
        match pattern:
            case Not(Related(relation, start, end)) if relation in known.ontology.relations:
                if known.ontology.is_placement(relation) and not any(ends & {start, end} for ends in placed):
                    what = f"postcondition not {relation}({start}, {end})"
                    yield Problem(f"{what}: everything is somewhere; say where it is then")
            case _:
                pass


def _rebuilt(subject: Subject, known: Known) -> Iterator[Problem]:
    match subject:
        case SkillDescription():
            for condition in subject.post:
                yield from _structural(condition, known.ontology)
        case Source():
            yield from _written(subject, known.ontology)
        case _:
            pass


def _structural(condition: Condition, ontology: Ontology) -> Iterator[Problem]:
    for effect in brought_about(condition):
        match effect:
            case Relate(relation) | Unrelate(relation) if _is_structure(relation, ontology):
                yield Problem(f"postcondition {condition} changes {relation}, what a thing is built of; {_INSTEAD}")
            case _:
                pass


_INSTEAD = "a thing that is moved gets another placement (in, on, at, held by, …)"


def _written(source: Source, ontology: Ontology) -> Iterator[Problem]:
    """Yields calls such as ``tx.relate(box, HAS_A, part)``."""
    for node in ast.walk(source.tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute) or len(node.args) < 2:
            continue
        relation = _value(node.args[1], source)
        if node.func.attr in ("relate", "unrelate", "place") and _is_structure(relation, ontology):
            text = f"it writes {relation}, what a thing is built of; {_INSTEAD}"
            yield Problem(text, Spot(source.file, node.lineno))


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


UNPLACED = Rule(
    "unplaced", Severity.ERROR, "An effect takes a thing from its place, and none says where it is.", _unplaced, True
)
MOVES_BY_STRUCTURE = Rule(
    "moves-by-structure", Severity.ERROR, "A thing is moved by changing what another one is built of.", _rebuilt
)
