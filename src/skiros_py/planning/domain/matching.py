"""Makes atoms with variables true by facts: the join behind explanations and regrounding."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from skiros_py.planning.domain.model import Atom, NoneSuch

Fits = Callable[[str, str], bool]
"""Tells whether an element is of a class."""


def bindings(
    atoms: Sequence[Atom],
    facts: Mapping[str, Sequence[Atom]],
    start: Mapping[str, str],
    types: Mapping[str, str],
    fits: Fits,
) -> Iterator[dict[str, str]]:
    """Yields every way to bind variables so that all atoms are facts.

    Args:
        atoms: Atoms over variables ("?Robot") and elements.
        facts: Facts by predicate; a predicate may gain facts while this is read.
        start: What is bound already.
        types: Class by variable.
        fits: Tells whether an element is of a class.
    """
    if not atoms:
        yield dict(start)
        return
    for fact in list(facts.get(atoms[0].predicate, ())):
        matched = _match(atoms[0], fact, start, types, fits)
        if matched is not None:
            yield from bindings(atoms[1:], facts, matched, types, fits)


def are_none(
    none: Iterable[NoneSuch], facts: Mapping[str, Sequence[Atom]], binding: Mapping[str, str], fits: Fits
) -> bool:
    """Tells whether there are no such things among the facts.

    Args:
        none: What there must not be.
        facts: Facts by predicate.
        binding: What the variables around are bound to.
        fits: Tells whether an element is of a class.
    """
    for such in none:
        types = {variable.name: variable.type for variable in such.variables}
        if next(bindings(such.bind(binding).atoms, facts, {}, types, fits), None) is not None:
            return False
    return True


def _match(
    atom: Atom, fact: Atom, binding: Mapping[str, str], types: Mapping[str, str], fits: Fits
) -> dict[str, str] | None:
    result = dict(binding)
    for argument, value in zip(atom.arguments, fact.arguments, strict=True):
        if not argument.startswith("?"):
            if argument != value:
                return None
        elif result.setdefault(argument, value) != value or not fits(value, types.get(argument, "")):
            return None
    return result
