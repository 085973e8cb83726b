"""Who does a step, and with what, where a person left that open: as it is inferred when the step starts."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from skiros_py.execution.contained import contained
from skiros_py.planning.domain.needs import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.skills.inference import Inferred, Missing, infer
from skiros_py.skills.outcome import Failure
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Cast:
    """The elements of a step.

    Attributes:
        values: Element ids by parameter key, as far as they are known.
        open: Why something stays open, one sentence each.
    """

    values: Mapping[str, str]
    open: tuple[str, ...] = ()


def cast(step: Step, skill: SkillDescription, view: WorldView, able: Collection[str] | None = None) -> Cast:
    """Finds what a step leaves out.

    Args:
        step: The step.
        skill: What is known of its skill.
        view: The world just before the step.
        able: The subsystems whose skill managers have the skill; None where it is enough that there could be one. Whom
            inference would take comes first, then the others by id.
    """
    given = with_defaults(skill, step.arguments)
    found = _inferred(skill, given, view, None)
    if able is None or skill.agent in given or found.values.get(skill.agent) in able:
        return found
    each = [_inferred(skill, given, view, agent) for agent in sorted(able)]
    return next((one for one in each if not one.open), each[0] if each else _nobody(skill, given))


def _inferred(skill: SkillDescription, given: Mapping[str, str], view: WorldView, agent: str | None) -> Cast:
    """Asks inference; where an author's condition breaks in it, what was left out stays open."""
    found: Inferred | Missing | Failure = contained("inference", lambda: infer(skill, given, view, agent))
    if isinstance(found, Failure):
        return Cast(given, (found.reason,))
    elements = {p.key for p in skill.params if p.is_element}
    values = {key: value for key, value in found.values.items() if key in elements and value is not None}
    return Cast(values, tuple(v.text for v in found.verdicts.values()) if isinstance(found, Missing) else ())


def _nobody(skill: SkillDescription, given: Mapping[str, str]) -> Cast:
    return Cast(given, (f"nobody has the skill {skill.name} any more",))
