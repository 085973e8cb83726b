"""The task manager: goal → plan → done, or the rest of the goal done and why something is missing (paper §3.4)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from typing import Self

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.execution.contained import words
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.skill_manager import Transport
from skiros_py.execution.station import Station
from skiros_py.interruptions import Interruption
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planner import Planner
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.planning.task import Capability
from skiros_py.skills.conditions import Condition, judge
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.dispatcher import Dispatcher
from skiros_py.tasks.history import History
from skiros_py.tasks.report import ConditionReport, GoalReport, StepReport
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_SKILL
from skiros_py.world.without import Without
from skiros_py.world.world import World

__all__ = ["TaskManager"]

_PLANNING_LIMIT = 30.0
"""How long what is worked out around the planner may hold the control cycle: a large world takes seconds [s]."""


class TaskManager:
    """Pursues goals with the skill managers that are there.

    Args:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: Plans.
        cycle: Runs everything.
        on_plan: Told of every new plan.
        attempts: How often a skill may fail on one target before that target is left out of further plans.
        monitor: Hears of steps that have to wait; None where nobody listens.
    """

    def __init__(
        self,
        world: World,
        managers: Mapping[str, Transport],
        planning: PlanningService,
        cycle: ControlCycle,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        attempts: int = 3,
        monitor: Monitor | None = None,
    ) -> None:
        self._world = world
        self._managers = managers
        self._planning = planning
        self._cycle = cycle
        self._on_plan = on_plan
        self._attempts = attempts
        self._monitor = monitor
        self._history = History(world, attempts)

    @classmethod
    def of(
        cls,
        station: Station,
        planner: Planner,
        name: str,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        attempts: int = 3,
    ) -> Self:
        """Makes the task manager of a station.

        Args:
            station: Runs everything.
            planner: Plans; whoever made it closes it.
            name: Name of what is planned for, for the planner's files.
            on_plan: Told of every new plan.
            attempts: How often a skill may fail on one target before that target is left out of further plans.
        """
        cycle = station.cycle
        planning = PlanningService(planner, name, lockstep=cycle.pace is None, waiting=cycle.pulse.waiting)
        return cls(
            station.world,
            station.managers,
            planning,
            cycle,
            on_plan=on_plan,
            attempts=attempts,
            monitor=station.monitor,
        )

    @property
    def steps(self) -> tuple[StepReport, ...]:
        """Every skill that was run for the present or last goal, in order."""
        return tuple(self._history.steps)

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills that the world model says are there, with who has them."""
        found: dict[str, tuple[SkillDescription, list[str], list[Sequence[Condition]]]] = {}
        for agent, manager in sorted(self._managers.items()):
            registered = {self._world.element(s).label for s in self._world.objects(agent, HAS_SKILL)}
            for name, description in manager.descriptions.items():
                if name in registered:
                    _, agents, ways = found.setdefault(name, (description, [], []))
                    agents.append(agent)
                    ways += manager.alternatives[name]
        return tuple(Capability(d.under(ways), tuple(agents)) for _, (d, agents, ways) in sorted(found.items()))

    def plan(self, goal: Sequence[Condition]) -> Execution[Planned]:
        """Plans from what is believed now, leaving out targets on which skills failed too often.

        A planner that breaks while a goal is under way is an answer too: what was done so far has to be reported.

        Raises:
            PlanningError: The planner broke before anything was done.
        """
        try:
            return (yield from self._unhurried(self._planning.plan(self._view(), self.capabilities, goal)))
        except PlanningError as error:
            if not self._history.steps:
                raise
            return Planned(NoPlan((str(error),)), None, 0.0)

    def _unhurried(self, planning: Execution[Planned]) -> Execution[Planned]:
        """Passes planning through, whose ticks may take long; what authors' conditions raise in it is a fault of it.

        Raises:
            PlanningError: It broke.
        """
        with closing(planning):
            while True:
                with self._cycle.pulse.allowing(_PLANNING_LIMIT):
                    try:
                        next(planning)
                    except StopIteration as end:
                        result: Planned = end.value
                        return result
                    except (SkirosError, KeyboardInterrupt, Interruption):
                        raise
                    except BaseException as error:
                        raise PlanningError(f"planning broke: {words(error)}") from error
                yield

    def pursue(self, goal: Sequence[Condition]) -> Execution[GoalReport]:
        """Pursues a goal to its end.

        What fails is tried again or planned anew a bounded number of times; what can no longer be reached is given up,
        and the rest of the goal is still done.
        """
        history = self._history = History(self._world, self._attempts)  # what failed before may work now
        skills: dict[str, SkillDescription] = {}
        dispatcher = Dispatcher(self._world, self._managers, skills, self._cycle, history, self._monitor)
        noted = _Moments(self._world, goal, self._cycle)
        held = {c for c in goal if judge(c, self._world)}
        given_up: dict[Condition, str] = {}
        no_plan: tuple[str, ...] = ()
        for _ in range(self._attempts * (len(goal) + 2)):
            kept = tuple(c for c in goal if c not in given_up)
            if all(judge(c, self._world) for c in kept):
                break
            skills |= {c.skill.name: c.skill for c in self.capabilities}  # managers come and go
            planned = yield from self.plan(kept)
            if isinstance(planned.outcome, Plan):
                self._on_plan(planned)
                yield from noted.during(dispatcher.run(planned.outcome, kept))
                given_up |= self._hopeless(kept)
            elif not history.steps:
                no_plan = planned.outcome.reasons
                self._on_plan(planned)
                break
            else:
                given_up |= yield from self._unreachable(kept, planned.outcome)
        reports = tuple(self._report(c, given_up, noted, held=c in held) for c in goal)
        return GoalReport(reports, tuple(history.steps), *noted.used, no_plan)

    def _view(self) -> WorldView:
        return Without(self._world, self._history.left_out) if self._history.left_out else self._world

    def _hopeless(self, goal: Sequence[Condition]) -> dict[Condition, str]:
        """Returns conditions that name a target left out and do not hold, with the reason."""
        out = self._history.left_out
        return {
            c: f"gave up after {self._attempts} tries"
            for c in goal
            if out.intersection(c.arguments) and not judge(c, self._world)
        }

    def _unreachable(self, goal: Sequence[Condition], answer: NoPlan) -> Execution[dict[Condition, str]]:
        """Finds a subset of the goal that can be reached together and returns the rest with reasons."""
        kept: list[Condition] = []
        dropped: dict[Condition, str] = {}
        for condition in goal:
            planned = yield from self.plan((*kept, condition))
            if isinstance(planned.outcome, Plan):
                kept.append(condition)
            else:
                dropped[condition] = "; ".join(planned.outcome.reasons)
        if not dropped:  # each was reachable in turn, so the whole is: only a planner that errs gets here
            dropped = {condition: "; ".join(answer.reasons) for condition in goal}
        return dropped

    def _report(
        self, c: Condition, given_up: Mapping[Condition, str], noted: _Moments, *, held: bool
    ) -> ConditionReport:
        holds = bool(judge(c, self._world))
        tries = 0 if held else self._history.tries(c, holds=holds)
        reason = "" if holds else self._history.why_missing(c, given_up)
        return ConditionReport(str(c), holds, None, tries, reason, *noted.since(c))


class _Moments:
    """Notes when each condition of a goal came to be believed."""

    def __init__(self, world: World, goal: Sequence[Condition], cycle: ControlCycle) -> None:
        self._world = world
        self._goal = goal
        self._cycle = cycle
        self._start = cycle.board.snapshot.time, time.perf_counter()
        self._since: dict[Condition, tuple[float, float]] = {}
        self._version = -1
        self._note()

    @property
    def used(self) -> tuple[float, float]:
        """Simulated and wall time since the start [s]."""
        return self._cycle.board.snapshot.time - self._start[0], time.perf_counter() - self._start[1]

    def since(self, condition: Condition) -> tuple[float | None, float | None]:
        """Returns simulated and wall time at which a condition that is believed came to be so [s]."""
        self._note()
        return self._since.get(condition, (None, None))

    def during(self, work: Execution[None]) -> Execution[None]:
        """Passes work through, looking at the world whenever it has changed."""
        with closing(work):
            for _ in work:
                self._note()
                yield

    def _note(self) -> None:
        if self._version == self._world.version:
            return
        self._version = self._world.version
        for condition in self._goal:
            if not judge(condition, self._world):
                self._since.pop(condition, None)
            elif condition not in self._since:
                self._since[condition] = self.used
