"""Matches atoms with variables against facts."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Protocol

from skiros_py.planning.domain.model import Atom
from skiros_py.world.ontology import Ontology

Binding = Mapping[str, str]
"""Element by variable."""
Fits = Callable[[str, str], bool]
"""Returns whether an element is of a class."""


class FactIndex:
    """Ground atoms, indexed by predicate and by each argument."""

    def __init__(self, facts: Iterable[Atom] = ()) -> None:
        self._all: dict[Atom, None] = {}
        self._by_predicate: dict[str, list[Atom]] = {}
        self._by_argument: dict[tuple[str, int, str], list[Atom]] = {}
        for fact in facts:
            self.add(fact)

    def __contains__(self, atom: object) -> bool:
        return atom in self._all

    def __iter__(self) -> Iterator[Atom]:
        return iter(self._all)

    def add(self, atom: Atom) -> None:
        """Adds a new fact."""
        self._all[atom] = None
        self._by_predicate.setdefault(atom.predicate, []).append(atom)
        for position, argument in enumerate(atom.arguments):
            self._by_argument.setdefault((atom.predicate, position, argument), []).append(atom)

    def candidates(self, atom: Atom) -> Collection[Atom]:
        """Returns a superset of the facts that match an atom with variables: the shortest indexed list."""
        bound = [(i, a) for i, a in enumerate(atom.arguments) if not is_variable(a)]
        if len(bound) == len(atom.arguments):
            return (atom,) if atom in self._all else ()
        if not bound:
            return self._by_predicate.get(atom.predicate, ())
        return min((self._by_argument.get((atom.predicate, i, a), ()) for i, a in bound), key=len)


def fitting(objects: Mapping[str, str], ontology: Ontology) -> Fits:
    """Returns the function that tells of which classes objects are: all of the empty one, other names of none."""
    is_a = cache(ontology.is_a)
    return lambda name, class_: class_ in ("", "object") or (name in objects and is_a(objects[name], class_))


def is_variable(argument: str) -> bool:
    """Returns whether an argument is a variable, not an element."""
    return argument.startswith("?")


def unified(atom: Atom, fact: Atom, binding: Binding, types: Mapping[str, str], fits: Fits) -> dict[str, str] | None:
    """Extends a binding so that an atom matches a fact; None if impossible."""
    result = dict(binding)
    for argument, value in zip(atom.arguments, fact.arguments, strict=True):
        if not is_variable(argument):
            if argument != value:
                return None
        elif result.setdefault(argument, value) != value or not fits(value, types.get(argument, "")):
            return None
    return result


class Facts(Protocol):
    """Where facts are looked up."""

    def candidates(self, atom: Atom) -> Collection[Atom]:
        """Returns a superset of the facts that match an atom with variables."""


def solutions(
    atoms: Sequence[Atom], facts: Facts, start: Binding, types: Mapping[str, str], fits: Fits
) -> Iterator[dict[str, str]]:
    """Yields every way to bind variables so that all atoms are facts; the rarest atom is looked up first.

    Args:
        atoms: Atoms over variables and elements.
        facts: The facts.
        start: The initial binding.
        types: Class by variable.
        fits: Tells whether an element is of a class.
    """
    if not atoms:
        yield dict(start)
        return
    found = [facts.candidates(atom.bind(start)) for atom in atoms]
    rarest = min(range(len(atoms)), key=lambda i: len(found[i]))
    rest = [atom for i, atom in enumerate(atoms) if i != rarest]
    for fact in tuple(found[rarest]):
        binding = unified(atoms[rarest], fact, start, types, fits)
        if binding is not None:
            yield from solutions(rest, facts, binding, types, fits)
