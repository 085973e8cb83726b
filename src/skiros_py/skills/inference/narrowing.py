"""What a pattern leaves of one variable, when all its others are bound: from the index wherever that can say it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from skiros_py.skills.conditions import AllOf, AnyOf, Binding, Computed, Exists, Not, Nothing, Pattern, Related
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView


def conjuncts(pattern: Pattern) -> tuple[Pattern, ...]:
    """Returns the patterns that must all hold for this one to hold."""
    if isinstance(pattern, AllOf):
        return tuple(part for inner in pattern.patterns for part in conjuncts(inner))
    return (pattern,)


def is_indexed(pattern: Pattern, ontology: Ontology) -> bool:
    """Tells whether :func:`candidates` gives exactly what fits, as soon as one end of the pattern is bound."""
    if not isinstance(pattern, Related) or pattern.subject == pattern.object:
        return False
    return ontology.family(pattern.relation) is not Family.COMPUTED


def candidates(pattern: Pattern, name: str, binding: Binding, view: WorldView) -> tuple[str, ...] | None:
    """Returns all elements for which a pattern may hold, sorted; None where no index can say.

    Args:
        pattern: The pattern.
        name: The variable that is looked for.
        binding: The others, as far as they are bound.
        view: The world.
    """
    match pattern:
        case Related():
            return _at_other_end(pattern, name, binding, view) if is_indexed(pattern, view.ontology) else None
        case AllOf(patterns):
            found = [c for p in patterns if (c := candidates(p, name, binding, view)) is not None]
            return tuple(sorted(set(found[0]).intersection(*found[1:]))) if found else None
        case AnyOf(patterns):
            return _united(candidates(p, name, binding, view) for p in patterns)
        case Exists():
            return _through(pattern, name, binding, view)
        case _:
            return None


def that_fit(pattern: Pattern, name: str, values: Sequence[str], binding: Binding, view: WorldView) -> tuple[str, ...]:
    """Returns those values of a variable for which a pattern holds, in their order; all its others are bound."""
    match pattern:
        case Nothing(relation, _):
            return tuple(value for value in values if not view.subjects(relation, value))
        case Computed():
            held = _computed(pattern, name, values, binding, view)
            return tuple(value for value in values if value in held)
        case Not(inner):
            held = frozenset(that_fit(inner, name, values, binding, view))
            return tuple(value for value in values if value not in held)
        case _:
            return tuple(value for value in values if pattern.evaluate(view, {**binding, name: value}))


def _at_other_end(pattern: Related, name: str, binding: Binding, view: WorldView) -> tuple[str, ...] | None:
    if pattern.subject == name and pattern.object in binding:
        return view.subjects(pattern.relation, binding[pattern.object])
    if pattern.object == name and pattern.subject in binding:
        return view.objects(binding[pattern.subject], pattern.relation)
    return None


def _united(parts: Iterable[tuple[str, ...] | None]) -> tuple[str, ...] | None:
    found: set[str] = set()
    for part in parts:
        if part is None:
            return None
        found.update(part)
    return tuple(sorted(found))


def _through(pattern: Exists, name: str, binding: Binding, view: WorldView) -> tuple[str, ...] | None:
    """What can be reached by way of the element that must exist: the robot of a deck on which the kit stands."""
    outside = {key: value for key, value in binding.items() if key != pattern.variable}
    between = candidates(pattern.pattern, pattern.variable, outside, view)
    if between is None or name == pattern.variable:
        return None
    fitting = (e for e in between if view.ontology.is_a(view.element(e).type, pattern.class_))
    return _united(candidates(pattern.pattern, name, {**outside, pattern.variable: e}, view) for e in fitting)


def _computed(pattern: Computed, name: str, values: Sequence[str], binding: Binding, view: WorldView) -> frozenset[str]:
    """Asks for all values together, but for the other end itself: reasoners leave that out of many."""
    ends = {pattern.subject, pattern.object} - {name}
    other = binding[ends.pop()] if ends else None
    alone = values if other is None else [value for value in values if value == other]
    held = {value for value in alone if pattern.evaluate(view, {**binding, name: value})}
    if other is None:
        return frozenset(held)
    apart = tuple(value for value in values if value != other)
    if pattern.subject == name:
        return frozenset(held.union(subject for subject, _ in pattern.pairs(view, apart, (other,))))
    return frozenset(held.union(object_ for _, object_ in pattern.pairs(view, (other,), apart)))
