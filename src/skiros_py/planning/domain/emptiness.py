"""Conditions that nothing is there: updated by the skills' effects if possible, otherwise expressed by a quantifier."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from skiros_py.planning.domain.literals import NOTHING
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.placing import shown
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import ELEMENT


@dataclass(frozen=True, slots=True)
class _Emptiness:
    """A precondition's requirement that nothing has a relation to a place of this class."""

    relation: str
    class_: str

    @property
    def predicate(self) -> str:
        return NOTHING + self.relation


def emptiness_classes(actions: Iterable[Action]) -> dict[str, str]:
    """Returns the class of place that each "nothing …" precondition asks about; after :func:`maintain_emptiness`."""
    return {e.predicate: e.class_ for e in _asked(actions)}


def maintain_emptiness(actions: Iterable[Action], ontology: Ontology) -> tuple[Action, ...]:
    """Adds what skills do to "nothing is there": filling ends it, taking the only thing restores it.

    This is sound if every action that fills such a place requires it to be empty before, and if it is known of each
    freed place whether it is such a place. Otherwise the precondition becomes a quantified one, which needs a planner
    that supports quantifiers. Things that are there already and stay neither fill nor free a place.
    """
    drafts = tuple(actions)
    for predicate in sorted({e.predicate for e in _asked(drafts)}):
        asked = [e for e in _asked(drafts) if e.predicate == predicate]
        if len(asked) == 1 and all(_keeps_track(action, asked[0], ontology) for action in drafts):
            drafts = tuple(_maintain(action, asked[0], ontology) for action in drafts)
        else:
            drafts = tuple(_with_quantifier(action, asked[0], ontology) for action in drafts)
    return drafts


def _asked(actions: Iterable[Action]) -> tuple[_Emptiness, ...]:
    found = (
        _Emptiness(atom.predicate.removeprefix(NOTHING), action.types[atom.arguments[0]])
        for action in actions
        for atom in action.pre
        if atom.predicate.startswith(NOTHING)
    )
    return tuple(dict.fromkeys(found))


def _places(atoms: Iterable[Atom], emptiness: _Emptiness, but: Iterable[Atom]) -> list[str]:
    return [atom.arguments[1] for atom in atoms if atom.predicate == emptiness.relation and atom not in but]


def _keeps_track(action: Action, emptiness: _Emptiness, ontology: Ontology) -> bool:
    types = action.types
    filled = _ends(action, emptiness, ontology)
    freed = (types[place] for place in _places(action.delete, emptiness, but=action.add))
    told = (_within(t, emptiness.class_, ontology) or not _overlap(t, emptiness.class_, ontology) for t in freed)
    return all(atom in action.pre for atom in filled) and all(told)


def _ends(action: Action, emptiness: _Emptiness, ontology: Ontology) -> tuple[Atom, ...]:
    types = action.types
    filled = (
        p for p in _places(action.add, emptiness, but=action.pre) if _overlap(types[p], emptiness.class_, ontology)
    )
    return tuple(Atom(emptiness.predicate, (place,)) for place in filled)


def _maintain(action: Action, emptiness: _Emptiness, ontology: Ontology) -> Action:
    types = action.types
    freed = (
        p for p in _places(action.delete, emptiness, but=action.add) if _within(types[p], emptiness.class_, ontology)
    )
    starts = tuple(Atom(emptiness.predicate, (place,)) for place in freed)
    ends = _ends(action, emptiness, ontology)
    added = [f"effect {shown(atom)}: it held one thing only" for atom in starts]
    ended = [f"effect not {shown(atom)}: something is there now" for atom in ends]
    notes = (*action.notes, *added, *ended)
    return replace(action, add=action.add + starts, delete=action.delete + ends, notes=notes)


def _with_quantifier(action: Action, emptiness: _Emptiness, ontology: Ontology) -> Action:
    asked = [atom for atom in action.pre if atom.predicate == emptiness.predicate]
    class_ = ontology.relations[emptiness.relation].domain or ELEMENT
    none = []
    for atom in asked:
        (place,) = atom.arguments
        holder = f"?{place.lstrip('?')} holder #{emptiness.relation}"
        none.append(NoneSuch((Variable(holder, class_),), (Atom(emptiness.relation, (holder, place)),)))
    notes = tuple(f"precondition {shown(atom)} with a quantifier: not every skill keeps track of it" for atom in asked)
    pre = tuple(atom for atom in action.pre if atom not in asked)
    return replace(action, pre=pre, none=(*action.none, *none), notes=(*action.notes, *notes))


def _overlap(one: str, other: str, ontology: Ontology) -> bool:
    return _within(one, other, ontology) or _within(other, one, ontology)


def _within(class_: str, other: str, ontology: Ontology) -> bool:
    """Returns whether all things of a class are of another; no class stands for any thing."""
    return not other or (bool(class_) and ontology.is_a(class_, other))
