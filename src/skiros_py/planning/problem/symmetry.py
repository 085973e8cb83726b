"""Things that differ by name only: as many of them as a goal can use are enough, without losing a plan."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from skiros_py.planning.domain.literals import NOTHING
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.problem.lifted import Lifted

_OWN = "#"
"""Stands for a thing itself in what is said of it; no id is this."""

_Sign = tuple[str, frozenset[tuple[str, tuple[str, ...]]]]


def superfluous(
    objects: Mapping[str, str],
    init: Iterable[Atom],
    actions: Sequence[Action],
    lifted: Lifted,
    named: Collection[str],
) -> frozenset[str]:
    """Returns the elements that no plan needs, since others are there for which the very same holds.

    Only things are left out of which whatever is done to one helps nothing that does not speak of it: then a plan
    without idle steps handles at most those that the goal's own variables stand for.

    Args:
        objects: The elements, with their classes.
        init: What holds at the start.
        actions: The actions of the task.
        lifted: The same.
        named: Elements that the task speaks of by name.
    """
    wanted = {type_: _demand(type_, actions, lifted) for type_ in sorted(set(objects.values()))}
    passive = {type_ for type_ in wanted if wanted[type_] and lifted.is_passive(type_)}
    facts = tuple(init)
    standing = _in_the_way(facts, objects, actions, lifted)
    alike: dict[_Sign, list[str]] = {}
    free = [o for o, type_ in objects.items() if type_ in passive and o not in named and o not in standing]
    for thing, sign in _signs(free, objects, facts).items():
        alike.setdefault(sign, []).append(thing)
    return frozenset(thing for (type_, _), things in alike.items() for thing in sorted(things)[wanted[type_] :])


def _demand(type_: str, actions: Iterable[Action], lifted: Lifted) -> int:
    """How many things of a class the goal's variables can stand for at once."""
    closing = (action for action in actions if action.skill is None)
    return sum(lifted.overlap(type_, variable.type) for action in closing for variable in action.parameters)


def _in_the_way(
    init: Iterable[Atom], objects: Mapping[str, str], actions: Iterable[Action], lifted: Lifted
) -> frozenset[str]:
    """The things that are where somebody may want nothing to be."""
    asked = {
        (atom.predicate.removeprefix(NOTHING), action.types.get(atom.arguments[0], ""))
        for action in actions
        for atom in action.pre
        if atom.predicate.startswith(NOTHING)
    }
    placed = (atom for atom in init if any(relation == atom.predicate for relation, _ in asked))
    return frozenset(
        atom.arguments[0]
        for atom in placed
        if any(r == atom.predicate and lifted.overlap(c, objects[atom.arguments[1]]) for r, c in asked)
    )


def _signs(things: Iterable[str], objects: Mapping[str, str], init: Iterable[Atom]) -> dict[str, _Sign]:
    """What holds of each thing, in words that do not name it."""
    said: dict[str, set[tuple[str, tuple[str, ...]]]] = {thing: set() for thing in things}
    for atom in init:
        for thing in said.keys() & set(atom.arguments):
            own = tuple(_OWN if argument == thing else argument for argument in atom.arguments)
            said[thing].add((atom.predicate, own))
    return {thing: (objects[thing], frozenset(facts)) for thing, facts in said.items()}
