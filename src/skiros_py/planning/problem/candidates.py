"""Chooses the elements to try first for an open parameter: those likely to suit the skills."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping

from skiros_py.planning.domain.literals import CAN, NOTHING, Asked
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.problem.lifted import Lifted, Slot, other, partners
from skiros_py.skills.conditions import Not
from skiros_py.world.view import WorldView

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
        view: The world.
        lifted: The actions.
        asked: The evaluated literals, by predicate.
        agents: The agents that have a skill, by predicate ("can_pick").
        found: The known candidates of other arguments.
    """

    def __init__(
        self,
        view: WorldView,
        lifted: Lifted,
        asked: Mapping[str, Asked | Not],
        agents: Mapping[str, Collection[str]],
        found: Found,
    ) -> None:
        self._view = view
        self._lifted = lifted
        self._asked = asked
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
