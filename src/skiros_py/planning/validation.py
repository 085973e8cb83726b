"""Replays a plan on an overlay by evaluating the *conditions*: no planner is believed, and not our own PDDL either."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.needs import needs_of
from skiros_py.planning.plan import Step
from skiros_py.skills.conditions import Condition, Verdict, effects_of, suppose_effects
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Flaw", "apply_effects", "replay", "replay_rest"]


@dataclass(frozen=True, slots=True)
class Flaw:
    """Where a plan breaks.

    Attributes:
        step: Index of the step, or None when all steps run but the goal is not reached.
        verdict: What does not hold, and why.
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
        apply_effects(overlay, skills[current.skill].post, current.arguments)
    return _replay(overlay, rest, goal, skills)


def _replay(
    overlay: Overlay, steps: Sequence[Step], goal: Sequence[Condition], skills: Mapping[str, SkillDescription]
) -> Flaw | None:
    for index, step in enumerate(steps):
        skill = skills[step.skill]
        for condition in needs_of(skill):
            verdict = condition.evaluate(overlay, step.arguments)
            if not verdict:
                return Flaw(index, verdict)
        apply_effects(overlay, skill.post, step.arguments)
        for condition in skill.post:
            verdict = condition.evaluate(overlay, step.arguments)
            if not verdict:
                return Flaw(index, verdict)
    return next((Flaw(None, v) for v in (c.evaluate(overlay) for c in goal) if not v), None)


def apply_effects(overlay: Overlay, post: Sequence[Condition], arguments: Mapping[str, str]) -> None:
    """Makes postconditions true on an overlay: moves what is moved, relates what is related.

    Conditions that follow from others ("nothing is there") are left to the check afterwards.

    Raises:
        DescriptionError: One cannot be brought about.
    """
    for condition in post:
        suppose_effects(overlay, effects_of(condition.bind(arguments)))
