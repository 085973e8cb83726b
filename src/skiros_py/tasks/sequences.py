"""A sequence of steps edited by the user; after each edit its effects are checked (paper §4.1)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from skiros_py.errors import SkirosError, UnknownName, UsageError
from skiros_py.execution.containment import contained
from skiros_py.planning.domain.actions import needs_of, with_defaults
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.stock import tokens_of, with_stock
from skiros_py.planning.replay import apply_effects
from skiros_py.skills.conditions import judge
from skiros_py.skills.inference import Inferred, Missing, applying, infer
from skiros_py.skills.outcome import Failure
from skiros_py.skills.parameters import read_arguments
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.trace_writer import short_step
from skiros_py.world.index import Index
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class StepCheck:
    """The result of checking one step before it runs.

    Attributes:
        step: The step.
        problems: What will not hold when its turn comes, one sentence each; empty if it can work.
        agent: The agent that runs it, given or inferred; empty if none is found.
    """

    step: Step
    problems: tuple[str, ...] = ()
    agent: str = ""

    @property
    def works(self) -> bool:
        """True if it has no problems."""
        return not self.problems

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        step = {"skill": self.step.skill, "arguments": dict(self.step.arguments)}
        return {**step, "agent": self.agent, "works": self.works, "problems": list(self.problems)}


class StepSequence:
    """Steps to be run one after the other, in the order and with the arguments the user chose.

    Args:
        view: The world that it starts from: the live one, so that checks are always current.
        skills: The available skills by name.
        steps: The initial steps, such as those of a plan; none to start from scratch.

    Raises:
        UsageError: A step names a skill, a parameter or an element that does not exist.
    """

    def __init__(
        self, view: WorldView, skills: Mapping[str, SkillDescription], steps: Sequence[Step] | Plan = ()
    ) -> None:
        self._view = view
        self._skills = skills
        given = steps.steps if isinstance(steps, Plan) else steps
        self._steps = [self._read(step.skill, step.arguments) for step in given]

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps, in order."""
        return tuple(self._steps)

    # ------------------------------------------------------------------ editing

    def add(self, skill: str, **arguments: str) -> tuple[StepCheck, ...]:
        """Adds a step at the end; see :meth:`insert`."""
        return self.insert(len(self._steps), skill, **arguments)

    def insert(self, at: int, skill: str, **arguments: str) -> tuple[StepCheck, ...]:
        """Adds a step before another one.

        Args:
            at: Index of that step; the number of steps to append.
            skill: Name of the skill.
            **arguments: Element ids by parameter key; omitted ones are inferred when it starts.

        Returns:
            All steps afterwards, checked.

        Raises:
            UsageError: There is no such skill, parameter, element or place.
        """
        self._steps.insert(self._index(at, len(self._steps)), self._read(skill, arguments))
        return self.checks

    def remove(self, at: int) -> tuple[StepCheck, ...]:
        """Removes a step.

        Raises:
            UsageError: There is no such step.
        """
        del self._steps[self._index(at, len(self._steps) - 1)]
        return self.checks

    def move(self, at: int, to: int) -> tuple[StepCheck, ...]:
        """Moves a step to another place.

        Args:
            at: Its index.
            to: Its index afterwards.

        Raises:
            UsageError: There is no such step or place.
        """
        last = len(self._steps) - 1
        at, to = self._index(at, last), self._index(to, last)
        self._steps.insert(to, self._steps.pop(at))
        return self.checks

    def change(self, at: int, **arguments: str | None) -> tuple[StepCheck, ...]:
        """Changes some arguments of a step; None leaves one to be inferred.

        Raises:
            UsageError: There is no such step, parameter or element.
        """
        step = self._steps[self._index(at, len(self._steps) - 1)]
        self._steps[at] = self._read(step.skill, {**step.arguments, **arguments})
        return self.checks

    # ------------------------------------------------------------------ checking

    @property
    def checks(self) -> tuple[StepCheck, ...]:
        """Every step with the problems that can be foreseen."""
        return check_steps(self._view, self._steps, self._skills)

    @property
    def works(self) -> bool:
        """True if no step has problems."""
        return all(check.works for check in self.checks)

    def require_steps(self) -> None:
        """Checks that the sequence is not empty.

        Raises:
            UsageError: It is empty.
        """
        if not self._steps:
            raise UsageError("the sequence has no steps: add one")

    def require_works(self) -> None:
        """Checks that the sequence can be run.

        Raises:
            UsageError: It is empty, or cannot work; the text says which step and why.
        """
        self.require_steps()
        broken = [(n, check) for n, check in enumerate(self.checks, start=1) if not check.works]
        if broken:
            said = [f"step {n} ({self._said(check.step)}): {'; '.join(check.problems)}" for n, check in broken]
            raise UsageError(f"the sequence cannot work: {' / '.join(said)}; mend it, or run it anyway")

    def __str__(self) -> str:
        marks = (f"{n:2}. {self._said(c.step)}{''.join(f' - {p}' for p in c.problems)}" for n, c in self._numbered())
        return "\n".join(marks)

    def _numbered(self) -> list[tuple[int, StepCheck]]:
        return list(enumerate(self.checks, start=1))

    def _said(self, step: Step) -> str:
        return short_step(step, self._skills[step.skill])

    def _read(self, skill: str, arguments: Mapping[str, Any]) -> Step:
        if skill not in self._skills:
            raise UnknownName("skill", skill, self._skills)
        given = {key: value for key, value in arguments.items() if value is not None}
        view = with_stock(self._view, named=tokens_of((Step(skill, given),)))
        values = read_arguments(self._skills[skill].params, given, view)
        return Step(skill, MappingProxyType({key: values[key] for key in given}))

    def _index(self, at: int, last: int) -> int:
        if isinstance(at, bool) or not isinstance(at, int) or not 0 <= at <= last:
            there = f"from 0 to {last}" if last >= 0 else "of a step, and there is none"
            raise UsageError(f"a place in the sequence is a number {there}, not {at!r}")
        return at


