"""Checks a skill against the ontology and the primitives that are there, before it is offered to anybody."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, fields
from typing import Any

from skiros_py.skills.composition import AssertEffects, Do, Fallback, Node, P, Retry, Sequence
from skiros_py.skills.conditions import AllOf, AnyOf, Computed, Exists, Has, Not, Nothing, Pattern, Related
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

__all__ = ["problems_of"]


def problems_of(
    skill: Skill,
    ontology: Ontology,
    primitives: Mapping[str, type[Primitive[Any]]],
    reasoners: Reasoners = NO_REASONERS,
) -> tuple[str, ...]:
    """Returns what is wrong with a skill: words that no ontology declares, questions and calls that nobody answers."""
    description = skill.description
    classes = [(f"parameter {p.key}", p.type) for p in description.params if p.is_element]
    found = [f"{where}: no ontology declares the class {c}" for where, c in classes if c not in ontology.classes]
    for condition in (*description.pre, *description.hold, *description.post):
        problems = (*_undeclared(condition.pattern, ontology), *_uncomputed(condition.pattern, reasoners))
        found += [f"condition {condition}: {problem}" for problem in problems]
    found += _unplaced(skill, ontology)
    keys = [p.key for p in description.params]
    for node in (skill.pre_sense, skill.body, skill.finish):
        found += _in_body(node, keys, primitives) if node is not None else []
    return tuple(found)


def _unplaced(skill: Skill, ontology: Ontology) -> Iterator[str]:
    """Yields effects that take something from its place without saying where it is then."""
    posts = [condition.pattern for condition in skill.description.post]
    placed = [{p.subject, p.object} for p in posts if isinstance(p, Related)]
    for pattern in posts:
        match pattern:
            case Not(Related(relation, subject, object_)) if relation in ontology.relations:
                if ontology.is_placement(relation) and not any(ends & {subject, object_} for ends in placed):
                    what = f"postcondition not {relation}({subject}, {object_})"
                    yield f"{what}: everything is somewhere; say where it is then"
            case _:
                pass


def _undeclared(pattern: Pattern, ontology: Ontology) -> Iterator[str]:
    match pattern:
        case Related(relation, _, _) | Nothing(relation, _) | Computed(relation, _, _, _):
            yield from _missing("relation", relation, ontology.relations)
        case Has(property_, _):
            yield from _missing("property", property_, ontology.properties)
        case Exists(_, class_, inner):
            yield from _missing("class", class_, ontology.classes)
            yield from _undeclared(inner, ontology)
        case Not(inner):
            yield from _undeclared(inner, ontology)
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from _undeclared(part, ontology)
        case _:
            yield f"its pattern {type(pattern).__name__} is not known"


def _uncomputed(pattern: Pattern, reasoners: Reasoners) -> Iterator[str]:
    match pattern:
        case Computed(relation, _, _, None) if not reasoners.computes(relation):
            yield f"no reasoner computes {relation}, and no function is given for it"
        case Exists(_, _, inner) | Not(inner):
            yield from _uncomputed(inner, reasoners)
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from _uncomputed(part, reasoners)
        case _:
            pass


def _missing(kind: str, word: str, declared: Collection[str]) -> Iterator[str]:
    if word not in declared:
        yield f"no ontology declares the {kind} {word}"


def _in_body(node: Node, keys: Collection[str], primitives: Mapping[str, type[Primitive[Any]]]) -> list[str]:
    match node:
        case Do(name, arguments):
            return _in_call(name, arguments, keys, primitives)
        case Sequence(children) | Fallback(children):
            return [problem for child in children for problem in _in_body(child, keys, primitives)]
        case Retry(child, _):
            return _in_body(child, keys, primitives)
        case AssertEffects():
            return []


def _in_call(
    name: str, arguments: Mapping[str, Any], keys: Collection[str], primitives: Mapping[str, type[Primitive[Any]]]
) -> list[str]:
    if name not in primitives:
        return [f"there is no primitive '{name}'; there is {', '.join(sorted(primitives)) or 'none'}"]
    own = {field.name: field for field in fields(primitives[name].Params)}
    needed = [n for n, f in own.items() if f.default is MISSING and f.default_factory is MISSING and n not in arguments]
    unknown = [f"primitive '{name}' needs {key}" for key in needed]
    unknown += [f"primitive '{name}' has no parameter {key}" for key in arguments if key not in own]
    strays = [v.key for v in arguments.values() if isinstance(v, P) and v.key not in keys]
    return unknown + [f"'{name}' asks for {key}, which is no parameter of the skill" for key in strays]
