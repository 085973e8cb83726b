"""The history of attempts at a goal: executed steps, failures per target, and their effect on its conditions."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Mapping

from skiros_py.planning.domain.actions import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.planning.sequence import Round
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.report import StepReport
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DEVICE, ROBOT

_LONGEST = 10_000
"""Maximum number of steps kept per task: a sequence may run for months."""


class History:
    """The attempts at one goal.

    Args:
        view: The live world.
        attempts: How often a skill may fail on one target before that target is left out of further plans.
        longest: How many steps are kept; the oldest are dropped first.

    Attributes:
        steps: The most recent executed steps, in the order in which they ended.
        forgotten: How many earlier steps were dropped.
    """

    def __init__(self, view: WorldView, attempts: int, *, longest: int = _LONGEST) -> None:
        self.attempts = attempts
        self.steps: deque[StepReport] = deque(maxlen=longest)
        self.forgotten = 0
        self._view = view
        self._skills: dict[str, SkillDescription] = {}
        self._failures: Counter[tuple[str, str]] = Counter()
        self._reasons: dict[str, str] = {}
        self._round = Round(view)

    def record(self, step: Step, skill: SkillDescription, start: float, end: float, outcome: Outcome) -> None:
        """Adds one step; a step cancelled because the world changed does not count as a failure of its skill."""
        reason = outcome.reason if isinstance(outcome, Failure) else ""
        self._skills[step.skill] = skill
        self.forgotten += len(self.steps) == self.steps.maxlen
        self.steps.append(StepReport(step.skill, dict(step.arguments), start, end, reason, step.arguments[skill.agent]))
        target = step.arguments.get(skill.target)  # the user may have left it open
        if target is not None and isinstance(outcome, Failure) and outcome.code != BROKEN_OFF:
            self._failures[step.skill, target] += 1
            self._reasons[target] = reason
        if not reason:
            self._round.take(self._view, skill, with_defaults(skill, step.arguments))

    @property
    def reached(self) -> Mapping[str, int]:
        """The highest sequence number that each robot has visited in this task."""
        return dict(self._round.reached)

    @property
    def left_out(self) -> frozenset[str]:
        """Targets on which a skill failed too often."""
        return frozenset(target for (_, target), count in self._failures.items() if count >= self.attempts)

    def forgive(self) -> None:
        """Clears the list of excluded targets: the situation has changed and they may work now."""
        self._failures.clear()

    def tries(self, condition: Condition, *, holds: bool) -> int:
        """Counts the attempts at this condition: each failed step made for it, and the success."""
        own = [step for step in self.steps if self._is_for(step, condition)]
        failed = sum(bool(step.reason) for step in own)
        return failed + 1 if own and holds else failed

    def why_missing(self, condition: Condition, given_up: Mapping[Condition, str]) -> str:
        """Returns the last failure; if there was none, why there is no plan."""
        failed = [(t, r) for t, r in self._reasons.items() if any(self._fits(t, a) for a in condition.arguments)]
        if not failed:
            return given_up.get(condition, "gave up: plan after plan did not lead there")
        target, reason = failed[-1]
        gave_up = f"; gave up on {target} after {self.attempts} failed tries" if target in self.left_out else ""
        return reason + gave_up

    def _is_for(self, step: StepReport, condition: Condition) -> bool:
        """Returns True if the step's target, or an element it moves, occurs in the condition."""
        skill = self._skills[step.skill]
        if self._names_another_target(condition, step.arguments[skill.target], skill.param(skill.target).element_class):
            return False
        moved = {
            a for post in skill.post for a in post.arguments if not self._is_hardware(skill.param(a).element_class)
        }
        values = with_defaults(skill, step.arguments)
        subjects = {values[key] for key in moved | {skill.target} if key in values}
        return any(self._fits(subject, argument) for subject in subjects for argument in condition.arguments)

    def _names_another_target(self, condition: Condition, target: str, class_: str) -> bool:
        """Returns True if the condition names an element of the target's class other than this target."""
        named = [a for a in condition.arguments if self._view.has(a)]
        return target not in named and any(self._is_a(a, class_) for a in named)

    def _is_hardware(self, class_: str) -> bool:
        return any(self._view.ontology.is_a(class_, own) for own in (ROBOT, DEVICE))

    def _fits(self, element: str, argument: str) -> bool:
        if argument in self._view.ontology.classes:
            return self._view.has(element) and self._is_a(element, argument)
        return element == argument

    def _is_a(self, element: str, class_: str) -> bool:
        return self._view.ontology.is_a(self._view.element(element).type, class_)