def check_steps(
    view: WorldView,
    steps: Sequence[Step],
    skills: Mapping[str, SkillDescription],
    able: Mapping[str, Collection[str]] | None = None,
) -> tuple[StepCheck, ...]:
    """Checks steps in turn; steps after a failing one are checked as if it had worked.

    Args:
        view: The world that they start from.
        steps: The steps.
        skills: The available skills by name.
        able: The subsystems that provide each skill now; None to accept any suitable subsystem.
    """
    overlay = Overlay(with_stock(view, named=tokens_of(steps)))
    return tuple(_check(overlay, step, skills, able) for step in steps)


@dataclass(frozen=True, slots=True)
class StepsCheck:
    """A planning request to check steps; see :func:`check_steps` for its attributes."""

    steps: tuple[Step, ...]
    skills: Mapping[str, SkillDescription]
    able: Mapping[str, Collection[str]] | None = None

    def answer(self, state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> tuple[StepCheck, ...]:
        """Checks the steps."""
        return check_steps(state, self.steps, self.skills, self.able)


def _check(
    overlay: Overlay, step: Step, skills: Mapping[str, SkillDescription], able: Mapping[str, Collection[str]] | None
) -> StepCheck:
    """Returns a step's problems, then applies its effects as if it had worked."""
    if step.skill not in skills:
        return StepCheck(step, (f"no subsystem has the skill {step.skill} any more",))
    skill = skills[step.skill]
    found = cast(step, skill, overlay, None if able is None else able.get(step.skill, ()))
    return StepCheck(step, tuple(_problems(overlay, skill, found)), found.values.get(skill.agent, ""))


def _problems(overlay: Overlay, skill: SkillDescription, found: Cast) -> list[str]:
    values = found.values
    verdicts = [judge(c, overlay, values) for c in applying(needs_of(skill), values)]
    problems = [*found.open, *(verdict.why for verdict in verdicts if not verdict)]
    try:
        apply_effects(overlay, skill.post, values)
    except SkirosError as error:
        return [*problems, str(error)]
    after = [judge(c, overlay, values) for c in applying(skill.post, values)]
    return problems + [f"{v.text} does not follow" for v in after if not v and not problems]


@dataclass(frozen=True, slots=True)
class Cast:
    """The elements of a step.

    Attributes:
        values: The known element ids by parameter key.
        open: Why parameters remain open, one sentence each.
    """

    values: Mapping[str, str]
    open: tuple[str, ...] = ()


def cast(step: Step, skill: SkillDescription, view: WorldView, able: Collection[str] | None = None) -> Cast:
    """Infers the arguments that a step omits.

    Args:
        step: The step.
        skill: The description of its skill.
        view: The world just before the step.
        able: The subsystems whose skill managers provide the skill; None to accept any suitable one. The one that
            inference prefers is tried first, then the others by id.
    """
    given = with_defaults(skill, step.arguments)
    found = _inferred(skill, given, view, None)
    if able is None or skill.agent in given or found.values.get(skill.agent) in able:
        return found
    each = [_inferred(skill, given, view, agent) for agent in sorted(able)]
    return next((one for one in each if not one.open), each[0] if each else _nobody(skill, given))


def _inferred(skill: SkillDescription, given: Mapping[str, str], view: WorldView, agent: str | None) -> Cast:
    """Runs inference; if a user-defined condition raises an error, omitted arguments remain open."""
    found: Inferred | Missing | Failure = contained("inference", lambda: infer(skill, given, view, agent))
    if isinstance(found, Failure):
        return Cast(given, (found.reason,))
    elements = {p.key for p in skill.params if p.is_element}
    values = {key: value for key, value in found.values.items() if key in elements and value is not None}
    return Cast(values, tuple(v.text for v in found.verdicts.values()) if isinstance(found, Missing) else ())


def _nobody(skill: SkillDescription, given: Mapping[str, str]) -> Cast:
    return Cast(given, (f"no subsystem has the skill {skill.name} any more",))
