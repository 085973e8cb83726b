"""Why something cannot be: a smallest set of axioms that already makes it so.

Found by leaving axioms out while the contradiction stays (nothing is known of how the reasoner works). The quicker,
incomplete reasoner is asked first; where it does not see the contradiction, the complete one is asked a bounded number
of times. The same files give the same explanation.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import pyoxigraph as ox

from skiros_py.world.ontology.check.axioms import Axiom, Axioms, triples_of
from skiros_py.world.ontology.check.logic import NoAnswer, Reasoner

__all__ = ["Explainer", "Explanation"]

_QUESTIONS = 60
"""Questions put to the complete reasoner for one explanation; each takes some tenths of a second."""

_Sees = Callable[[Sequence[Axiom]], bool]


@dataclass(frozen=True, slots=True)
class Explanation:
    """Axioms that together cannot be.

    Attributes:
        axioms: They, in file order; none where none were found in time.
        smallest: False when time or questions ran out before every one was shown to be needed.
    """

    axioms: tuple[Axiom, ...]
    smallest: bool


class Explainer:
    """Explains contradictions among axioms.

    Args:
        axioms: What the files say.
        reasoners: Whom to ask, the quickest first.
    """

    def __init__(self, axioms: Axioms, reasoners: Sequence[Reasoner]) -> None:
        self._axioms = axioms
        self._reasoners = reasoners

    def explain(self, said: Sequence[Axiom], near: Iterable[str], assumed: Sequence[ox.Triple] = ()) -> Explanation:
        """Returns a smallest part of the axioms that contradicts itself, or what is assumed.

        Args:
            said: Axioms that are known to be in contradiction.
            near: IRIs of terms or individuals to begin at.
            assumed: Statements that always count, such as that there is something of a class.
        """
        areas = [*_areas(said, frozenset(near)), tuple(said)]
        for reasoner in self._reasoners:
            sees = self._sight(reasoner, assumed)
            # Of the complete reasoner it is known that it sees the contradiction in everything.
            if reasoner.is_complete or _ask(sees, areas[-1]):
                return _contracted(_first_seen(areas, sees), sees)
        return Explanation((), smallest=False)

    def _sight(self, reasoner: Reasoner, assumed: Sequence[ox.Triple]) -> _Sees:
        """The question whether some axioms contradict each other, which may be put a bounded number of times."""
        given = [*self._axioms.declarations, *assumed]
        left = _QUESTIONS

        def sees(axioms: Sequence[Axiom]) -> bool:
            nonlocal left
            left -= reasoner.is_complete
            if left < 0:
                raise NoAnswer(f"{reasoner.name} was asked often enough")
            return not reasoner.consistent([*given, *triples_of(axioms)])

        return sees


def _ask(sees: _Sees, axioms: Sequence[Axiom]) -> bool:
    try:
        return sees(axioms)
    except NoAnswer:
        return False


def _first_seen(areas: Sequence[tuple[Axiom, ...]], sees: _Sees) -> tuple[Axiom, ...]:
    """The smallest of ever larger areas in which the contradiction is seen; in the last it is."""
    return areas[bisect_left(range(len(areas) - 1), True, key=lambda index: _ask(sees, areas[index]))]


def _contracted(axioms: Sequence[Axiom], sees: _Sees) -> Explanation:
    """Leaves out ever smaller pieces while the contradiction stays; at the end each axiom was tried on its own."""
    kept = list(axioms)
    size = max(len(kept) // 2, 1)
    try:
        while True:
            start = 0
            while start < len(kept):
                without = kept[:start] + kept[start + size :]
                if sees(without):
                    kept = without
                else:
                    start += size
            if size == 1:
                return Explanation(tuple(kept), smallest=True)
            size = max(min(size // 2, len(kept) // 2), 1)
    except NoAnswer:
        return Explanation(tuple(kept), smallest=False)


def _areas(said: Sequence[Axiom], near: frozenset[str]) -> Iterator[tuple[Axiom, ...]]:
    """Ever larger parts of the axioms around some names: what is said of them, then what mentions them."""
    for touches in (_is_about, _mentions):
        names, count = near, -1
        while True:
            area = tuple(axiom for axiom in said if touches(axiom, names))
            if len(area) == count:
                break
            yield area
            names, count = names.union(*(axiom.names() for axiom in area)), len(area)


def _is_about(axiom: Axiom, names: frozenset[str]) -> bool:
    subject = axiom.subject
    return subject in names if subject is not None else _mentions(axiom, names)


def _mentions(axiom: Axiom, names: frozenset[str]) -> bool:
    return not names.isdisjoint(axiom.names())
