"""The things actions handle: those they move or act on, but not the places robots go to."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.planning.domain.classes import common_class
from skiros_py.planning.domain.model import Action
from skiros_py.planning.domain.placing import moved_and_place
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import ROBOT


def moved_by(action: Action, ontology: Ontology) -> tuple[tuple[str, str], ...]:
    """Returns the things an action moves, each with its new place, as the action's variables."""
    relations = ontology.relations
    placed = (a for a in action.add if a.predicate in relations and ontology.is_placement(a.predicate))
    return tuple(moved_and_place(atom, ontology) for atom in placed)


def columns(predicate: str, actions: Iterable[Action], task: PlanningTask, ontology: Ontology) -> tuple[str, ...]:
    """Returns the classes of a predicate's arguments: the most specific ones covering all uses in actions."""
    found: tuple[str, ...] = ()
    for action in actions:
        types = {**task.problem.objects, **action.types}
        for atom in (atom for atom in action.atoms if atom.predicate == predicate):
            new = tuple(types[argument] or "object" for argument in atom.arguments)
            found = tuple(common_class(a, b, ontology) for a, b in zip(found or new, new, strict=True))
    return tuple(class_ if class_ in task.domain.types else "object" for class_ in found)


class Handling:
    """What the actions of a task handle.

    Attributes:
        variables: The variables of handled things, by action name; without actions that handle nothing.
        agents: The variable of the acting agent, by action name.
    """

    def __init__(self, task: PlanningTask, ontology: Ontology) -> None:
        self._ontology = ontology
        self._objects = task.problem.objects
        self.variables: dict[str, tuple[str, ...]] = {}
        self.agents: dict[str, str] = {}
        self._moved: set[str] = set()
        self._done_to: set[str] = set()
        skills = {c.skill.name: c.skill for c in task.capabilities}
        for action in task.domain.actions:
            moved = tuple(thing for thing, _ in moved_by(action, ontology))
            types = action.types
            if action.skill is None or any(self.is_one_of(types[v], [ROBOT]) for v in moved):
                continue
            skill = skills[action.skill]
            self.agents[action.name] = f"?{skill.agent}"
            self.variables[action.name] = tuple(dict.fromkeys((*moved, f"?{skill.target}")))
            self._moved |= {types[v] for v in moved}
            self._done_to.add(types[f"?{skill.target}"])
        self._done_to -= self._moved

    def things(self, named: Iterable[str]) -> frozenset[str]:
        """Returns the given elements that some action moves; if there are none, those that some action acts on."""
        known = {name: self._objects[name] for name in named if name in self._objects}
        moved = frozenset(name for name, class_ in known.items() if self.is_one_of(class_, self._moved))
        return moved or frozenset(name for name, class_ in known.items() if self.is_one_of(class_, self._done_to))

    def is_moved(self, class_: str) -> bool:
        """Returns whether some action moves things of a class."""
        return self.is_one_of(class_, self._moved)

    def is_one_of(self, class_: str, classes: Iterable[str]) -> bool:
        """Returns whether a class is one of the given classes or a subclass of one."""
        return any(c in ("", "object") or (class_ != "object" and self._ontology.is_a(class_, c)) for c in classes)
