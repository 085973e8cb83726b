"""Executes a goal: plans, dispatches, repairs and replans until it holds or is unreachable (paper §3.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from skiros_py.errors import UsageError
from skiros_py.messages import Message, joined
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.problem.stock import believed
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.tasks.context import Mode, StopWanted, TaskContext
from skiros_py.tasks.dispatcher import Active
from skiros_py.tasks.executor import TaskExecutor
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.help_from_people import Choice, ask_for_help, believe_back, believe_done
from skiros_py.tasks.plan_monitor import PlanMonitor
from skiros_py.tasks.replanner import Replanner
from skiros_py.tasks.trace import TraceEventKind, describe_step


class GoalExecutor(TaskExecutor):
    """Pursues the goal of one task.

    Args:
        task: The task.
        context: The task's environment: world, managers, planning.
    """

    def __init__(self, task: TaskHandle, context: TaskContext) -> None:
        super().__init__(task, context)
        self._replanner = Replanner(context, self.record, task)
        self._monitor: PlanMonitor | None = None
        self._trouble = ""
        self._doubtful: tuple[Active, ...] = ()
        self._rounds = self._most_rounds = task.policy.attempts * (len(task.goal) + 2)

    def _title(self) -> str:
        return " and ".join(map(str, self._task.goal))

    def _leave(self) -> None:
        super()._leave()
        if self._monitor is not None:
            self._monitor.close()

    # ------------------------------------------------------------------ rounds

    def _work(self) -> Execution[None]:
        if self._task.policy.rehearse and not self._all_hold(self._task.goal):
            why = yield from self._meanwhile(self._rehearse())
            if why:
                self.record.no_plan = (why,)
                return
        while True:
            kept = tuple(c for c in self._task.goal if c not in self.record.given_up)
            if self._all_hold(kept) or (self.record.given_up and not self._task.policy.rest):
                break
            if not self._rounds:
                yield from self._give_up(self._not_reached(kept))
                continue
            self._rounds -= 1
            if (yield from self._is_right_for(kept)):
                self._trace.write(
                    TraceEventKind.RETRIED, Message("{trouble}: it is tried again", trouble=self._trouble)
                )
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

    def _all_hold(self, goal: Sequence[Condition]) -> bool:
        return all(believed(c, self._context.world) for c in goal)

    def _carry_out(self) -> Execution[None]:
        """Runs the plan until it is done or no longer matches the world."""
        assert self._monitor is not None, "there is a plan"
        self._task.phase = "running"
        while True:
            self._look_after()
            progress = self._attend()
            if progress.failed:
                step, failure = progress.failed[-1]
                self._trouble = Message("{step} failed: {reason}", step=step.skill, reason=failure.reason)
                return
            if progress.done:
                return
            flaw = self._monitor.check(progress, self.record.reached)
            if flaw is not None:
                self._trouble = flaw.verdict.why
                self._doubtful = self._dispatcher.leading_to(flaw.step)
                return
            if self._monitor.is_valid and self._noted(self._dispatcher.start_ready()).failed:
                yield  # a step refused now may be possible in the next cycle
                return
            yield

    def _look_after(self) -> None:
        """Handles a stop request; one that comes when the goal is reached has no effect."""
        if self._task.control.stop is not None and not (self._progress.done and self._all_hold(self._task.goal)):
            super()._look_after()

    def _wind_up(self) -> Execution[None]:
        """Ends the steps that still run although the task is done."""
        if self._progress.running:
            self._dispatcher.cancel(self._progress.running, Message("nothing more is to be done"))
            yield from self._let_end()

    def _let_end(self) -> Execution[None]:
        while self._progress.running:
            self._look_after()
            if self._attend().running:
                yield

    def _rehearse(self) -> Execution[str]:
        """Rehearses the goal, and avoids what that has ruled out; returns why nothing is to be done, or an empty text.

        Raises:
            UsageError: There is nothing to rehearse in.
        """
        if self._context.rehearser is None:
            raise UsageError(Message("a rehearsal needs physics: there is none for this cell"))
        self._trace.write(TraceEventKind.REHEARSES, Message("rehearses"))
        started = self._context.rehearser(self._task.goal)
        self._task.rehearsal = rehearsal = yield from self._context.wait_for(started, self._task.control)
        self.record.avoid(rehearsal.ruled_out)
        reason = rehearsal.reason
        text = Message("would fail: {reason}", reason=reason) if reason else Message("rehearsed: the goal is reached")
        self._trace.write(TraceEventKind.REHEARSED, text, rehearsal.as_json())
        return text if reason and not self._task.policy.partial else ""

    # ------------------------------------------------------------------ planning

    def _is_right_for(self, goal: tuple[Condition, ...]) -> Execution[bool]:
        """Returns True if the plan, with failed steps repeated, still leads to a goal."""
        monitor, progress = self._monitor, self._progress
        if monitor is None or goal != monitor.goal or progress.done or self._doubtful:
            return False
        targets = {step.arguments[self._skills[step.skill].target] for step in progress.rest}
        if targets & self.record.left_out.keys():
            return False
        if any(self.record.is_ruled_out(step, self._skills[step.skill]) for step in progress.rest):
            return False
        return (yield from self._meanwhile(monitor.recheck(progress, self.record.reached)))

    def _plan(self, kept: tuple[Condition, ...]) -> Execution[Planned]:
        """Plans for the remaining goal while unaffected steps keep running."""
        self._task.phase = "planning"
        if self._monitor is not None:
            why = self._trouble or Message("the goal does not hold yet")
            self._trace.write(TraceEventKind.REPLANS, Message("replans: {why}", why=why))
        self._skills = {**self._skills, **{c.skill.name: c.skill for c in self._context.capabilities}}
        lasting = [one.step for one in self._progress.running if one not in self._doubtful and not one.leaving]
        planned = yield from self._meanwhile(self._replanner.plan(kept, lasting))
        while self._task.control.mode is Mode.PAUSE:
            self._look_after()
            self._attend()
            yield
        return planned

    def _adopt(self, planned: Planned, plan: Plan, kept: tuple[Condition, ...]) -> None:
        self._context.on_plan(planned)
        self._noted(self._dispatcher.adopt(plan, self._skills, self._doubtful, self._why_cancelled))
        self._doubtful = ()
        if self._monitor is not None:
            self._monitor.close()
        self._monitor = PlanMonitor(self._context, self._task.control, kept, self._skills)
        self._task.plan = plan
        said = "; ".join(describe_step(step, self._skills[step.skill]) for step in plan.steps)
        text = Message("plan: {steps}", steps=said or Message("nothing is to be done"))
        self._trace.write(TraceEventKind.PLANNED, text, plan.as_json())

    @property
    def _why_cancelled(self) -> str:
        return Message("the plan no longer leads to the goal: {trouble}", trouble=self._trouble)

    # ------------------------------------------------------------------ what cannot be reached

    def _no_way(self, kept: tuple[Condition, ...], planned: Planned, answer: NoPlan) -> Execution[bool]:
        """Handles a missing plan; returns True if the whole task is over."""
        if not self.record.steps:
            self.record.no_plan = answer.reasons
            self._context.on_plan(planned)
        text = Message("no plan: {reasons}", reasons=joined("; ", answer.reasons))
        self._trace.write(TraceEventKind.NO_PLAN, text, answer.as_json())
        self._dispatcher.cancel(self._doubtful, self._why_cancelled)
        self._doubtful = ()
        if self._progress.running:  # once the running steps have ended, the world model is more reliable
            yield from self._let_end()
            return False
        policy = self._task.policy
        if not (self.record.steps or policy.partial or policy.ask):
            return True
        dropped = yield from self._unreachable(kept, answer)
        yield from self._give_up(dropped)
        return False

    def _hopeless(self, goal: Sequence[Condition]) -> dict[Condition, str]:
        """Returns unmet conditions that name an excluded target or were tried too often, with the reason."""
        out, attempts = self.record.left_out, self._task.policy.attempts
        concerned = (c for c in goal if out.keys() & set(c.arguments) or c in self.record.worn_out)
        reason = Message("gave up after {count} tries", count=attempts)
        return {c: reason for c in concerned if not believed(c, self._context.world)}

    def _not_reached(self, goal: Sequence[Condition]) -> dict[Condition, str]:
        """Returns the unmet conditions when no round is left, with the reason."""
        reason = Message("gave up after {count} plans and retries", count=self._most_rounds)
        if self._trouble:
            reason = joined(": ", (reason, self._trouble))
        return {c: reason for c in goal if not believed(c, self._context.world)}

    def _unreachable(self, goal: Sequence[Condition], answer: NoPlan) -> Execution[dict[Condition, str]]:
        """Finds a subset of the goal that is reachable together and returns the rest with reasons."""
        kept: list[Condition] = []
        dropped: dict[Condition, str] = {}
        for condition in goal if len(goal) > 1 else ():
            planned = yield from self._meanwhile(self._replanner.plan((*kept, condition)))
            if isinstance(planned.outcome, Plan):
                kept.append(condition)
            else:
                dropped[condition] = joined("; ", planned.outcome.reasons)
        if not dropped:  # a single condition; or each was reachable in turn, so the planner is wrong
            dropped = {condition: joined("; ", answer.reasons) for condition in goal}
        return dropped

    def _give_up(self, dropped: Mapping[Condition, str]) -> Execution[None]:
        """Gives up conditions, unless the user decides otherwise."""
        for condition, reason in dropped.items():
            why = self.record.why_missing(condition, {condition: reason})
            if not self._task.policy.ask:
                self._drop(condition, reason, why)
            elif (by := (yield from self._help(condition, why))) is not None:
                skipped = Message("skipped by {by}: {reason}", by=by, reason=reason)
                self._drop(condition, skipped, Message("{by} skips it: {why}", by=by, why=why))

    def _drop(self, condition: Condition, reason: str, text: str) -> None:
        self.record.given_up[condition] = reason
        text = Message("{condition} is given up: {text}", condition=condition, text=text)
        self._trace.write(TraceEventKind.GIVEN_UP, text, {"condition": str(condition)})

    def _help(self, condition: Condition, why: str) -> Execution[str | None]:
        """Asks the user about one condition; returns who chose to skip it, or None if it is no longer at issue.

        Raises:
            StopWanted: The user chose to end the whole task.
        """
        text = why
        if not why.startswith(f"{condition} cannot be reached: "):  # as a planning reason may do
            text = Message("{conditions} cannot be reached: {why}", conditions=condition, why=why)
        while True:
            self._trace.write(TraceEventKind.ASKED, text)
            choice, by = yield from self._answer(condition, text)
            said = Message("{by} answers: {choice}", by=by, choice=choice)
            self._trace.write(TraceEventKind.ANSWERED, said, {"choice": choice.value, "by": by})
            self._rounds = self._most_rounds
            match choice:
                case Choice.RETRY:
                    refusal = None
                case Choice.LOOK:
                    refusal = believe_back(self._context, condition, by)
                case Choice.BY_HAND:
                    refusal = believe_done(self._context, condition, by)
                case Choice.SKIP:
                    return by
                case Choice.ABORT:
                    raise StopWanted(Message("aborted by {by}", by=by))
            if refusal is None:
                self.record.forgive(condition)
                return None
            text = refusal.reason

    def _answer(self, condition: Condition, text: str) -> Execution[tuple[Choice, str]]:
        """Waits for the user, which may take long: idle robots and things are released to other tasks."""
        self._dispatcher.lends = True
        try:
            return (yield from self._meanwhile(ask_for_help(self._task, self._context, condition, text)))
        finally:
            self._dispatcher.lends = False
