"""Steps as people say them."""

from __future__ import annotations

from skiros_py.planning.plan import Step
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription


def short_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step as people say it: the skill and what people specify of it, without devices and what follows."""
    said = [
        str(step.arguments[p.key])
        for p in skill.params
        if p.key in step.arguments and p.kind not in (Kind.HARDWARE, Kind.PLANNING)
    ]
    return " ".join((step.skill, *said))
