"""What a person did in the place of a robot: the step's effects are believed because somebody says so."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import UnknownName
from skiros_py.planning.domain.needs import with_defaults
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.inference import applying
from skiros_py.tasks.by_hand import write_by_hand
from skiros_py.tasks.jobs.job import Intent
from skiros_py.world.world import World


def done_by_hand(world: World, capabilities: Sequence[Capability], intent: Intent, by: str) -> None:
    """Writes a step's effects into the world.

    Args:
        world: The live world model.
        capabilities: The skills that are there.
        intent: The step.
        by: Who says that it is done.

    Raises:
        UnknownName: Nobody has the skill any more, so nobody knows its effects.
        WorldError: The effects cannot be so.
    """
    skills = {capability.skill.name: capability.skill for capability in capabilities}
    if intent.skill not in skills:
        raise UnknownName("skill", intent.skill, skills)
    skill = skills[intent.skill]
    values = with_defaults(skill, intent.arguments)
    done = (condition.bind(values) for condition in applying(skill.post, values))
    write_by_hand(world, done, by, f"{intent.skill} was done by hand")
