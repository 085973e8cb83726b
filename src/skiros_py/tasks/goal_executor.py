"""Executes a goal: plans, dispatches, repairs and replans until it holds or is unreachable (paper §3.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TypeVar

from skiros_py.errors import SkirosError
from skiros_py.execution.pulse import words
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.problem.stock import believed
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import Mode, StopWanted, TaskContext
from skiros_py.tasks.dispatcher import Dispatcher
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.history import History
from skiros_py.tasks.person import Choice, ask_for_help, believe_done
from skiros_py.tasks.plan_monitor import PlanMonitor
from skiros_py.tasks.replanner import Replanner
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.report_builder import ReportBuilder
from skiros_py.tasks.trace import TraceEventKind

T = TypeVar("T")


class GoalExecutor:
    """Pursues the goal of one task.

    Args:
        task: The task.
        context: The task's environment: world, managers, planning.

    Attributes:
        history: Every step that was run.
    """

    def __init__(self, task: TaskHandle, context: TaskContext) -> None:
        self.history = History(context.world, task.policy.attempts)
        self._task = task
        self._context = context
        self._skills: dict[str, SkillDescription] = {}
        self._dispatcher = Dispatcher(task, context, self.history, self._skills)
        self._monitor = PlanMonitor(context, self._dispatcher, self.history, self._skills, task.control)
        self._replanner = Replanner(context, self.history, task.name, task.control)
        self._report = ReportBuilder(task, context, self.history)
        self._rounds = 0

    def execute(self) -> Execution[GoalReport]:
        """Pursues the goal to its end; the task always gets a report.

        Raises:
            PlanningError: The planner failed before any step was run.
        """
        task = self._task
        self._tell(TraceEventKind.BEGUN, f"{task.name}: {' and '.join(map(str, task.goal))}")
        try:
            yield from self._until_it_ends()
            task.report = self._report.report()
        except Exception as error:
            fault = str(error) if isinstance(error, SkirosError) else f"it broke: {words(error)}"
            with suppress(Exception):  # ignore further errors: the first one counts
                yield from self._dispatcher.halt(fault)
            task.report = self._report.report(fault=fault)
            raise
        finally:
            self._dispatcher.leave()
            self._monitor.close()
            if task.report is None:  # the system was halted, or user code blocked the control cycle
                task.report = self._report.report_cut_off()
            self._tell(TraceEventKind.FINISHED, f"{task.name}: {task.report.outcome}")
        return task.report

    def _until_it_ends(self) -> Execution[None]:
        try:
            yield from self._pursue()
        except StopWanted as wish:
            self._report.stopped = True
            self._tell(TraceEventKind.STOPPED, f"is stopped{f': {wish}' if str(wish) else ''}")
            yield from self._dispatcher.halt(str(wish) or "stopped")

    # ------------------------------------------------------------------ rounds

    def _pursue(self) -> Execution[None]:
        self._allow_rounds()
        while self._rounds:
            self._rounds -= 1
            kept = self._report.kept
            if self._all_hold(kept) or (self._report.given_up and not self._task.policy.rest):
                break
            if (yield from self._meanwhile(self._monitor.is_right_for(kept))):
                self._tell(TraceEventKind.RETRIED, f"{self._monitor.trouble}: it is tried again")
            else:
                planned = yield from self._plan(kept)
                if isinstance(planned.outcome, NoPlan):
                    if (yield from self._no_way(kept, planned, planned.outcome)):
                        break
                    continue
                self._adopt(planned, planned.outcome, kept)
            yield from self._carry_out()
            yield from self._give_up(self._hopeless(kept))
        yield from self._wind_up()

    def _allow_rounds(self) -> None:
        """Resets the bound on planning and execution rounds."""
        self._rounds = self._task.policy.attempts * (len(self._task.goal) + 2)

    def _all_hold(self, goal: Sequence[Condition]) -> bool:
        return all(believed(c, self._context.world) for c in goal)

    def _carry_out(self) -> Execution[None]:
        """Runs the plan until it is done or no longer matches the world."""
        self._task.phase = "running"
        while True:
            self._look_after()
            failed = self._dispatcher.attend()
            if failed:
                step, failure = failed[-1]
                self._monitor.trouble = f"{step.skill} failed: {failure.reason}"
                return
            if self._dispatcher.agenda.done or self._monitor.is_misled():
                return
            if self._monitor.is_sure and self._dispatcher.start_ready():
                yield  # a step refused now may be possible in the next cycle
                return
            yield

    def _look_after(self) -> None:
        """Handles a stop request and records conditions that now hold.

        Raises:
            StopWanted: The task was asked to stop.
        """
        self._report.note()
        wish = self._task.control.stop
        if wish is not None and not (self._dispatcher.agenda.done and self._all_hold(self._task.goal)):
            raise StopWanted(wish)

    def _wind_up(self) -> Execution[None]:
        """Ends the steps that still run although the task is done."""
        for one in self._dispatcher.active:
            self._dispatcher.break_off(one, "nothing more is to be done")
        yield from self._let_end()

    def _let_end(self) -> Execution[None]:
        while self._dispatcher.active:
            self._look_after()
            self._dispatcher.attend()
            if self._dispatcher.active:
                yield

    def _meanwhile(self, work: Execution[T]) -> Execution[T]:
        """Runs a longer operation while attending to the running steps."""
        try:
            while True:
                self._look_after()
                try:
                    next(work)
                except StopIteration as end:
                    result: T = end.value
                    return result
                self._dispatcher.attend()
                yield
        finally:
            work.close()

    # ------------------------------------------------------------------ planning

    def _plan(self, kept: tuple[Condition, ...]) -> Execution[Planned]:
        """Plans for the remaining goal while unaffected steps keep running."""
        self._task.phase = "planning"
        if self._monitor.began:
            why = self._monitor.trouble or "the goal does not hold yet"
            self._tell(TraceEventKind.REPLANS, f"plans anew: {why}")
        self._skills |= {c.skill.name: c.skill for c in self._context.capabilities}  # managers come and go
        planning = self._replanner.plan(kept, self._monitor.undoubted)
        planned = yield from self._meanwhile(planning)
        while self._task.control.mode is Mode.PAUSE:
            self._look_after()
            self._dispatcher.attend()
            yield
        return planned

    def _adopt(self, planned: Planned, plan: Plan, kept: tuple[Condition, ...]) -> None:
        self._context.on_plan(planned)
        self._monitor.adopt(plan, kept)
        self._task.plan = plan
        said = ", then ".join(self._dispatcher.trace.describe(step) for step in plan.steps) or "nothing is to be done"
        self._tell(TraceEventKind.PLANNED, f"plan: {said}", plan.as_json())

    # ------------------------------------------------------------------ what cannot be reached

    def _no_way(self, kept: tuple[Condition, ...], planned: Planned, answer: NoPlan) -> Execution[bool]:
        """Handles a missing plan; returns True if the whole task is over."""
        if not self.history.steps:
            self._report.no_plan = answer.reasons
            self._context.on_plan(planned)
        self._tell(TraceEventKind.NO_PLAN, f"no plan: {'; '.join(answer.reasons)}", answer.as_json())
        self._monitor.break_off()
        if self._dispatcher.active:  # once the running steps have ended, the world model is more reliable
            yield from self._let_end()
            return False
        policy = self._task.policy
        if not (self.history.steps or policy.partial or policy.ask):
            return True
        dropped = yield from self._unreachable(kept, answer)
        yield from self._give_up(dropped)
        return False

    def _hopeless(self, goal: Sequence[Condition]) -> dict[Condition, str]:
        """Returns unmet conditions that name an excluded target, with the reason."""
        out, attempts = self.history.left_out, self._task.policy.attempts
        concerned = (c for c in goal if out.intersection(c.arguments))
        return {c: f"gave up after {attempts} tries" for c in concerned if not believed(c, self._context.world)}

    def _unreachable(self, goal: Sequence[Condition], answer: NoPlan) -> Execution[dict[Condition, str]]:
        """Finds a subset of the goal that is reachable together and returns the rest with reasons."""
        kept: list[Condition] = []
        dropped: dict[Condition, str] = {}
        for condition in goal if len(goal) > 1 else ():
            planned = yield from self._meanwhile(self._replanner.plan((*kept, condition)))
            if isinstance(planned.outcome, Plan):
                kept.append(condition)
            else:
                dropped[condition] = "; ".join(planned.outcome.reasons)
        if not dropped:  # a single condition; or each was reachable in turn, so the planner is wrong
            dropped = {condition: "; ".join(answer.reasons) for condition in goal}
        return dropped

    def _give_up(self, dropped: Mapping[Condition, str]) -> Execution[None]:
        """Gives up conditions, unless the user decides otherwise."""
        for condition, reason in dropped.items():
            why = self.history.why_missing(condition, {condition: reason})
            if not self._task.policy.ask:
                self._drop(condition, reason, why)
            elif (by := (yield from self._help(condition, why))) is not None:
                self._drop(condition, f"skipped by {by}: {reason}", f"{by} skips it: {why}")

    def _drop(self, condition: Condition, reason: str, text: str) -> None:
        self._report.given_up[condition] = reason
        self._tell(TraceEventKind.GIVEN_UP, f"{condition} is given up: {text}", {"condition": str(condition)})

    def _help(self, condition: Condition, why: str) -> Execution[str | None]:
        """Asks the user about one condition; returns who chose to skip it, or None if it is no longer at issue.

        Raises:
            StopWanted: The user chose to end the whole task.
        """
        said = f"{condition} cannot be reached: "  # a planning reason may start with the same text
        text = said + why.removeprefix(said)
        while True:
            self._tell(TraceEventKind.ASKED, text)
            with self._dispatcher.lending():
                choice, by = yield from self._meanwhile(ask_for_help(self._task, self._context, text))
            self._tell(TraceEventKind.ANSWERED, f"{by} answers: {choice}", {"choice": choice.value, "by": by})
            self._allow_rounds()
            match choice:
                case Choice.RETRY:
                    self.history.forgive()
                    return None
                case Choice.SKIP:
                    return by
                case Choice.ABORT:
                    raise StopWanted(f"aborted by {by}")
            refusal = believe_done(self._context, condition, by)
            if refusal is None:
                return None
            text = refusal.reason

    def _tell(self, what: TraceEventKind, text: str, data: Mapping[str, object] | None = None) -> None:
        self._dispatcher.trace.write(what, text, data)
