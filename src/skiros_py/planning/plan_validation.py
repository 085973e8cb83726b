"""Validates plans by evaluating the *conditions* on an overlay: neither planners nor our own PDDL is trusted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.needs import needs_of, passed_keys, with_defaults
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step, read_plan
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.regrounding import pddl_plan
from skiros_py.planning.sequence import Round
from skiros_py.skills.conditions import Condition, Effect, Pattern, Verdict, effects_of, judge, suppose_effects
from skiros_py.skills.inference import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

_LONGEST = 10_000
"""Longer answers are rejected."""
_STREAMLINED = 300
"""Detours are not removed from longer plans: the search takes quadratic time."""


@dataclass(frozen=True, slots=True)
class Flaw:
    """Where a plan fails.

    Attributes:
        step: Index of the step, or None when all steps run but the goal is not reached.
        verdict: What does not hold, or which condition raised an error, and why.
    """

    step: int | None
    verdict: Verdict


class StepConditions(Mapping[str, SkillDescription]):
    """Skills by name; the bound conditions of each step are computed once.

    Args:
        skills: The skills by name.
    """

    def __init__(self, skills: Mapping[str, SkillDescription]) -> None:
        self._skills = skills
        self._bound: dict[tuple[object, ...], _BoundStep] = {}

    def __getitem__(self, name: str) -> SkillDescription:
        return self._skills[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._skills)

    def __len__(self) -> int:
        return len(self._skills)

    def of(self, step: Step) -> _BoundStep:
        """Returns the conditions of a step, bound to its elements."""
        key = (step.skill, *step.arguments.items())
        if key not in self._bound:
            self._bound[key] = _BoundStep(self._skills[step.skill], step)
        return self._bound[key]


class _BoundStep:
    def __init__(self, skill: SkillDescription, step: Step) -> None:
        self.skill = skill
        self.values = with_defaults(skill, step.arguments)
        self.needs = tuple(_Bound(c.bind(self.values)) for c in applying(needs_of(skill), self.values))
        self.post = tuple(_Bound(c.bind(self.values)) for c in applying(skill.post, self.values))

    @cached_property
    def effects(self) -> list[Iterable[Effect]]:
        return [effects_of(bound.condition) for bound in self.post]

    def apply(self, overlay: Overlay) -> None:
        for effects in self.effects:
            suppose_effects(overlay, effects)


class _Bound:
    """A condition of a step that is evaluated repeatedly."""

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        self._pattern: Pattern | None = None
        self._binding = {argument: argument for argument in condition.arguments}

    def broken(self, view: WorldView) -> Verdict | None:
        """Returns why it does not hold; None if it does.

        Once it has held, its elements are known to exist and matching its pattern suffices; if that fails, the whole
        condition is evaluated for the reason.
        """
        if self._pattern is not None and self._pattern.evaluate(view, self._binding):
            return None
        verdict = judge(self.condition, view)
        if not verdict:
            return verdict
        if type(self.condition).evaluate is Condition.evaluate:
            self._pattern = self.condition.closed_pattern(view.ontology)
        return None


def replay(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> Flaw | None:
    """Simulates a plan on an overlay; the given view is not changed.

    Args:
        view: The world.
        steps: The plan.
        goal: The goal it should reach.
        skills: The skill descriptions by name; as :class:`StepConditions` if more than one plan is replayed.
        reached: The highest sequence number that each robot has visited in this task.

    Returns:
        The first flaw, or None when every precondition holds in turn, every postcondition follows, the scene's
        sequence numbers are respected, and the goal is reached at the end.
    """
    conditions = skills if isinstance(skills, StepConditions) else StepConditions(skills)
    overlay, round_ = Overlay(view), Round(view, goal, reached)
    for index, step in enumerate(steps):
        bound = conditions.of(step)
        broken = _first_broken(overlay, bound.needs)
        if broken is None:
            broken = round_.take(overlay, bound.skill, bound.values)
        if broken is None:
            bound.apply(overlay)
            broken = _first_broken(overlay, bound.post)
        if broken is not None:
            return Flaw(index, broken)
    return next((Flaw(None, verdict) for c in goal if not (verdict := judge(c, overlay))), None)


def out_of_sequence(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> str:
    """Returns how an otherwise valid plan violates sequence or work numbers; empty if it does not.

    Meant for a task that provably has no plan with the numbers when this is a plan without them: then the numbers are
    the reason.
    """
    flaw = replay(view, steps, goal, skills, reached=reached)
    return "" if flaw is None else f"no plan keeps to the sequence numbers of this scene: {flaw.verdict.text}"


def _first_broken(view: WorldView, conditions: Iterable[_Bound]) -> Verdict | None:
    return next((verdict for bound in conditions if (verdict := bound.broken(view)) is not None), None)


def apply_effects(overlay: Overlay, post: Sequence[Condition], arguments: Mapping[str, str]) -> None:
    """Makes postconditions true on an overlay: applies moves and relations.

    Conditions on unspecified parameters are skipped; derived ones ("nothing is there") are left to the check
    afterwards.

    Raises:
        DescriptionError: A postcondition cannot be made true.
    """
    for condition in applying(post, arguments):
        suppose_effects(overlay, effects_of(condition.bind(arguments)))


# ------------------------------------------------------------------ planners' answers


@dataclass(frozen=True, slots=True)
class Wrong:
    """An answer that is not a valid plan for the task.

    Attributes:
        steps: Its steps.
        flaw: Where it fails.
    """

    steps: tuple[Step, ...]
    flaw: Flaw

    def __str__(self) -> str:
        step = self.flaw.step
        if not self.steps:
            return f"is empty: {self.flaw.verdict.text}"
        where = "the end" if step is None else f"step {step + 1} ({self.steps[step]})"
        return f"breaks at {where}: {self.flaw.verdict.text}"


def validate(
    view: WorldView,
    task: PlanningTask,
    texts: PddlTexts,
    answer: Solved,
    reached: Mapping[str, int] | None = None,
) -> Plan | Wrong:
    """Validates a planner's answer: parses it, replays it, and removes detours.

    Args:
        view: The world.
        task: The task.
        texts: The task as PDDL.
        answer: The planner's answer.
        reached: The highest sequence number that each robot has visited in this task.

    Raises:
        PlanningError: It refers to things not in the task, or is too long.
    """
    if len(answer.steps) > _LONGEST:
        raise PlanningError(f"the planner answered with {len(answer.steps)} steps: no plan is that long")
    _check_objects(texts, answer)
    skills = StepConditions({c.skill.name: c.skill for c in task.capabilities})
    keys = {name: passed_keys(skill) for name, skill in skills.items()}
    steps = read_plan(answer.steps, texts, keys)
    flaw = replay(view, steps, task.conditions, skills, reached=reached)
    if flaw is not None:
        return Wrong(steps, flaw)
    if len(steps) <= _STREAMLINED:
        steps = _without_detours(view, steps, task.conditions, skills, reached)
    lines = pddl_plan(task, texts, steps, view.ontology)
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
    skills: StepConditions,
    reached: Mapping[str, int] | None,
) -> tuple[Step, ...]:
    """Removes steps without which the plan still replays successfully (satisficing planners may take detours)."""
    overlay, round_ = Overlay(view), Round(view, goal, reached)
    moments = []  # each step with the world, and the sequence numbers reached, just before it
    for step in steps:
        moments.append((step, overlay.copy(), dict(round_.reached)))
        bound = skills.of(step)
        round_.take(overlay, bound.skill, bound.values)
        bound.apply(overlay)
    kept: tuple[Step, ...] = ()
    for step, before, already in reversed(moments):
        if replay(before, kept, goal, skills, reached=already) is not None:
            kept = (step, *kept)
    return kept
