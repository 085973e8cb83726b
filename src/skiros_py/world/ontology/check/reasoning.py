"""Contradictions found by reasoners, explained."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import pyoxigraph as ox

from skiros_py.world.ontology.check.axioms import Axiom, axioms_of, in_words, place_of, triples_of
from skiros_py.world.ontology.check.material import Finding, FindingKind, Material, Severity, finding_of
from skiros_py.world.ontology.check.owl_reasoner import NoAnswer, OwlReasoner, Verdict, one_of
from skiros_py.world.terms import Kind, closure

_QUESTIONS = 60
"""Maximum number of questions to the complete reasoner for one explanation; each takes some tenths of a second."""

_Sees = Callable[[Sequence[Axiom]], bool]


@dataclass(frozen=True, slots=True)
class Explanation:
    """Axioms that together cannot be.

    Attributes:
        axioms: The axioms, in file order; none if none were found in time.
        smallest: False if time or questions ran out before each was shown to be necessary.
    """

    axioms: tuple[Axiom, ...]
    smallest: bool


def _ask(sees: _Sees, axioms: Sequence[Axiom]) -> bool:
    try:
        return sees(axioms)
    except NoAnswer:
        return False


def _contracted(axioms: Sequence[Axiom], sees: _Sees) -> Explanation:
    """Removes ever smaller pieces while the contradiction remains; finally each axiom is tried on its own."""
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
    """Growing sets of axioms around some names: axioms about them, then axioms that mention them."""
    for touches in (_is_about, _mentions):
        names, count = near, -1
        while True:
            area = tuple(axiom for axiom in said if touches(axiom, names))
            if len(area) == count:
                break
            yield area
            names, count = names.union(*(axiom.names() for axiom in area)), len(area)


def _is_about(axiom: Axiom, names: frozenset[str]) -> bool:
    subject = axiom.head.subject
    return subject in names if subject is not None else _mentions(axiom, names)


def _mentions(axiom: Axiom, names: frozenset[str]) -> bool:
    return not names.isdisjoint(axiom.names())


# ---------------------------------------------------------------- findings


_CONTRADICTIONS = 10
"""Maximum number of contradictions searched; the rest appears once these are fixed."""
_CLASSES = 50
"""Maximum number of unsatisfiable classes reported one by one; of more, only the number is reported."""
_STATEMENTS = 30
"""Maximum number of statements shown of an explanation that is not a smallest one."""


def logical_findings(material: Material, reasoner: OwlReasoner, helpers: Sequence[OwlReasoner] = ()) -> list[Finding]:
    """Returns contradictions in the files, and unsatisfiable classes.

    Args:
        material: The files.
        reasoner: The reasoner.
        helpers: Faster reasoners that may explain its findings.

    Raises:
        NoAnswer: The reasoner found no answer.
    """
    return _Reasoning(material, reasoner, helpers).findings()


class _Reasoning:
    def __init__(self, material: Material, reasoner: OwlReasoner, helpers: Sequence[OwlReasoner]) -> None:
        self._material = material
        self._axioms = axioms_of(material)
        self._reasoner = reasoner
        self._helpers = helpers

    def findings(self) -> list[Finding]:
        found: list[Finding] = []
        said = list(self._axioms.said)
        verdict = self._judge(said)
        while not verdict.consistent:
            near = verdict.near or [a.head.subject for a in said if a.is_assertion and a.head.subject]
            why = self._explain(said, near)
            found.append(self._contradiction(why, verdict))
            said = _without(said, why)
            if len(found) == _CONTRADICTIONS or not why.smallest:
                return found
            try:
                verdict = self._judge(said)
            except NoAnswer as answer:
                return [*found, _silence(str(answer))]
        return found + list(self._impossible(verdict, said))

    def _judge(self, said: Sequence[Axiom]) -> Verdict:
        """Returns the verdict on axioms, with names instead of IRIs."""
        classes = sorted(self._material.names.iri(name) for name in self._material.declared[Kind.CLASS])
        verdict = self._reasoner.judge([*self._axioms.declarations, *triples_of(said)], classes)
        unsatisfiable, near = (tuple(map(self._material.names.name, f)) for f in (verdict.unsatisfiable, verdict.near))
        return Verdict(verdict.consistent, unsatisfiable, near)

    def _explain(self, said: Sequence[Axiom], near: Iterable[str], assumed: Sequence[ox.Triple] = ()) -> Explanation:
        """Returns a smallest subset of the axioms that contradicts itself, or the assumptions.

        Args:
            said: Axioms that are known to contradict each other.
            near: Names of terms or individuals to start from.
            assumed: Statements that are always included, such as that a class has an individual.
        """
        areas = [*_areas(said, frozenset(near)), tuple(said)]
        for reasoner in (*self._helpers, self._reasoner):
            sees = self._sight(reasoner, assumed)
            # The complete reasoner is known to find the contradiction in all axioms.
            if reasoner.is_complete or _ask(sees, areas[-1]):
                # The smallest of the growing areas in which it is found.
                first = bisect_left(range(len(areas) - 1), True, key=lambda at: _ask(sees, areas[at]))
                return _contracted(areas[first], sees)
        return Explanation((), smallest=False)

    def _sight(self, reasoner: OwlReasoner, assumed: Sequence[ox.Triple]) -> _Sees:
        """Returns a test whether axioms contradict each other, with a limited number of calls."""
        given = [*self._axioms.declarations, *assumed]
        left = _QUESTIONS

        def sees(axioms: Sequence[Axiom]) -> bool:
            nonlocal left
            left -= reasoner.is_complete
            if left < 0:
                raise NoAnswer(f"{reasoner.name} was asked too often")
            return not reasoner.judge([*given, *triples_of(axioms)]).consistent

        return sees

    def _contradiction(self, why: Explanation, verdict: Verdict) -> Finding:
        said = why.axioms
        at = next((axiom for axiom in said if axiom.is_assertion), said[0] if said else None)
        name = verdict.near[0] if verdict.near else (at.head.subject or "" if at is not None else "")
        text = f"{name or 'what the files say'} cannot be: these statements contradict each other"
        return self._finding(FindingKind.INCONSISTENT, name, text, at, why)

    def _impossible(self, verdict: Verdict, said: Sequence[Axiom]) -> Iterator[Finding]:
        """The unsatisfiable classes: first those that no superclass explains."""
        impossible = frozenset(verdict.unsatisfiable)
        above = {class_: self._above(class_, impossible) for class_ in verdict.unsatisfiable}
        ordered = sorted(verdict.unsatisfiable, key=lambda class_: above[class_] is not None)
        for class_ in ordered[:_CLASSES]:
            upper = above[class_]
            yield self._excluded(class_, said) if upper is None else self._below(class_, upper)
        if len(ordered) > _CLASSES:
            text = f"nothing can be of {len(ordered) - _CLASSES} more classes: fix these first"
            yield Finding(Severity.ERROR, FindingKind.UNSATISFIABLE, "", text)

    def _below(self, class_: str, above: str) -> Finding:
        text = f"nothing can be a {class_}, because nothing can be a {above}, which is above it"
        return finding_of(self._material.at_declaration(class_, text), FindingKind.UNSATISFIABLE, class_)

    def _excluded(self, class_: str, said: Sequence[Axiom]) -> Finding:
        why = self._explain(said, [class_], [one_of(self._material.names.iri(class_))])
        at = next((axiom for axiom in why.axioms if axiom.head.subject == class_), None)
        text = f"nothing can be a {class_}: these statements exclude it"
        if at is None:
            fault = self._material.at_declaration(class_, text)
            return finding_of(fault, FindingKind.UNSATISFIABLE, class_, why=self._words(why))
        return self._finding(FindingKind.UNSATISFIABLE, class_, text, at, why)

    def _above(self, class_: str, impossible: frozenset[str]) -> str | None:
        """A direct superclass that is unsatisfiable, too, unless both are above each other."""
        for above in sorted(set(self._material.parents.get(class_, ()))):
            if above in impossible and class_ not in closure(self._material.parents, above):
                return above
        return None

    def _finding(self, kind: FindingKind, name: str, text: str, at: Axiom | None, why: Explanation) -> Finding:
        place = place_of(at, self._material) if at is not None else None
        file, line = (place.path, place.line) if place is not None else (None, None)
        return Finding(Severity.ERROR, kind, name, text, file, line, self._words(why))

    def _words(self, why: Explanation) -> tuple[str, ...]:
        if why.smallest:
            return tuple(in_words(axiom, self._material) for axiom in why.axioms)
        shown = [in_words(axiom, self._material) for axiom in why.axioms[:_STATEMENTS]]
        hidden = len(why.axioms) - len(shown)
        more = [f"… and {hidden} more"] if hidden else []
        return (*shown, *more, "(time or questions ran out before it was known which statements are necessary)")


def _without(said: Sequence[Axiom], why: Explanation) -> list[Axiom]:
    """The axioms without an explained contradiction: without its assertions, or else without all its axioms."""
    assertions = {id(axiom) for axiom in why.axioms if axiom.is_assertion}
    gone = assertions or {id(axiom) for axiom in why.axioms}
    return [axiom for axiom in said if id(axiom) not in gone]


def _silence(reason: str) -> Finding:
    return Finding(Severity.WARNING, FindingKind.REASONER, "", f"there may be more: {reason}")
