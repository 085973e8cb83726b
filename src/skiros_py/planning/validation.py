"""Replays a plan on an overlay by evaluating the *conditions*: no planner is believed, and not our own PDDL either."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.needs import needs_of, with_defaults
from skiros_py.planning.plan import Step
from skiros_py.skills.conditions import Condition, Verdict, effects_of, judge, suppose_effects
from skiros_py.skills.inference import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Flaw", "apply_effects", "replay", "replay_rest"]


@dataclass(frozen=True, slots=True)
class Flaw:
    """Where a plan breaks.

    Attributes:
        step: Index of the step, or None when all steps run but the goal is not reached.
        verdict: What does not hold, or which condition broke, and why.
    """

    step: int | None
    verdict: Verdict


def replay(
    view: WorldView, steps: Sequence[Step], goal: Sequence[Condition], skills: Mapping[str, SkillDescription]
) -> Flaw | None:
    """Runs a plan in imagination; the given view is not changed.

    Returns:
        The first flaw, or None when every precondition holds in its turn, every postcondition follows, and the goal is
        reached at the end.
    """
    return _replay(Overlay(view), steps, goal, skills)


def replay_rest(
    view: WorldView,
    current: Step | None,
    rest: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
) -> Flaw | None:
    """Tells whether the rest of a plan still leads to the goal, given that the current step will succeed."""
    overlay = Overlay(view)
    if current is not None:
        skill = skills[current.skill]
        apply_effects(overlay, skill.post, with_defaults(skill, current.arguments))
    return _replay(overlay, rest, goal, skills)


def _replay(
    overlay: Overlay, steps: Sequence[Step], goal: Sequence[Condition], skills: Mapping[str, SkillDescription]
) -> Flaw | None:
    for index, step in enumerate(steps):
        skill = skills[step.skill]
        values = with_defaults(skill, step.arguments)
        broken = _first_broken(overlay, needs_of(skill), values)
        if broken is None:
            apply_effects(overlay, skill.post, values)
            broken = _first_broken(overlay, skill.post, values)
        if broken is not None:
            return Flaw(index, broken)
    return next((Flaw(None, v) for v in (judge(c, overlay) for c in goal) if not v), None)


def _first_broken(view: WorldView, conditions: Sequence[Condition], values: Mapping[str, str]) -> Verdict | None:
    verdicts = (judge(condition, view, values) for condition in applying(conditions, values))
    return next((verdict for verdict in verdicts if not verdict), None)


def apply_effects(overlay: Overlay, post: Sequence[Condition], arguments: Mapping[str, str]) -> None:
    """Makes postconditions true on an overlay: moves what is moved, relates what is related.

    Left out are conditions that speak of parameters that are not specified; those that follow from others ("nothing is
    there") are left to the check afterwards.

    Raises:
        DescriptionError: One cannot be brought about.
    """
    for condition in applying(post, arguments):
        suppose_effects(overlay, effects_of(condition.bind(arguments)))
