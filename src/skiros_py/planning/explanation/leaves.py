"""False facts that no skill can change: the kind of obstacle, and the actual state."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.planning.domain.literals import CAN, HAS, NOT, NOTHING
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.explanation.facts import is_variable
from skiros_py.planning.explanation.found import Obstacle
from skiros_py.planning.explanation.wording import Wording, listed
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.reasons import CauseKind
from skiros_py.skills.conditions import Computed
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView

_SHOWN = 4
"""How many misplaced things are named."""
_COUNTED = 32
"""How many elements of a class one obstacle names as data."""

Types = Mapping[str, str]


class Leaves:
    """Describes the actual state for false facts."""

    def __init__(self, task: PlanningTask, view: WorldView, wording: Wording) -> None:
        self._task = task
        self._view = view
        self._wording = wording

    def of(self, atom: Atom, types: Types) -> Obstacle:
        """Returns the obstacle for a fact that no skill provides."""
        if atom.predicate.startswith(CAN):
            return self._no_skill(atom, types)
        if atom.predicate.startswith(NOTHING):
            return self._full(atom, types)
        if self._is_placement(atom.predicate):
            return self._elsewhere(atom, types)
        if self._is_placement(atom.predicate.removeprefix(NOT)):
            return self._still_there(atom, types)
        return self._plainly(atom, types)

    def none_of(self, class_: str) -> Obstacle:
        """Returns the obstacle that a class has no elements."""
        return Obstacle(CauseKind.MISSING_ELEMENT, f"there is no {local_name(class_)}", elements=(class_,))

    def _is_placement(self, relation: str) -> bool:
        ontology = self._view.ontology
        return relation in ontology.relations and ontology.is_placement(relation)

    def _no_skill(self, atom: Atom, types: Types) -> Obstacle:
        agents = self._things(atom.arguments[0], types)
        verb = "does" if len(agents) == 1 else "do"
        skill = atom.predicate.removeprefix(CAN)
        text = f"{listed(agents)} {verb} not have it"
        return Obstacle(CauseKind.NO_SKILL, text, skill, "", agents, atom, types)

    def _full(self, atom: Atom, types: Types) -> Obstacle:
        relation = atom.predicate.removeprefix(NOTHING)
        verb = self._wording.term(relation)
        places = self._things(atom.arguments[0], types)
        there = {place: self._view.subjects(relation, place) for place in places}
        if len(places) == 1:
            text = f"{listed(there[places[0]])} {verb} {places[0]}, and no skill takes it away"
        else:
            text = (
                f"every {local_name(types.get(atom.arguments[0], 'place'))} is taken, and no skill takes anything away"
            )
        elements = (*places, *dict.fromkeys(thing for things in there.values() for thing in things))
        return Obstacle(CauseKind.FULL, text, elements=elements, missing=atom, types=types)

    def _elsewhere(self, atom: Atom, types: Types) -> Obstacle:
        """Describes where the things are that should be in a place."""
        first, second = atom.arguments
        at_object = self._view.ontology.relations[atom.predicate].place_end == "object"
        moved, place = (first, second) if at_object else (second, first)
        things = self._things(moved, types)
        if not things:
            return self.none_of(types.get(moved, moved))
        if not self._things(place, types):
            return self.none_of(types.get(place, place))
        placed = {thing: p for thing in things[:_SHOWN] if (p := self._view.placement(thing)) is not None}
        if not placed:
            return self._plainly(atom, types)
        said = listed(f"{thing} {self._wording.term(p.relation)} {p.place}" for thing, p in placed.items())
        elements = tuple(dict.fromkeys((*placed, *(p.place for p in placed.values()))))
        text = f"{said}, and no skill takes it from there"
        return Obstacle(CauseKind.MISSING_FACT, text, elements=elements, missing=atom, types=types)

    def _still_there(self, atom: Atom, types: Types) -> Obstacle:
        """Describes what is in a place where it should not be."""
        relation = atom.predicate.removeprefix(NOT)
        subjects, objects = (self._things(argument, types) for argument in atom.arguments)
        there = [(s, o) for s in subjects for o in objects if self._view.related(s, relation, o)][:_SHOWN]
        if not there:
            return self._plainly(atom, types)
        said = listed(f"{subject} {self._wording.term(relation)} {object_}" for subject, object_ in there)
        elements = tuple(dict.fromkeys(name for pair in there for name in pair))
        text = f"{said}, and no skill takes {'it' if len(there) == 1 else 'them'} from there"
        return Obstacle(CauseKind.MISSING_FACT, text, elements=elements, missing=atom, types=types)

    def _plainly(self, atom: Atom, types: Types) -> Obstacle:
        """States that a fact is false, with the reason if known."""
        asked = self._task.asked.get(atom.predicate)
        kind = CauseKind.DOES_NOT_FIT if isinstance(asked, Computed) else CauseKind.MISSING_FACT
        named = (*(types.get(a, a) for a in atom.arguments),)
        for argument in atom.arguments:
            if not self._things(argument, types):
                return self.none_of(types.get(argument, argument))
        only = {a: things[0] for a in atom.arguments if len(things := self._things(a, types)) == 1}
        text = f"{self._instead(atom.bind(only), types)}, and no skill changes it"
        return Obstacle(kind, text, elements=named, missing=atom, types=types)

    def _instead(self, atom: Atom, types: Types) -> str:
        if atom.predicate.startswith(HAS):
            thing, property_ = atom.arguments[0], self._wording.term(atom.predicate.removeprefix(HAS))
            who = f"no {local_name(types[thing])} has a" if is_variable(thing) else f"{thing} has no"
            return f"{who} {property_}"
        asked = self._task.asked.get(atom.predicate)
        if asked is not None and not any(is_variable(a) for a in atom.arguments):
            verdict = asked.evaluate(self._view, dict(zip(("1", "2"), atom.arguments, strict=False)))
            return verdict.text
        if isinstance(asked, Computed):
            return self._wording.none(atom, types)
        return f"that is not so ({self._wording.atom(atom, types)})"

    def _things(self, argument: str, types: Types) -> tuple[str, ...]:
        """Returns the elements an argument could be; a bounded number of them."""
        if not is_variable(argument):
            return (argument,)
        class_ = types.get(argument, "")
        if class_ in ("", "object"):
            return tuple(list(self._task.problem.objects)[:_COUNTED])
        return self._view.instances(class_)[:_COUNTED]
