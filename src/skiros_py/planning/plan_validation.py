"""Validates plans by evaluating the *conditions* on an overlay: neither planners nor our own PDDL are trusted."""

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
"""A longer answer is refused as no plan."""
_STREAMLINED = 300
"""A plan of more steps keeps its detours: to look for them takes time in the square of its length."""


@dataclass(frozen=True, slots=True)
class Flaw:
    """Where a plan breaks.

    Attributes:
        step: Index of the step, or None when all steps run but the goal is not reached.
        verdict: What does not hold, or which condition broke, and why.
    """

    step: int | None
    verdict: Verdict


class StepConditions(Mapping[str, SkillDescription]):
    """Skills by name; what each step of them needs and brings about is worked out once.

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
        """Returns the conditions of a step with its elements in them."""
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
    """A condition of a step, which is evaluated again and again."""

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        self._pattern: Pattern | None = None
        self._binding = {argument: argument for argument in condition.arguments}

    def broken(self, view: WorldView) -> Verdict | None:
        """Returns why it does not hold; None if it does.

        Once it held, its elements are known to exist, and its pattern alone tells; where that fails, the whole
        condition says why.
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
        goal: What it is for.
        skills: What is known of the skills, by name; as :class:`StepConditions` where more than one plan is replayed.
        reached: The highest sequence number that each robot has visited in this task.

    Returns:
        The first flaw, or None when every precondition holds in its turn, every postcondition follows, the scene's
        sequence numbers are kept to, and the goal is reached at the end.
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
    """Says how a plan that is right but for sequence and work numbers breaks these; empty if it does not.

    To be asked where it is proved that a task has no plan with the numbers, and this is one without them: then they are
    why.
    """
    flaw = replay(view, steps, goal, skills, reached=reached)
    return "" if flaw is None else f"no plan keeps to the sequence numbers of this scene: {flaw.verdict.text}"


def _first_broken(view: WorldView, conditions: Iterable[_Bound]) -> Verdict | None:
    return next((verdict for bound in conditions if (verdict := bound.broken(view)) is not None), None)


def apply_effects(overlay: Overlay, post: Sequence[Condition], arguments: Mapping[str, str]) -> None:
    """Makes postconditions true on an overlay: moves what is moved, relates what is related.

    Left out are conditions that speak of parameters that are not specified; those that follow from others ("nothing is
    there") are left to the check afterwards.

    Raises:
        DescriptionError: One cannot be brought about.
    """
    for condition in applying(post, arguments):
        suppose_effects(overlay, effects_of(condition.bind(arguments)))


# ------------------------------------------------------------------ planners' answers


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


def validate(
    view: WorldView,
    task: PlanningTask,
    texts: PddlTexts,
    answer: Solved,
    reached: Mapping[str, int] | None = None,
) -> Plan | Wrong:
    """Validates a planner's answer: reads it, replays it, and removes its detours.

    Args:
        view: The world.
        task: The task.
        texts: The same, as written.
        answer: What a planner says.
        reached: The highest sequence number that each robot has visited in this task.

    Raises:
        PlanningError: It speaks of what is not in the task, or is too long for anything.
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
    """Leaves out steps without which the plan still survives the replay (a satisficing planner may wander)."""
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
