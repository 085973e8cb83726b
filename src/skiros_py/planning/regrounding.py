"""A plan of skills as a plan of its PDDL task: parameters of our own making (the place that is left) filled in anew.

Steps that were left out as detours changed what the ones after them start from, so the planner's own lines may no
longer hold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from skiros_py.planning.matching import bindings
from skiros_py.planning.model import Action, Atom
from skiros_py.planning.pddl import PddlTexts
from skiros_py.planning.plan import Step
from skiros_py.planning.task import PlanningTask
from skiros_py.world.ontology import Ontology

__all__ = ["pddl_plan"]


def pddl_plan(task: PlanningTask, texts: PddlTexts, steps: Sequence[Step], ontology: Ontology) -> tuple[str, ...]:
    """Writes the plan in the task's words, with the goal's bookkeeping at its end, as planners write it.

    The conditions decide what a plan is worth, not this text: where the task is stricter than they are and has no such
    plan, the text is empty.

    Args:
        task: The task.
        texts: The task as written: gives the words.
        steps: The skills to run, in order; they lead to the goal.
        ontology: Classes.
    """
    run = _Run(task, ontology)
    names = {action.name: word for word, action in texts.actions.items()}
    taken = [run.take([a for a in task.domain.actions if a.skill == step.skill], step) for step in steps]
    closing = [a for a in task.domain.actions if a.skill is None]
    while None not in taken and not set(task.problem.goal) <= run.state:
        taken.append(run.take([a for a in closing if not set(a.add) <= run.state], None))
    if None in taken:
        return ()
    objects = texts.objects.pddl
    return tuple(f"({' '.join([names[action.name], *map(objects, ids)])})" for action, ids in filter(None, taken))


class _Run:
    """The state of the task while its actions are taken one after the other."""

    def __init__(self, task: PlanningTask, ontology: Ontology) -> None:
        self.state = set(task.problem.init)
        self._task = task
        self._ontology = ontology

    def take(self, choices: Sequence[Action], step: Step | None) -> tuple[Action, tuple[str, ...]] | None:
        """Takes the first of the actions that is possible now, with a step's arguments where one is given.

        Returns:
            The action and its objects, or None when none is possible.
        """
        facts: dict[str, list[Atom]] = {}
        for atom in sorted(self.state):
            facts.setdefault(atom.predicate, []).append(atom)
        given = {f"?{key}": value for key, value in step.arguments.items()} if step else {}
        for action in choices:
            for found in bindings(action.pre, facts, given, action.types, self._fits):
                binding = self._completed(action, found)
                self.state -= {atom.bind(binding) for atom in action.delete}
                self.state |= {atom.bind(binding) for atom in action.add}
                return action, tuple(binding[v.name] for v in action.parameters)
        return None

    def _completed(self, action: Action, found: Mapping[str, str]) -> dict[str, str]:
        """Takes any element for a parameter that no atom speaks of and the step leaves out: the skill will choose."""
        objects = self._task.problem.objects
        binding = dict(found)
        for variable in action.parameters:
            if variable.name not in binding:
                binding[variable.name] = next(o for o in objects if self._fits(o, variable.type))
        return binding

    def _fits(self, element: str, class_: str) -> bool:
        return class_ in ("", "object") or self._ontology.is_a(self._task.problem.objects[element], class_)
