"""Simulates plans of skills on an overlay, by their *conditions*."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

from skiros_py.planning.domain.actions import needs_of, with_defaults
from skiros_py.planning.plan import Step
from skiros_py.planning.sequence import Round
from skiros_py.skills.conditions import Condition, Pattern, Verdict, judge
from skiros_py.skills.conditions.compound import Junction
from skiros_py.skills.conditions.effects import Effect, effects_of, suppose_effects
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Flaw:
    """Where a plan fails.

    Attributes:
        step: Index of the step, or None when all steps run but the goal is not reached.
        verdict: What does not hold, or which condition raised an error, and why.
    """

    step: int | None
    verdict: Verdict


class StepConditions(dict[str, SkillDescription]):
    """Skills by name; the conditions of steps and goals are bound once, for any number of replays in one world."""

    def __init__(self, skills: Mapping[str, SkillDescription]) -> None:
        super().__init__(skills)
        self._needs: dict[str, tuple[Condition, ...]] = {}
        self._steps: dict[tuple[object, ...], _BoundStep] = {}
        self._goal: dict[int, _Bound] = {}

    def of(self, step: Step) -> _BoundStep:
        """Returns the conditions of a step, bound to its elements."""
        key = (step.skill, *step.arguments.items())
        if key not in self._steps:
            if step.skill not in self._needs:
                self._needs[step.skill] = needs_of(self[step.skill])
            self._steps[key] = _BoundStep(self[step.skill], self._needs[step.skill], step)
        return self._steps[key]

    def of_goal(self, goal: Iterable[Condition]) -> list[_Bound]:
        """Returns the conditions of a goal, ready for evaluation."""
        return [self._goal.setdefault(id(condition), _Bound(condition)) for condition in goal]


class _BoundStep:
    def __init__(self, skill: SkillDescription, needs: Iterable[Condition], step: Step) -> None:
        self.skill = skill
        self.values = with_defaults(skill, step.arguments)
        self.needs = self._bound(needs)
        self.post = self._bound(skill.post)

    def _bound(self, conditions: Iterable[Condition]) -> tuple[_Bound, ...]:
        return tuple(_Bound(c.bind(self.values)) for c in applying(conditions, self.values))

    @cached_property
    def effects(self) -> list[Effect]:
        return [effect for bound in self.post for effect in effects_of(bound.condition)]


class _Bound:
    """A condition over elements that is evaluated repeatedly."""

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        self._pattern: Pattern | None = None
        self._is_pattern = _is_pattern(condition)
        self._binding = {argument: argument for argument in condition.arguments}

    def broken(self, view: WorldView) -> Verdict | None:
        """Returns why it does not hold; None if it does.

        Its pattern is matched first; if that raises, or gives no full reason, the whole condition is evaluated.
        """
        if self._pattern is None and self._is_pattern and all(_is_there(view, name) for name in self._binding):
            self._pattern = self.condition.closed_pattern(view.ontology)
        with contextlib.suppress(Exception, SystemExit):  # the whole condition reports it
            if self._pattern is not None:
                matched = self._pattern.evaluate(view, self._binding)
                if matched:
                    return None
                if not isinstance(self.condition, Junction):
                    return Verdict(False, str(self.condition), (matched,))
        verdict = judge(self.condition, view)
        return None if verdict else verdict


def _is_pattern(condition: Condition) -> bool:
    """Returns whether a condition means just its pattern, not what an author's function says."""
    if isinstance(condition, Junction):
        return all(map(_is_pattern, condition.parts))
    return type(condition).evaluate is Condition.evaluate


def _is_there(view: WorldView, name: str) -> bool:
    return name in view.ontology.classes or view.has(name)


class Simulation:
    """A plan simulated on an overlay; the given view is not changed.

    Args:
        view: The world.
        goal: The goal of the plan.
        skills: The skill descriptions by name; as :class:`StepConditions` if more than one plan is simulated.
        reached: The highest sequence number that each robot has visited in this task.
    """

    def __init__(
        self,
        view: WorldView,
        goal: Sequence[Condition],
        skills: Mapping[str, SkillDescription],
        reached: Mapping[str, int] | None = None,
    ) -> None:
        self._conditions = skills if isinstance(skills, StepConditions) else StepConditions(skills)
        self._goal = self._conditions.of_goal(goal)
        self._overlay = Overlay(view)
        self._round = Round(view, goal, reached)

    def run(self, steps: Sequence[Step], before: list[Simulation] | None = None) -> Flaw | None:
        """Runs steps to the end of the plan.

        Args:
            steps: All that is left of the plan.
            before: Gets a copy of the simulation as it is before each step.

        Returns:
            The first flaw, or None when every precondition holds in turn, every postcondition follows, the scene's
            sequence numbers are respected, and the goal is reached at the end.
        """
        for index, step in enumerate(steps):
            if before is not None:
                before.append(self._copy())
            broken = self._take(step)
            if broken is not None:
                return Flaw(index, broken)
        broken = _first_broken(self._overlay, self._goal)
        return None if broken is None else Flaw(None, broken)

    def _take(self, step: Step) -> Verdict | None:
        bound = self._conditions.of(step)
        broken = _first_broken(self._overlay, bound.needs)
        if broken is None:
            broken = self._round.take(self._overlay, bound.skill, bound.values)
        if broken is None:
            suppose_effects(self._overlay, bound.effects)
            broken = _first_broken(self._overlay, bound.post)
        return broken

    def _copy(self) -> Simulation:
        other = copy(self)
        vars(other).update(_overlay=self._overlay.copy(), _round=self._round.copy())
        return other


def replay(
    view: WorldView,
    steps: Sequence[Step],
    goal: Sequence[Condition],
    skills: Mapping[str, SkillDescription],
    *,
    reached: Mapping[str, int] | None = None,
) -> Flaw | None:
    """Simulates a plan; see :class:`Simulation`. Returns its first flaw, or None when it leads to the goal."""
    return Simulation(view, goal, skills, reached).run(steps)


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
