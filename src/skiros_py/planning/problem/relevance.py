"""Finds the actions and elements relevant to a goal, by backward search.

An element is included because something relevant refers to it: the goal, the place of an included thing, the owner of
a part, the devices of a robot that has a skill, a candidate for a choice. The world is never scanned as a whole; only
the complete problem includes every element of a class with a choice.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping

from skiros_py.planning.domain.literals import CAN, NOTHING, Asked
from skiros_py.planning.domain.model import Action, Atom, NoneSuch
from skiros_py.planning.problem.lifted import Candidates, Lifted, Slot, other, partners
from skiros_py.skills.conditions import Not
from skiros_py.world.view import WorldView

_AIM = ""
"""Name of the pseudo-action for the goal: its preconditions are the goal."""


Relevant = tuple[tuple[Action, ...], frozenset[str]]
"""The actions that can help, directly or indirectly, in their order; and the elements they could involve."""


def relevant(
    view: WorldView,
    actions: Iterable[Action],
    goal: Iterable[Atom],
    agents: Mapping[str, Collection[str]],
    asked: Mapping[str, Asked | Not],
    width: int | None,
) -> Relevant:
    """Finds the actions and elements relevant to a goal.

    Args:
        view: The world.
        actions: All there are.
        goal: Atoms over elements that must hold.
        agents: Ids of the agents that have a skill, by predicate ("can_pick").
        asked: The literals evaluated at the start, by predicate.
        width: How many candidates are taken for each choice, besides those that other choices may use up; None takes
            everything that any plan without idle steps could be about.
    """
    aim = Action(_AIM, None, (), tuple(goal), (), ())
    growth = _Growth(Lifted((*actions, aim), view, asked), agents, width)
    growth.run(aim)
    helping = (action for name, action in growth.lifted.actions.items() if name in growth.active and name != _AIM)
    return tuple(helping), frozenset(growth.elements)


class _Growth:
    """The arguments of relevant actions, with their candidate elements."""

    def __init__(self, lifted: Lifted, agents: Mapping[str, Collection[str]], width: int | None) -> None:
        self.lifted = lifted
        self.active: dict[str, Action] = {}
        self.elements: dict[str, str] = {}
        self._view = lifted.view
        self._agents = agents
        self._width = width
        self._found: dict[Slot, dict[str, None]] = {}
        self._flows: dict[Slot, list[Slot]] = {}
        self._news: deque[tuple[Slot, str]] = deque()
        self._open: set[Slot] = set()
        self._chosen: dict[Slot, str] = {}
        self._displaced: dict[str, None] = {}
        self._followed: set[tuple[Slot, Atom]] = set()
        self._changing: dict[tuple[Slot, Atom], bool] = {}
        self._candidates = Candidates(lifted, agents, self._values)

    def run(self, aim: Action) -> None:
        """Grows from the goal until nothing more is needed."""
        self._activate(aim)
        while True:
            while self._news:
                self._spread(*self._news.popleft())
            slot = self._next_choice()
            if slot is None:
                return
            self._choose(slot)

    def _values(self, slot: Slot) -> Collection[str]:
        return self._found.get(slot, {})

    # ------------------------------------------------------------ actions that help

    def _activate(self, action: Action) -> None:
        if action.name in self.active:
            return
        self.active[action.name] = action
        for argument in dict.fromkeys(a for atom in action.atoms for a in atom.arguments if not a.startswith("?")):
            self._put(Slot(action.name, argument), argument)
        for atom in action.pre:
            if atom.predicate.startswith(CAN):
                self._put_all(Slot(action.name, atom.arguments[0]), self._agents.get(atom.predicate, ()))
            elif not atom.predicate.startswith(NOTHING):
                self._ask_givers(action, atom)
        for atom in (atom for none in action.none for atom in none.atoms):
            for breaker, _ in self.lifted.breakers(atom):
                self._activate(breaker)

    def _ask_givers(self, action: Action, atom: Atom) -> None:
        for giver, effect in self.lifted.givers(action, atom):
            self._activate(giver)
            for own, its in zip(atom.arguments, effect.arguments, strict=True):
                self._flow(Slot(action.name, own), Slot(giver.name, its))

    def _flow(self, source: Slot, target: Slot) -> None:
        """Makes candidates of one argument candidates of the other from now on."""
        targets = self._flows.setdefault(source, [])
        if target not in targets and target != source:
            targets.append(target)
            self._put_all(target, tuple(self._values(source)))

    # ------------------------------------------------------------ elements that they may be about

    def _put(self, slot: Slot, element: str) -> None:
        found = self._found.setdefault(slot, {})
        if element in found or not self._view.has(element):
            return
        type_ = self.elements.get(element) or self._view.element(element).type
        fits = self.lifted.fits(type_, slot) if slot.variable.startswith("?") else element == slot.variable
        if fits:
            self.elements[element] = type_
            found[element] = None
            self._news.append((slot, element))

    def _put_all(self, slot: Slot, elements: Iterable[str]) -> None:
        for element in elements:
            self._put(slot, element)

    def _spread(self, slot: Slot, element: str) -> None:
        """Adds what follows from an element being a candidate of an argument."""
        for target in self._flows.get(slot, ()):
            self._put(target, element)
        action = self.lifted.actions[slot.action]
        for atom in self.lifted.needs(slot):
            if atom.predicate.startswith(NOTHING):
                self._vacate(action, atom, element)
            elif self._is_link(atom):
                self._follow(slot, atom, element)
        for none in action.none:
            self._take_in(none, slot.variable, element)

    def _follow(self, slot: Slot, atom: Atom, element: str) -> None:
        """Follows a relation that leads to a single thing, or to a choice."""
        partner = Slot(slot.action, other(atom, slot.variable))
        if self.lifted.is_determined(atom, slot.variable):
            self._put_all(partner, partners(self._view, atom, slot.variable, element))
            if self._width is None and self._could_change(partner, atom):
                self._open.add(partner)
        elif (slot, atom) in self._followed:
            self._put_some(partner, partners(self._view, atom, slot.variable, element))

    def _could_change(self, partner: Slot, atom: Atom) -> bool:
        """Whether skills can change the relation's target, and that may be required."""
        key = partner, atom
        if key not in self._changing:
            action = self.lifted.actions[partner.action]
            given = bool(self.lifted.givers(action, atom))
            self._changing[key] = given and not self._is_fixed(partner) and not self._is_only_left(partner, atom)
        return self._changing[key]

    def _is_fixed(self, slot: Slot) -> bool:
        """Whether a static relation determines the argument, given another one."""
        action = self.lifted.actions[slot.action]
        fixed = (a for a in self.lifted.needs(slot) if self._is_link(a) and not self.lifted.givers(action, a))
        return any(self.lifted.is_determined(atom, other(atom, slot.variable)) for atom in fixed)

    def _is_only_left(self, slot: Slot, atom: Atom) -> bool:
        """Whether the argument is only a place that is left: actions that bring things there serve other purposes."""
        action = self.lifted.actions[slot.action]
        spoken = any(slot.variable in added.arguments for added in action.add)
        return list(self.lifted.needs(slot)) == [atom] and atom in action.delete and not spoken

    def _is_link(self, atom: Atom) -> bool:
        return self.lifted.is_stored(atom.predicate) and len(set(atom.arguments)) > 1

    def _vacate(self, action: Action, atom: Atom, place: str) -> None:
        """Adds what lies in a place that must be empty, who can remove it, and where it may go."""
        relation = atom.predicate.removeprefix(NOTHING)
        guests = self._view.subjects(relation, place)
        self._displace(guests)
        if not self._displaced and self._width is not None:
            return
        for taker, effect in self.lifted.givers(action, atom):
            self._activate(taker)
            freed = effect.arguments[0]
            taken = [d.arguments[0] for d in taker.delete if d.predicate == relation and d.arguments[1] == freed]
            self._put(Slot(taker.name, freed), place)
            for variable in taken:
                self._put_all(Slot(taker.name, variable), guests or self._displaced)
            passive = (v for v in taken if self._is_passive(taker, v))
            spoken = {a for added in taker.add for a in added.arguments if a.startswith("?")}
            self._open |= {Slot(taker.name, variable) for variable in spoken.difference(passive, {freed})}

    def _displace(self, guests: Iterable[str]) -> None:
        """Records things that have to be moved elsewhere, which may require emptying further places."""
        new = dict.fromkeys(guests, None)
        if new.keys() <= self._displaced.keys():
            return
        self._displaced |= new
        for slot, found in self._found.items():
            if any(atom.predicate.startswith(NOTHING) for atom in self.lifted.needs(slot)):
                self._news.extend((slot, element) for element in found)

    def _is_passive(self, taker: Action, variable: str) -> bool:
        return self._width is not None or self.lifted.is_passive(self.lifted.class_of(Slot(taker.name, variable)))

    def _take_in(self, none: NoneSuch, variable: str, element: str) -> None:
        """Adds everything that must not exist."""
        for atom in none.atoms:
            if variable in atom.arguments and self.lifted.is_stored(atom.predicate):
                there = partners(self._view, atom, variable, element)
                self.elements |= {name: self._view.element(name).type for name in there}
                for breaker, effect in self.lifted.breakers(atom):
                    self._put_all(
                        Slot(breaker.name, other(effect, effect.arguments[atom.arguments.index(variable)])), there
                    )
                    spoken = {v for added in breaker.add for v in added.arguments if v.startswith("?")}
                    self._open |= {Slot(breaker.name, v) for v in spoken.difference(effect.arguments)}

    # ------------------------------------------------------------ choices

    def _next_choice(self) -> Slot | None:
        """Returns an argument with no or incomplete candidates: first those that determine others."""
        for action in self.active.values():
            slots = [Slot(action.name, v.name) for v in action.parameters]
            missing = [s for s in slots if s not in self._chosen and (s in self._open or not self._values(s))]
            if missing:
                return min(missing, key=self._urgency)
        return None

    def _urgency(self, slot: Slot) -> tuple[bool, int]:
        needs = [a for a in self.lifted.needs(slot) if self._is_link(a)]
        leads = sum(self.lifted.is_determined(atom, slot.variable) for atom in needs)
        return self._link(slot, needs, changing=False) is None, -leads

    def _choose(self, slot: Slot) -> None:
        self._chosen[slot] = self.lifted.class_of(slot)
        needs = [a for a in self.lifted.needs(slot) if self._is_link(a)]
        link = self._link(slot, needs, changing=False)
        if link is None and self._width is not None and slot not in self._open:
            link = self._link(slot, needs, changing=True)
        if link is not None:
            self._follow_all(Slot(slot.action, other(link, slot.variable)), link)
            if self._values(slot) or not self.lifted.is_changed(link.predicate):
                return
        if self._chosen[slot] not in ("", "object"):
            self._put_all(slot, self._of_class(slot))

    def _link(self, slot: Slot, needs: Iterable[Atom], *, changing: bool) -> Atom | None:
        """A relation to an argument that has candidates."""
        for atom in needs:
            if (
                self._values(Slot(slot.action, other(atom, slot.variable)))
                and self.lifted.is_changed(atom.predicate) == changing
            ):
                return atom
        return None

    def _follow_all(self, source: Slot, atom: Atom) -> None:
        self._followed.add((source, atom))
        target = Slot(source.action, other(atom, source.variable))
        for element in tuple(self._values(source)):
            self._put_some(target, partners(self._view, atom, source.variable, element))

    def _put_some(self, slot: Slot, elements: Collection[str]) -> None:
        if self._width is None:
            self._put_all(slot, elements)
        else:
            fitting = [e for e in elements if self.lifted.fits(self._view.element(e).type, slot)]
            self._put_all(slot, self._candidates.likely_first(fitting, slot, self._enough(slot)))

    def _of_class(self, slot: Slot) -> Collection[str]:
        if self._width is None:
            return self._view.instances(self._chosen[slot])
        return self._candidates.of_class(slot, self._enough(slot), self._values(slot))

    def _enough(self, slot: Slot) -> int:
        """How many candidates an argument gets: more where earlier choices may use up some."""
        class_ = self.lifted.class_of(slot)
        rivals = sum(self.lifted.overlap(class_, other_) for s, other_ in self._chosen.items() if s != slot)
        return (self._width or 0) + rivals
