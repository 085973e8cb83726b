"""Replays a plan on an overlay by evaluating the *conditions*: no planner is believed, and not our own PDDL either."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.domain.needs import needs_of, with_defaults
from skiros_py.planning.pieces import Work, at_once
from skiros_py.planning.plan import Step
from skiros_py.planning.sequence import Round
from skiros_py.skills.conditions import Condition, Verdict, effects_of, judge, suppose_effects
from skiros_py.skills.inference import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Flaw", "apply_effects", "out_of_sequence", "replay", "replaying"]


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
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> Flaw | None:
    """Runs a plan in imagination; the given view is not changed.

    Args:
        view: The world.
        steps: The plan.
        goal: What it is for.
        skills: What is known of the skills, by name.
        reached: The highest sequence number that each robot has visited in this task.

    Returns:
        The first flaw, or None when every precondition holds in its turn, every postcondition follows, the scene's
        sequence numbers are kept to, and the goal is reached at the end.
    """
    return at_once(replaying(view, steps, goal, skills, reached=reached))


def replaying(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> Work[Flaw | None]:
    """Does what :func:`replay` does; yields after each step."""
    return _replaying(Overlay(view), steps, goal, skills, Round(view, goal, reached))


def out_of_sequence(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> str:
    """Says how a plan that is right but for sequence and work numbers breaks these; empty where it does not.

    To be asked where it is proved that a task has no plan with the numbers, and this is one without them: then they are
    why.
    """
    flaw = replay(view, steps, goal, skills, reached=reached)
    return "" if flaw is None else f"no plan keeps to the sequence numbers of this scene: {flaw.verdict.text}"


def _replaying(
    overlay: Overlay,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    round_: Round,
) -> Work[Flaw | None]:
    for index, step in enumerate(steps):
        skill = skills[step.skill]
        values = with_defaults(skill, step.arguments)
        broken = _first_broken(overlay, needs_of(skill), values)
        if broken is None:
            broken = round_.take(overlay, skill, values)
        if broken is None:
            apply_effects(overlay, skill.post, values)
            broken = _first_broken(overlay, skill.post, values)
        if broken is not None:
            return Flaw(index, broken)
        yield
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
