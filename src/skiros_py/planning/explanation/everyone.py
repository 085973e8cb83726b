"""The task with everybody in it who could have a skill: who lacks one is left out of plans, not of explanations."""

from __future__ import annotations

from dataclasses import replace

from skiros_py.planning.domain.literals import CAN
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.world.view import WorldView


def with_everyone(task: PlanningTask, view: WorldView) -> PlanningTask:
    """Returns a task in which whoever is of the right class takes part, with the skill or without it.

    Raises:
        PlanningError: It cannot be said in PDDL.
    """
    everyone = [Capability(c.skill, view.instances(c.skill.agent_class)) for c in task.capabilities]
    able = {Atom(CAN + c.skill.name, (agent,)) for c in task.capabilities for agent in c.agents}
    whole = build_task(view, everyone, task.conditions)
    init = frozenset(atom for atom in whole.problem.init if not atom.predicate.startswith(CAN) or atom in able)
    return replace(whole, problem=replace(whole.problem, init=init), capabilities=task.capabilities)
