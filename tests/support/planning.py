"""Planning tasks of the tiny scene."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.skills.conditions import Condition
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing.tiny import DRIVE, PICK, PLACE
from skiros_py.world.view import WorldView


def tiny_task(
    view: WorldView,
    *goal: Condition,
    skills: Sequence[SkillDescription] = (DRIVE, PICK, PLACE),
    agents: Sequence[str] | None = None,
) -> PlanningTask:
    """Returns the planning task for a goal, with everything in it, needed or not.

    Args:
        view: The world.
        *goal: Conditions that must hold.
        skills: The available skills.
        agents: The subsystems that can execute them, if they fit the skill's class; None for all that fit it.
    """
    able = [
        Capability(s, tuple(a for a in view.instances(s.agent_class) if agents is None or a in agents)) for s in skills
    ]
    return build_task(view, able, goal, whole=True)


def tiny_pddl(
    view: WorldView, *goal: Condition, skills: Sequence[SkillDescription] = (DRIVE, PICK, PLACE)
) -> PddlTexts:
    """Returns the task of :func:`tiny_task` as PDDL."""
    task = tiny_task(view, *goal, skills=skills)
    return write_pddl(task.domain, task.problem, name="tiny")
