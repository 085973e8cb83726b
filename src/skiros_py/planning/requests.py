"""Planning requests: plain data, answered from one state of the world, in any process."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, Protocol, TypeVar

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.interruptions import Interruption
from skiros_py.messages import Message
from skiros_py.planning.domain.actions import with_defaults
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.planners.planner import FuturePending, Planners
from skiros_py.planning.problem.stock import tokens_of, with_stock
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.replay import Flaw, apply_effects, replay
from skiros_py.planning.sequence import Round
from skiros_py.planning.service import USUAL, Planned, PlanningOptions, plan
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    Condition,
    ConditionType,
    Exists,
    Pattern,
    Related,
    Role,
    Verdict,
)
from skiros_py.skills.conditions.watch import Key, ReadingView
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.world.index import Index
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import NO_SENSORS, WorldView
from skiros_py.world.vocabulary import AT, HAS_A, IN, LOCATION, MANIPULATABLE, ROBOT

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Request(Protocol[T_co]):
    """A computation on one state of the world. Its conditions have no access to sensors."""

    def answer(self, state: Index, planners: Planners, stopped: Callable[[], bool]) -> T_co:
        """Computes the answer.

        Args:
            state: The world.
            planners: The planners to choose from.
            stopped: Returns True once the request is cancelled.

        Raises:
            SkirosError: There is no answer.
        """


@dataclass(frozen=True, slots=True)
class Answer(Generic[T]):
    """An answer, and the version of the world that it refers to."""

    version: int
    value: T


class Asked(FuturePending[Answer[T]]):
    """A pending request."""

    def when_done(self, callback: Callable[[Asked[T]], None]) -> None:
        """Calls back when the answer is available, in an arbitrary thread."""
        self._future.add_done_callback(lambda _future: callback(self))


class PlanningHost(Protocol):
    """Where requests are answered: a thread or a process. Thread-safe."""

    def ask(self, request: Request[T]) -> Asked[T]:
        """Submits a request about the current world and returns at once.

        Raises:
            PlanningError: It was closed, or the request cannot be sent to the process that answers.
        """

    def close(self) -> None:
        """Cancels all pending requests; may be called twice."""


def answered(request: Request[T], state: Index, planners: Planners, stopped: Callable[[], bool]) -> T:
    """Answers a request; exceptions of user-defined conditions become planning errors.

    Raises:
        SkirosError: There is no answer.
    """
    try:
        return request.answer(state, planners, stopped)
    except (SkirosError, KeyboardInterrupt, Interruption):
        raise
    except SystemExit as error:
        raise PlanningError(f"planning broke: it tried to end the program: sys.exit({error.code!r})") from error
    except BaseException as error:
        raise PlanningError(f"planning broke: {type(error).__name__}: {error}") from error


@dataclass(frozen=True, slots=True)
class _NotLeftOut:
    """Tells whether an agent may try a target: any but those that are left out.

    Attributes:
        why: The reason for each that is.
    """

    why: tuple[tuple[str, str], ...]

    def __call__(self, view: WorldView, agent: str, target: str) -> Verdict:  # noqa: ARG002 - as functions of relations
        reason = dict(self.why).get(target)
        if reason is None:
            return Verdict(True, Message("{agent} may try {target}", agent=agent, target=target))
        return Verdict(False, Message("{target} was given up: {reason}", target=target, reason=reason))


@dataclass(frozen=True, slots=True)
class RuledOut:
    """An attempt that would fail again.

    Attributes:
        skill: The skill; None for any.
        agent: Who tried it, or its robot.
        target: Its target; None for any.
        place: Where the robot was; None for anywhere.
        reason: Why it fails.
        blocker: Id of what blocks it, and of the place that it is in: it does not fail while that is in another
            place. None where it always fails.
    """

    skill: str | None
    agent: str
    target: str | None
    place: str | None
    reason: str
    blocker: tuple[str, str] | None = None

    def is_of(self, skill: str, agents: Collection[str], target: str | None) -> bool:
        """Returns whether it is an attempt of this kind by any of some agents, wherever their robot is."""
        return self.skill in (None, skill) and self.agent in agents and self.target in (None, target)


@dataclass(frozen=True, slots=True)
class _MayTry:
    """Tells whether an agent may try a target.

    Attributes:
        ruled_out: What it may not try.
    """

    ruled_out: tuple[RuledOut, ...]

    def __call__(self, view: WorldView, agent: str, target: str) -> Verdict:
        for one in self.ruled_out:
            if one.agent in (agent, robot_of(view, agent)) and one.target in (None, target):
                return Verdict(False, Message("{agent}: {reason}", agent=agent, reason=one.reason))
        return Verdict(True, Message("{agent} may try {target}", agent=agent, target=target))


@dataclass(frozen=True, slots=True)
class _MayTryFrom:
    """Tells whether a target was not tried from a place.

    Attributes:
        ruled_out: What was tried.
    """

    ruled_out: tuple[RuledOut, ...]

    def __call__(self, view: WorldView, place: str, target: str) -> Verdict:  # noqa: ARG002 - as functions of relations
        for one in self.ruled_out:
            if (one.place, one.target) == (place, target):
                return Verdict(False, Message("from {place}: {reason}", place=place, reason=one.reason))
        return Verdict(True, Message("{target} was not tried from {place}", place=place, target=target))


@dataclass(frozen=True, slots=True)
class _IsOneOf:
    """Tells whether two elements are one of some pairs, or are none of them.

    Attributes:
        pairs: The pairs.
        wanted: True for one of them, False for none.
    """

    pairs: frozenset[tuple[str, str]]
    wanted: bool

    def __call__(self, _view: WorldView, one: str, other: str) -> Verdict:
        holds = ((one, other) in self.pairs) is self.wanted
        return Verdict(holds, Message("{one} and {other}", one=one, other=other))


def _unblocked(skill: str, agent: str, target: str, blocked: Sequence[RuledOut]) -> Iterator[Pattern]:
    """Yields that each thing that blocked a target is elsewhere.

    Args:
        skill: Name of the skill: what it computes for a task goes by its name there.
        agent: Key of the parameter for who tries it.
        target: Key of the parameter for its target.
        blocked: Attempts that something blocked.
    """
    found: dict[tuple[str, str], dict[tuple[str, str], RuledOut]] = {}
    for one in blocked:
        if one.target is not None and one.blocker is not None:
            found.setdefault((one.agent, one.target), {})[one.blocker] = one
    for number in range(max(map(len, found.values()), default=0)):  # so many block one target
        nth = [[*of_one.values()][number] for of_one in found.values() if number < len(of_one)]
        pairs = frozenset((one.blocker[0], one.target) for one in nth if one.blocker and one.target)
        places = frozenset(one.blocker for one in nth if one.blocker)
        moved = AllOf(
            (
                Computed(f"blocks {skill} {number}", "thing", target, _IsOneOf(pairs, wanted=True)),
                Related(IN, "thing", "elsewhere"),
                Computed(f"away after {skill} {number}", "thing", "elsewhere", _IsOneOf(places, wanted=False)),
            )
        )
        elsewhere = Exists("thing", MANIPULATABLE, Exists("elsewhere", LOCATION, moved))
        yield AnyOf((Computed(f"may {skill} beside {number}", agent, target, _MayTry(tuple(nth))), elsewhere))


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """A request for a plan.

    Attributes:
        goal: The conditions that must all hold.
        capabilities: The available skills.
        reached: The highest sequence number that each robot has visited in this task.
        left_out: Elements that no skill of a plan may have as its target, each with the reason; nor are they chosen.
        ruled_out: Attempts that are not planned again.
        busy: Robots and things that other tasks use: planned with only as a last resort.
        running: Running steps, assumed to succeed.
        options: Planning options.
    """

    goal: tuple[Condition, ...]
    capabilities: tuple[Capability, ...]
    reached: Mapping[str, int] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)
    ruled_out: tuple[RuledOut, ...] = ()
    busy: frozenset[str] = frozenset()
    running: tuple[Step, ...] = ()
    options: PlanningOptions = USUAL

    def answer(self, state: Index, planners: Planners, stopped: Callable[[], bool]) -> Planned:
        """Plans."""
        if self.busy:
            free = tuple(one for c in self.capabilities if (one := self._free(c, state)).agents)
            planned = self._plan(state, self.busy.union(self.left_out), free, planners, stopped)
            if isinstance(planned.outcome, Plan):
                return planned
        return self._plan(state, frozenset(self.left_out), self.capabilities, planners, stopped)

    def _plan(
        self,
        state: Index,
        without: frozenset[str],
        capabilities: Sequence[Capability],
        planners: Planners,
        stopped: Callable[[], bool],
    ) -> Planned:
        view: WorldView = Overlay(state, without) if without else state
        reached = self.reached
        if self.running:
            skills = {c.skill.name: c.skill for c in self.capabilities}
            view, reached = supposing(view, self.running, skills, reached)
        if self.left_out or self.ruled_out:
            capabilities = [replace(c, skill=self._restricted(c.skill)) for c in capabilities]
        return plan(planners, view, capabilities, self.goal, reached=reached, options=self.options, stopped=stopped)

    def _restricted(self, skill: SkillDescription) -> SkillDescription:
        """Returns a skill for other targets only: facts may lead to one that is left out, though none is chosen."""
        agent, target = skill.agent, skill.target
        roles = tuple(Role(key, skill.param(key).element_class) for key in (agent, target))
        all_own = tuple(one for one in self.ruled_out if one.skill in (None, skill.name))
        own = tuple(one for one in all_own if one.blocker is None)
        patterns = [*_unblocked(skill.name, agent, target, [one for one in all_own if one.blocker is not None])]
        if self.left_out:
            patterns.append(Computed("may try", agent, target, _NotLeftOut(tuple(sorted(self.left_out.items())))))
        if anywhere := tuple(one for one in own if one.place is None):
            patterns.append(Computed(f"may {skill.name}", agent, target, _MayTry(anywhere)))
        if there := tuple(one for one in own if one.place is not None):
            stands = Exists("robot", ROBOT, AllOf((Related(HAS_A, "robot", agent), Related(AT, "robot", "place"))))
            new = Computed(f"may {skill.name} from", "place", target, _MayTryFrom(there))
            elsewhere = Exists("place", LOCATION, AllOf((stands, new)))
            patterns.append(AnyOf((Computed(f"may {skill.name} at all", agent, target, _MayTry(there)), elsewhere)))
        if not patterns:
            return skill
        may_try = ConditionType("MayTry", roles, AllOf(tuple(patterns)), "The target was not given up.")
        return replace(skill, pre=(*skill.pre, may_try(agent, target)))

    def _free(self, capability: Capability, view: WorldView) -> Capability:
        """Restricts a capability to subsystems whose robots no other task uses."""
        return replace(capability, agents=tuple(a for a in capability.agents if robot_of(view, a) not in self.busy))


@dataclass(frozen=True, slots=True)
class Checked:
    """Whether the rest of a plan leads to its goal.

    Attributes:
        flaw: The first flaw; None if there is none.
        keys: What was read of the world: while none of it changes, the answer stays valid.
    """

    flaw: Flaw | None
    keys: frozenset[Key]


@dataclass(frozen=True, slots=True)
class Check:
    """A request to check whether the rest of a plan still leads to its goal, assuming running steps succeed.

    Attributes:
        goal: The goal of the plan.
        running: The running steps.
        rest: The steps that have not started, in order.
        skills: The skills of all these, by name.
        reached: The highest sequence number that each robot has visited in this task.
    """

    goal: tuple[Condition, ...]
    running: tuple[Step, ...]
    rest: tuple[Step, ...]
    skills: Mapping[str, SkillDescription]
    reached: Mapping[str, int] = field(default_factory=dict)

    def answer(self, state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> Checked:
        """Replays the steps."""
        view = ReadingView(state, NO_SENSORS)
        return Checked(self._flaw(view), frozenset(view.keys))

    def _flaw(self, view: WorldView) -> Flaw | None:
        stocked = with_stock(view, self.goal, tokens_of(self.rest))
        for index, step in enumerate(self.rest):
            gone = [name for name in tokens_of((step,)) if not stocked.has(name)]
            if gone:
                return Flaw(index, Verdict(False, Message("nothing is left in stock for {gone}", gone=gone[0])))
        overlay, visited = supposing(stocked, self.running, self.skills, self.reached)
        return replay(overlay, self.rest, self.goal, self.skills, reached=visited)


def supposing(
    view: WorldView,
    steps: Sequence[Step],
    skills: Mapping[str, SkillDescription],
    reached: Mapping[str, int] | None = None,
) -> tuple[Overlay, Mapping[str, int]]:
    """Returns the world as it will be once some running steps have succeeded.

    Args:
        view: The world now.
        steps: The running steps.
        skills: The available skills by name.
        reached: The highest sequence number that each robot has visited in this task; the updated mapping is returned.
    """
    overlay, round_ = Overlay(view), Round(view, (), reached)
    for step in steps:
        skill = skills[step.skill]
        values = with_defaults(skill, step.arguments)
        round_.take(overlay, skill, values)
        apply_effects(overlay, skill.post, values)
    return overlay, round_.reached
