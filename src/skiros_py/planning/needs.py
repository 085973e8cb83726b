"""What must hold when a skill starts, as far as that can be known before."""

from __future__ import annotations

from skiros_py.skills.conditions import Condition, is_sensed
from skiros_py.skills.skill import SkillDescription

__all__ = ["needs_of", "sensed_holds_of"]


def needs_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns what a plan must see to: what the skill needs, and what must hold while it runs but what is sensed."""
    return (*skill.needs, *(c for c in skill.hold if not is_sensed(c.pattern)))


def sensed_holds_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns the hold conditions that ask sensors: they are watched while it runs, and no plan knows them."""
    return tuple(c for c in skill.hold if is_sensed(c.pattern))
