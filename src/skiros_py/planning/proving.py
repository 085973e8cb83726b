"""A planner's answer made a plan: read, replayed, and without its detours. No planner is believed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.needs import passed_keys, with_defaults
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.pieces import Work, at_once
from skiros_py.planning.plan import Plan, Step, read_plan
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.regrounding import in_words
from skiros_py.planning.sequence import Round
from skiros_py.planning.validation import Flaw, apply_effects, replaying
from skiros_py.skills.conditions import Condition
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Wrong", "proved", "proving"]

_LONGEST = 10_000
"""No plan has more steps: to replay it would hold everything up."""
_STREAMLINED = 300
"""A plan of more steps keeps its detours: to look for them takes time in the square of its length."""


@dataclass(frozen=True, slots=True)
class Wrong:
    """An answer that is no plan for the task.

    Attributes:
        steps: What it wants done.
        flaw: Where that breaks.
    """

    steps: tuple[Step, ...]
    flaw: Flaw

    def __str__(self) -> str:
        step = self.flaw.step
        if not self.steps:
            return f"is empty: {self.flaw.verdict.text}"
        where = "the end" if step is None else f"step {step + 1} ({self.steps[step]})"
        return f"breaks at {where}: {self.flaw.verdict.text}"


def proved(
    view: WorldView,
    task: PlanningTask,
    texts: PddlTexts,
    answer: Solved,
    reached: Mapping[str, int] | None = None,
) -> Plan | Wrong:
    """Replays an answer.

    Args:
        view: The world.
        task: The task.
        texts: The same, as written.
        answer: What a planner says.
        reached: The highest sequence number that each robot has visited in this task.

    Raises:
        PlanningError: It speaks of what is not in the task, or is too long for anything.
    """
    return at_once(proving(view, task, texts, answer, reached))


def proving(
    view: WorldView,
    task: PlanningTask,
    texts: PddlTexts,
    answer: Solved,
    reached: Mapping[str, int] | None = None,
) -> Work[Plan | Wrong]:
    """Does what :func:`proved` does, in pieces."""
    if len(answer.steps) > _LONGEST:
        raise PlanningError(f"the planner answered with {len(answer.steps)} steps: no plan is that long")
    _check_objects(texts, answer)
    skills = {c.skill.name: c.skill for c in task.capabilities}
    keys = {name: passed_keys(skill) for name, skill in skills.items()}
    steps = read_plan(answer.steps, texts, keys)
    yield
    flaw = yield from replaying(view, steps, task.conditions, skills, reached=reached)
    if flaw is not None:
        return Wrong(steps, flaw)
    if len(steps) <= _STREAMLINED:
        steps = yield from _without_detours(view, steps, task.conditions, skills, reached)
    lines = yield from in_words(task, texts, steps, view.ontology)
    return Plan(steps, lines)


def _check_objects(texts: PddlTexts, answer: Solved) -> None:
    for name, *objects in answer.steps:
        action = texts.actions.get(name.lower())
        if action is not None and len(objects) != len(action.parameters):
            step = " ".join([name, *objects])
            raise PlanningError(
                f"the planner answered with ({step}), but {name} takes {len(action.parameters)} objects"
            )


def _without_detours(
    view: WorldView,
    steps: tuple[Step, ...],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    reached: Mapping[str, int] | None,
) -> Work[tuple[Step, ...]]:
    """Leaves out steps without which the plan still survives the replay (a satisficing planner may wander)."""
    kept: tuple[Step, ...] = ()
    for step, before, already in reversed(list(_moments(view, steps, goal, skills, reached))):
        if (yield from replaying(before, kept, goal, skills, reached=already)) is not None:
            kept = (step, *kept)
    return kept


def _moments(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    reached: Mapping[str, int] | None,
) -> Iterator[tuple[Step, Overlay, Mapping[str, int]]]:
    """Yields each step with the world, and the sequence numbers reached, just before it."""
    overlay, round_ = Overlay(view), Round(view, goal, reached)
    for step in steps:
        yield step, overlay.copy(), dict(round_.reached)
        skill = skills[step.skill]
        values = with_defaults(skill, step.arguments)
        round_.take(overlay, skill, values)
        apply_effects(overlay, skill.post, values)
