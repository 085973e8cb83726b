"""Steps that the user puts in order (paper §4.1): read, and checked in the worlds that the steps before them leave."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from skiros_py.errors import SkirosError, UnknownName
from skiros_py.execution.module_faults import contained
from skiros_py.messages import Message
from skiros_py.planning.domain.actions import needs_of, with_defaults
from skiros_py.planning.plan import Step
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.stock import tokens_of, with_stock
from skiros_py.planning.replay import apply_effects
from skiros_py.skills.conditions import judge
from skiros_py.skills.inference.inferring import Inferred, Missing, applying, infer
from skiros_py.skills.outcome import Failure
from skiros_py.skills.parameters import read_arguments
from skiros_py.skills.skill import SkillDescription
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
        is_known: False if it names a skill, a parameter or an element that does not exist: its only problem.
    """

    step: Step
    problems: tuple[str, ...] = ()
    agent: str = ""
    is_known: bool = True


def read_step(step: Step, view: WorldView, skills: Mapping[str, SkillDescription]) -> Step:
    """Returns a step with its arguments read.

    Args:
        step: Its arguments are element ids by parameter key; omitted ones are inferred when it starts.
        view: The world.
        skills: The available skills by name.

    Raises:
        UsageError: It names a skill, a parameter or an element that does not exist.
    """
    if step.skill not in skills:
        raise UnknownName("skill", step.skill, skills)
    values = read_arguments(skills[step.skill].params, step.arguments, with_stock(view, named=tokens_of((step,))))
    return Step(step.skill, MappingProxyType({key: values[key] for key in step.arguments}))


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
    try:
        read_step(step, overlay, skills)
    except SkirosError as error:
        return StepCheck(step, (str(error),), is_known=False)
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
    return problems + [Message("{text} does not follow", text=v.text) for v in after if not v and not problems]


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
    missing = Cast(given, (Message("no subsystem has the skill {skill} any more", skill=skill.name),))
    return next((one for one in each if not one.open), each[0] if each else missing)


def _inferred(skill: SkillDescription, given: Mapping[str, str], view: WorldView, agent: str | None) -> Cast:
    """Runs inference; if a user-defined condition raises an error, omitted arguments remain open."""
    found: Inferred | Missing | Failure = contained("inference", lambda: infer(skill, given, view, agent))
    if isinstance(found, Failure):
        return Cast(given, (found.reason,))
    elements = {p.key for p in skill.params if p.is_element}
    values = {key: value for key, value in found.values.items() if key in elements and value is not None}
    return Cast(values, tuple(v.text for v in found.verdicts.values()) if isinstance(found, Missing) else ())
