"""A bench: a world on a fake cell with skill managers and a task manager, without scene file or plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

from skiros_py.execution.monitor import ModuleEvent
from skiros_py.execution.running import RunningModule
from skiros_py.execution.runtime import Runtime, RuntimeOptions
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Planner, Planners
from skiros_py.planning.process import ThreadHost
from skiros_py.planning.requests import PlanningHost
from skiros_py.planning.service import Planned
from skiros_py.ports.adapters import NO_PORTS, Ports
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.signals import SignalProvider
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition, ConditionType
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.tasks.goals import parse_goal
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.testing.tiny import CONDITIONS, SKILLS
from skiros_py.world.vocabulary import ROBOT
from skiros_py.world.world import World

Cell = Callable[[CellSpec], CellDriver]
"""Brings up a cell."""


class Bench:
    """Runs skills and goals on a fake robot as fast as possible, without sleeping. Use it in a ``with``.

    Args:
        world: The world, such as :func:`skiros_py.testing.tiny_world`.
        skills: Implementations for the fake driver; those of the tiny domain if omitted.
        primitives: Primitives that the skills' bodies use, also by name.
        robots: Ids of the robots that get skill managers; None for all.
        conditions: Words of goals.
        planner: One planner, or several to choose from; Fast Downward if omitted.
        planning: The planning host; threads with the planner if omitted.
        policy: How tasks proceed when steps fail.
        cell: Brings up the cell; the fake one if omitted.
        driver: Kind of cell driver whose implementations of skills are used.
        ports: Adapters, for primitives that use them; see :class:`skiros_py.ports.adapters.GivenPorts`.
        config: Values of configuration parameters by "module.key".
        overrun: Wall time for which one module may block the control cycle [s]; None for the watchdog's own limit.
        signals: Creates signal providers of the cell.

    Attributes:
        runtime: The runtime.
        events: Every module event so far.
        plans: Every plan so far.
        questions: The questions to a person; see :func:`skiros_py.testing.answers`.
        managers: The skill managers by the id of their subsystem.
        cycle: The control cycle.
        signals: The signals of the current cycle.
        watchdog: Interrupts code that blocks it.
    """

    def __init__(
        self,
        world: World,
        skills: Sequence[Skill] = SKILLS,
        primitives: Sequence[type[Primitive[Any]]] | Mapping[str, type[Primitive[Any]]] = (),
        *,
        robots: Sequence[str] | None = None,
        conditions: Mapping[str, ConditionType] = CONDITIONS,
        planner: Planner | Planners | None = None,
        planning: PlanningHost | None = None,
        policy: Policy = Policy(),  # noqa: B008 - immutable
        cell: Cell = FakeCell,
        driver: str = "fake",
        ports: Ports = NO_PORTS,
        config: Mapping[str, Any] | None = None,
        overrun: float | None = None,
        signals: Callable[[CellSpec], Sequence[SignalProvider]] | None = None,
    ) -> None:
        self.world = world
        self.events: list[ModuleEvent] = []
        self.plans: list[Planned] = []
        self._conditions = conditions
        spec = read_cell(world, world.instances(ROBOT) if robots is None else robots, simulated=False)
        self.cell = cell(spec)
        named = dict(primitives) if isinstance(primitives, Mapping) else {one.name: one for one in primitives}
        named = {**{one.name: one for skill in skills for one in skill.primitives}, **named}
        options = RuntimeOptions(
            driver,
            ports=ports,
            config=config or {},
            signals=signals(spec) if signals is not None else (),
            overrun=overrun,
        )
        self.runtime = runtime = Runtime(world, spec, self.cell, skills, named, options)
        self.cycle, self.managers, self.watchdog = runtime.cycle, runtime.managers, runtime.watchdog
        self.signals = runtime.signals
        self.context, self.questions, self.monitor = runtime.context, runtime.questions, runtime.monitor
        self.monitor.subscribe(self.events.append)
        self._planner = planner or FastDownward()
        self._planning = planning or ThreadHost(world, self._planner)
        self.tasks = TaskManager(runtime, self._planning, "bench", on_plan=self.plans.append, policy=policy)

    # ------------------------------------------------------------------ goals

    def goal(self, *texts: str) -> tuple[Condition, ...]:
        """Parses goal texts."""
        return parse_goal(texts, self.world, self._conditions)

    def plan(self, *texts: str) -> Planned:
        """Plans for a goal without executing the plan."""
        return self._planning.ask(self.tasks.plan_request(self.goal(*texts))).result().value

    def pursue(self, *texts: str) -> GoalReport:
        """Pursues a goal to its end, or until everything is halted."""
        self.runtime.require_ready()
        task = self.tasks.begin(self.goal(*texts))
        self.runtime.finish(task)
        return task.result

    # ------------------------------------------------------------------ modules

    def start(self, module: str, **arguments: Any) -> RunningModule:
        """Starts a skill or primitive by the manager of a subsystem among its arguments, else the first that offers it.

        It does nothing until time advances: :meth:`advance`, :meth:`until`.

        Args:
            module: Its name.
            **arguments: Values by parameter key; omitted ones are inferred.

        Raises:
            UnknownName: No manager offers it.
        """
        named = [self.managers[v] for v in arguments.values() if isinstance(v, str) and v in self.managers]
        fitting = [manager for manager in named if module in manager.modules]
        manager = fitting[0] if fitting else self.managers.who_runs(module)
        return manager.start(module, arguments)

    def run(self, module: str, *, cancel: Callable[[], str] = lambda: "", **arguments: Any) -> Outcome:
        """Runs a skill or primitive to its end.

        Args:
            module: Its name.
            cancel: Called in every cycle; returns a reason to cancel the run, or an empty text.
            **arguments: Values by parameter key; omitted ones are inferred.
        """
        running = self.start(module, **arguments)
        while not running.done:
            reason = cancel()
            if reason:
                running.cancel(reason)
            self.cycle.step()
        return running.result

    # ------------------------------------------------------------------ time

    @property
    def time(self) -> float:
        """Time of the run [s]."""
        return self.cycle.board.snapshot.time

    def advance(self, seconds: float) -> None:
        """Advances the time of the run."""
        end = self.time + seconds - self.cycle.board.period / 2.0
        while self.time < end:
            self.cycle.step()

    def until(self, what: Condition | Callable[[], object], *, limit: float = 60.0) -> float:
        """Advances time until a condition holds.

        Args:
            what: A condition over elements, or a function that returns a true value.
            limit: Maximum time of the run [s].

        Returns:
            The elapsed time [s].

        Raises:
            AssertionError: It did not hold within the limit; the error contains the reasons of a condition.
        """
        start = self.time
        while not (what.evaluate(self.world) if isinstance(what, Condition) else what()):
            if self.time - start >= limit:
                raise AssertionError(f"after {limit:g} s: {_why_not(what, self.world)}")
            self.cycle.step()
        return self.time - start

    # ------------------------------------------------------------------ end

    def close(self) -> None:
        """Ends the planner, the watchdog and the cell; may be called twice."""
        self.watchdog.close()
        self._planner.close()
        self._planning.close()
        self.cell.close()

    def __enter__(self) -> Self:
        self.watchdog.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _why_not(what: Condition | Callable[[], object], world: World) -> str:
    if isinstance(what, Condition):
        return "\n".join(what.evaluate(world).lines())
    return f"{getattr(what, '__name__', what)} is still not so"
