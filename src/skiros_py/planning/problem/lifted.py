"""Actions indexed for backward search, and the elements to try first for an open parameter."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple

from skiros_py.planning.domain.literals import CAN, NOTHING, Asked
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.skills.conditions import Not
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import STRUCTURE


class Slot(NamedTuple):
    """An argument of an action: a variable, or an element that its atoms name."""

    action: str
    variable: str


class Lifted:
    """The actions of a task, indexed by adds, deletes and preconditions.

    Args:
        actions: All there are; their names are unique.
        view: The world.
        asked: The evaluated literals, by predicate.

    Attributes:
        view, asked: The same.
        overlap: Returns whether something may be of both classes.
    """

    def __init__(self, actions: Sequence[Action], view: WorldView, asked: Mapping[str, Asked | Not]) -> None:
        self.view = view
        self.asked = asked
        self._ontology = view.ontology
        self.actions = {action.name: action for action in actions}
        self.types = {action.name: action.types for action in actions}
        self._adding: dict[str, list[tuple[Action, Atom]]] = {}
        self._deleting: dict[str, list[tuple[Action, Atom]]] = {}
        self._needing: dict[Slot, list[Atom]] = {}
        self._givers: dict[tuple[str, Atom], tuple[tuple[Action, Atom], ...]] = {}
        self.overlap: Callable[[str, str], bool] = cache(view.ontology.overlap)
        for action in actions:
            for table, atoms in ((self._adding, action.add), (self._deleting, action.delete)):
                for atom in atoms:
                    table.setdefault(atom.predicate, []).append((action, atom))
            for atom in action.pre:
                for argument in dict.fromkeys(atom.arguments):
                    self._needing.setdefault(Slot(action.name, argument), []).append(atom)

    def needs(self, slot: Slot) -> Sequence[Atom]:
        """Returns the preconditions that contain an argument."""
        return self._needing.get(slot, ())

    def class_of(self, slot: Slot) -> str:
        """Returns the class of an argument; "" for anything."""
        return self.types[slot.action].get(slot.variable, "")

    def fits(self, type_: str, slot: Slot) -> bool:
        """Returns True when elements of a class may be an argument."""
        class_ = self.class_of(slot)
        return class_ in ("", "object") or self._ontology.is_a(type_, class_)

    def is_stored(self, predicate: str) -> bool:
        """Returns True for a relation whose facts are in the world itself."""
        relation = self._ontology.relations.get(predicate)
        return relation is not None and predicate not in self.asked and relation.family is not Family.COMPUTED

    def is_changed(self, predicate: str) -> bool:
        """Returns True when some action adds facts of this kind."""
        return predicate in self._adding

    def is_determined(self, atom: Atom, variable: str) -> bool:
        """Returns True when an argument leaves one value at most for the atom's other: its place, its owner."""
        relation = self._ontology.relations[atom.predicate]
        at_subject = atom.arguments[0] == variable
        if relation.family is Family.PLACEMENT:
            return at_subject == (relation.place_end == "object")
        if atom.predicate in self._ontology.sub_relations(STRUCTURE):
            return not at_subject
        return at_subject and relation.functional

    def givers(self, action: Action, atom: Atom) -> tuple[tuple[Action, Atom], ...]:
        """Returns the actions, with the effect, that could achieve a precondition, judging by classes."""
        key = action.name, atom
        if key not in self._givers:
            self._givers[key] = tuple(self._giving(action, atom))
        return self._givers[key]

    def _giving(self, action: Action, atom: Atom) -> Iterator[tuple[Action, Atom]]:
        own = self.types[action.name]
        for giver, effect in self._adding.get(atom.predicate, ()):
            types = self.types[giver.name]
            pairs = zip(atom.arguments, effect.arguments, strict=True)
            if all(self.overlap(own.get(a, ""), types.get(b, "")) for a, b in pairs):
                yield giver, effect

    def breakers(self, atom: Atom) -> Sequence[tuple[Action, Atom]]:
        """Returns the actions, with the effect, that delete facts of an atom's kind."""
        return self._deleting.get(atom.predicate, ())

    def is_passive(self, class_: str) -> bool:
        """Returns True when actions on a thing of this class only help conditions about that thing.

        A plan then needs only such things that the goal mentions or that block something.
        """
        return all(self._leaves_alone(action, class_) for action in self.actions.values())

    def _leaves_alone(self, action: Action, class_: str) -> bool:
        if any(self.overlap(variable.type, class_) for none in action.none for variable in none.variables):
            return False
        own = [variable.name for variable in action.parameters if self.overlap(variable.type, class_)]
        if not own or action.skill is None:
            return True
        return len(own) == 1 and all(own[0] in a.arguments or a.predicate.startswith(NOTHING) for a in action.add)


