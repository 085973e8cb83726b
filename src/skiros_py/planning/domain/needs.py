"""The conditions a skill needs at its start, as far as they are known in advance, and the parameters plans contain."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.skills.conditions import Condition, is_sensed
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription


def needs_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns the conditions a plan must ensure: preconditions, and hold conditions except sensed ones."""
    return (*skill.needs, *(c for c in skill.hold if not is_sensed(c.pattern)))


def sensed_holds_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns the hold conditions on sensors: they are monitored at run time and ignored by planning."""
    return tuple(c for c in skill.hold if is_sensed(c.pattern))


def required_elements(skill: SkillDescription) -> tuple[Param, ...]:
    """Returns the element parameters that a plan must bind; the others have a default or stay open.

    Agent and target are always included.
    """
    ends = (skill.agent, skill.target)
    return tuple(p for p in skill.params if p.is_element and (p.kind.is_required or p.key in ends))


def passed_keys(skill: SkillDescription) -> tuple[str, ...]:
    """Returns the keys that a plan passes: agent, target, and those in the author's conditions.

    The others are inferred when the skill starts, by the author's preferences.
    """
    said = (*skill.described, *skill.pre, *skill.hold, *skill.post)
    spoken = {skill.agent, skill.target, *(key for condition in said for key in condition.arguments)}
    return tuple(param.key for param in required_elements(skill) if param.key in spoken)


def with_defaults(skill: SkillDescription, arguments: Mapping[str, str]) -> dict[str, str]:
    """Returns the arguments of a call, completed with the skill's default elements."""
    elements = (param for param in skill.params if param.is_element and param.default is not None)
    return {param.key: param.default for param in elements} | dict(arguments)
