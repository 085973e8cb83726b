"""What must hold when a skill starts, as far as that can be known before, and of which parameters plans speak."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.skills.conditions import Condition, is_sensed
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription


def needs_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns what a plan must see to: what the skill needs, and what must hold while it runs but what is sensed."""
    return (*skill.needs, *(c for c in skill.hold if not is_sensed(c.pattern)))


def sensed_holds_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns the hold conditions that ask sensors: they are watched while it runs, and no plan knows them."""
    return tuple(c for c in skill.hold if is_sensed(c.pattern))


def required_elements(skill: SkillDescription) -> tuple[Param, ...]:
    """Returns the element parameters that a plan has to find something for; the others have a default or stay open.

    Who does it and to what is of interest in any case.
    """
    ends = (skill.agent, skill.target)
    return tuple(p for p in skill.params if p.is_element and (p.kind.is_required or p.key in ends))


def passed_keys(skill: SkillDescription) -> tuple[str, ...]:
    """Returns the keys that a plan passes: agent, target, and what the author's conditions speak of.

    The others are inferred when the skill starts, by what its author prefers.
    """
    said = (*skill.described, *skill.pre, *skill.hold, *skill.post)
    spoken = {skill.agent, skill.target, *(key for condition in said for key in condition.arguments)}
    return tuple(param.key for param in required_elements(skill) if param.key in spoken)


def with_defaults(skill: SkillDescription, arguments: Mapping[str, str]) -> dict[str, str]:
    """Returns the arguments of a call with the elements that the skill takes where nobody says which."""
    elements = (param for param in skill.params if param.is_element and param.default is not None)
    return {param.key: param.default for param in elements} | dict(arguments)