def partners(view: WorldView, atom: Atom, variable: str, element: str) -> tuple[str, ...]:
    """Returns the current partners of an element, as one argument of the atom, in a stored relation."""
    subject, _ = atom.arguments
    return view.objects(element, atom.predicate) if subject == variable else view.subjects(atom.predicate, element)


def other(atom: Atom, variable: str) -> str:
    """Returns the other argument of an atom of two."""
    return atom.arguments[1] if atom.arguments[0] == variable else atom.arguments[0]


_PAGE = 64
_LOOKED_AT = 256
"""How many elements of a class are examined per required one before unlikely ones are accepted."""
_TRIED = 4
"""With how many elements a computed relation is tried before a thing counts as unlikely."""

Found = Callable[[Slot], Collection[str]]
"""Returns the known candidates of an argument."""


class Candidates:
    """Chooses elements of a class heuristically; a wrong guess only costs time.

    Args:
        lifted: The actions.
        agents: The agents that have a skill, by predicate ("can_pick").
        found: The known candidates of other arguments.
    """

    def __init__(self, lifted: Lifted, agents: Mapping[str, Collection[str]], found: Found) -> None:
        self._view = lifted.view
        self._lifted = lifted
        self._asked = lifted.asked
        self._agents = agents
        self._found = found
        self._known: dict[tuple[Slot, str], bool] = {}

    def of_class(self, slot: Slot, limit: int, known: Collection[str]) -> list[str]:
        """Returns further elements of the argument's class, likely ones first, up to a limit."""
        self._known.clear()  # other arguments have more candidates by now
        likely: list[str] = []
        unlikely: list[str] = []
        for element in self._some(self._lifted.class_of(slot), limit * _LOOKED_AT + len(known)):
            if element in known:
                continue
            (likely if self.is_likely(element, slot) else unlikely).append(element)
            if len(likely) == limit:
                break
        return likely or unlikely[:limit]

    def likely_first(self, elements: Collection[str], slot: Slot, limit: int) -> list[str]:
        """Returns the elements up to a limit, likely ones first."""
        if len(elements) <= limit:
            return list(elements)
        self._known.clear()
        good = (element for element in elements if self.is_likely(element, slot))
        chosen = [element for element, _ in zip(good, range(limit), strict=False)]
        return chosen or list(elements)[:limit]

    def is_likely(self, element: str, slot: Slot) -> bool:
        """Returns whether the action is likely applicable with an element, considered alone."""
        key = slot, element
        if key not in self._known:
            self._known[key] = True  # cycles do not count against it
            fits = self._lifted.fits(self._view.element(element).type, slot)
            self._known[key] = fits and all(self._is_met(atom, element, slot) for atom in self._lifted.needs(slot))
        return self._known[key]

    def _some(self, class_: str, most: int) -> Iterator[str]:
        last = ""
        while most > 0:
            page = self._view.some_instances(class_, min(_PAGE, most), last)
            yield from page
            if len(page) < min(_PAGE, most):
                return
            most, last = most - len(page), page[-1]

    def _is_met(self, atom: Atom, element: str, slot: Slot) -> bool:
        if atom.predicate.startswith(CAN):
            return element in self._agents.get(atom.predicate, ())
        if atom.predicate in self._asked:
            return self._lifted.is_changed(atom.predicate) or self._holds(atom, element, slot)
        if atom.predicate.startswith(NOTHING):
            return not self._view.subjects(atom.predicate.removeprefix(NOTHING), element)
        if not self._lifted.is_stored(atom.predicate):
            return True
        return self._is_related(atom, element, slot) or self._is_given(atom, element, slot)

    def _holds(self, atom: Atom, element: str, slot: Slot) -> bool:
        literal = self._asked[atom.predicate]
        if len(atom.arguments) == 1:
            return bool(literal.evaluate(self._view, {"1": element}))
        partner = Slot(slot.action, other(atom, slot.variable))
        tried = [p for p, _ in zip(self._found(partner), range(_TRIED), strict=False)]
        pairs = ((element, p) if atom.arguments[0] == slot.variable else (p, element) for p in tried)
        return not tried or any(literal.evaluate(self._view, {"1": one, "2": two}) for one, two in pairs)

    def _is_related(self, atom: Atom, element: str, slot: Slot) -> bool:
        """Whether it holds now: a determined partner must be a likely one; of many partners any will do."""
        if not self._lifted.is_determined(atom, slot.variable):
            return bool(partners(self._view, atom, slot.variable, element))
        partner = Slot(slot.action, other(atom, slot.variable))
        named = not partner.variable.startswith("?")
        return any(
            p == partner.variable if named else self.is_likely(p, partner)
            for p in partners(self._view, atom, slot.variable, element)
        )

    def _is_given(self, atom: Atom, element: str, slot: Slot) -> bool:
        position = atom.arguments.index(slot.variable)
        given = self._lifted.givers(self._lifted.actions[slot.action], atom)
        return any(self.is_likely(element, Slot(giver.name, effect.arguments[position])) for giver, effect in given)
