"""Dispatches the steps of a plan to the skill managers; independent steps run concurrently."""

from __future__ import annotations

from collections.abc import Collection, Mapping, MutableMapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace

from skiros_py.errors import DiskFault, UsageError, WorldError
from skiros_py.execution.running import RunningModule
from skiros_py.messages import Message
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.problem.stock import tokens_of
from skiros_py.skills.context import Tried
from skiros_py.skills.outcome import CANCELLED, Failure, Outcome
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.tasks.context import Mode, TaskContext
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.record import purpose
from skiros_py.tasks.reservations import in_hands, used_by
from skiros_py.tasks.trace import StepEnd, StepRun, TraceEventKind, describe_step, step_id
from skiros_py.world.stock import take
from skiros_py.world.terms import reached


@dataclass(slots=True, eq=False)
class Active:
    """A running step.

    Attributes:
        run: The step, its number and the agent that runs it.
        robot: Id of that agent's robot.
        running: Handle of the running skill.
        leaving: Why it was cancelled; empty if it was not.
    """

    run: StepRun
    robot: str
    running: RunningModule
    leaving: str = ""

    @property
    def step(self) -> Step:
        """The skill with its arguments."""
        return self.run.step


class Agenda:
    """The steps of one plan and their progress. Steps are identified by index.

    Args:
        steps: The steps, in a feasible order.
        after: For each step the indices of the steps that must have ended before it starts.

    Attributes:
        steps: The steps, in this order.
        running: The running steps. One that is removed from here is waiting again, unless it is ended.
    """

    def __init__(self, steps: Sequence[Step], after: Sequence[Collection[int]]) -> None:
        self.steps = list(steps)
        self.running: dict[int, Active] = {}
        self._after = [set(before) for before in after]
        self._ended: set[int] = set()

    @property
    def waiting(self) -> tuple[int, ...]:
        """The steps that have not started, in order."""
        return tuple(i for i in range(len(self.steps)) if i not in self._ended and i not in self.running)

    @property
    def done(self) -> bool:
        """True when every step has ended."""
        return len(self._ended) == len(self.steps)

    @property
    def ready(self) -> tuple[int, ...]:
        """The steps that no unfinished step precedes, in order."""
        return tuple(index for index in self.waiting if self._after[index] <= self._ended)

    def end(self, index: int) -> None:
        """Marks a running step as successfully ended."""
        del self.running[index]
        self._ended.add(index)

    def rename(self, names: Mapping[str, str]) -> None:
        """Renames elements in the steps' arguments."""
        self.steps = [step.renamed(names) for step in self.steps]

    def leads_to(self, earlier: int, later: int) -> bool:
        """Returns True if the later step has to wait for the earlier one, directly or transitively."""
        return earlier in reached(self._after[later], lambda index: self._after[index])

    def with_running(self, running: Sequence[Active], shared: Collection[tuple[int, int]]) -> Agenda:
        """Returns the agenda, of which no step has ended, preceded by steps of another plan that are already running.

        Args:
            running: These steps; they get the first indices.
            shared: Pairs of a running step and the step of this agenda, by its index here, that has to wait for it.
        """
        more = len(running)
        after = [{one + more for one in before} for before in self._after]
        for earlier, later in shared:
            after[later].add(earlier)
        joined = Agenda((*(one.step for one in running), *self.steps), (*(set[int]() for _ in running), *after))
        both = [*enumerate(running), *((index + more, one) for index, one in self.running.items())]
        joined.running = dict(sorted(both, key=lambda pair: pair[1].run.number))
        return joined


@dataclass(frozen=True, slots=True)
class Progress:
    """The steps of a plan, at one moment.

    Attributes:
        running: The running steps.
        rest: The steps that have not started, in order.
        done: True when every step has ended.
        is_idle: True if nothing can happen now: paused, or waiting for other tasks with no step running.
        ended: The steps that have just ended.
        failed: The steps that have just failed or could not be started, with the reason; they are to be repeated.
    """

    running: tuple[Active, ...] = ()
    rest: tuple[Step, ...] = ()
    done: bool = True
    is_idle: bool = False
    ended: tuple[StepEnd, ...] = ()
    failed: tuple[tuple[Step, Failure], ...] = ()


class Dispatcher:
    """Runs the steps of one task's plans.

    Args:
        task: The task, with its control requests.
        context: The task's environment: world, managers, reservations.
        tried: What was tried in vain, by purpose.

    Attributes:
        lends: True while the task waits for the user: no step may start, and other tasks may use what is at rest,
            except robots that hold a thing of this task, so that it is not put down elsewhere.
    """

    def __init__(self, task: TaskHandle, context: TaskContext, tried: MutableMapping[tuple[str, ...], Tried]) -> None:
        self.lends = False
        self._tried = tried
        self._task = task
        self._context = context
        self._trace = task.trace
        self._skills: Mapping[str, SkillDescription] = {}
        self._agenda = Agenda((), ())
        self._coming: dict[int, tuple[StepRun, tuple[Future[None], ...]]] = {}  # steps whose intent is being saved
        self._used: tuple[frozenset[str], frozenset[str]] | None = None  # by all steps, and by the running ones
        self._waits: set[str] = set()
        self._ended: list[StepEnd] = []
        self._failed: list[tuple[Step, Failure]] = []
        self._started = 0
        self._mode = Mode.RUN
        self._round_began = False
        self._granted = True

    @property
    def _active(self) -> tuple[Active, ...]:
        return tuple(self._agenda.running.values())

    # ------------------------------------------------------------------ the plan

    def adopt(
        self, plan: Plan, skills: Mapping[str, SkillDescription], cancelled: Collection[Active] = (), why: str = ""
    ) -> Progress:
        """Switches to another plan; running steps of the old plan that are not in the new one finish first.

        Args:
            plan: The plan.
            skills: The skills of its steps and of the running ones, by name.
            cancelled: Running steps to cancel unless they are part of the new plan, too.
            why: The reason for that.
        """
        active, agenda = self._active, Agenda(plan.steps, plan.order)
        for one in cancelled:
            same = [index for index in agenda.ready if agenda.steps[index] == one.step]
            if same and one in active:
                agenda.running[same[0]] = one
        kept = agenda.running.values()
        self.cancel([one for one in cancelled if one not in kept], why)
        self._skills = skills
        self._forget_coming()
        before = [one for one in active if one not in kept]
        later = agenda.waiting
        shared = {(n, i) for n, one in enumerate(before) for i in later if self._meet(one, agenda.steps[i])}
        self._agenda = agenda.with_running(before, shared)
        self._waits.clear()
        self._used = None
        return self._progress()

    def leading_to(self, step: int | None) -> tuple[Active, ...]:
        """Returns the running steps that a remaining step depends on.

        Args:
            step: Its position among the remaining steps; None for no step.
        """
        if step is None:
            return ()
        later = self._agenda.waiting[step]
        return tuple(one for index, one in self._agenda.running.items() if self._agenda.leads_to(index, later))

    def cancel(self, steps: Collection[Active], reason: str) -> None:
        """Cancels steps that are no longer useful; they still run their cleanup, such as stowing the arm."""
        for one in steps:
            if not one.leaving:
                one.leaving = reason
                one.running.cancel(reason)

    # ------------------------------------------------------------------ each cycle

    def attend(self) -> Progress:
        """Applies control requests, collects ended steps, and reserves what the remaining steps use."""
        self._obey()
        self._collect()
        self._granted = self._claim()
        return self._progress()

    def start_ready(self) -> Progress:
        """Starts the steps that are ready."""
        if self._granted and self._mode is not Mode.PAUSE:
            for index in self._agenda.ready:
                if index in self._coming:
                    self._start(index)
                elif self._goes_on and self._may_start(index):
                    self._prepare(index)
            self._round_began = self._round_began or bool(self._coming)
        return self._progress()

    def stop(self, reason: str) -> None:
        """Stops all running steps; they come to rest in the next cycles."""
        self._forget_coming()
        for one in self._active:
            one.leaving = one.leaving or reason
            one.running.stop()

    def collect(self) -> Progress:
        """Collects ended steps, while everything is being stopped."""
        self._collect()
        return self._progress()

    def leave(self) -> None:
        """Stops all running steps at once and releases the reservations: those of moving devices once at rest."""
        why = self._context.cycle.halted or Message("stopped")
        for one in self._active:
            one.running.stop()
            data = {"reason": why, **one.running.account}
            self._trace.write(TraceEventKind.CANCELLED, _cancelled(self._said(one.step), why), data, one.run)
        braking = tuple(one.running for one in self._active)
        moving = {id_ for one in self._active for id_ in (one.robot, *one.step.arguments.values())}
        self._agenda.running.clear()
        stands = lambda: all(running.done for running in braking)  # noqa: E731
        self._context.reservations.release(self._task.name, moving, stands)

    def _progress(self) -> Progress:
        """Returns how the steps stand; what has just ended is returned only once."""
        agenda, running = self._agenda, self._active
        rest = tuple(agenda.steps[index] for index in agenda.waiting)
        idle = self._mode is Mode.PAUSE or not (self._granted or running)
        ended, self._ended = tuple(self._ended), []
        failed, self._failed = tuple(self._failed), []
        return Progress(running, rest, agenda.done, idle, ended, failed)

    # ------------------------------------------------------------------ control requests

    @property
    def _goes_on(self) -> bool:
        """True while control requests allow steps to start."""
        return not (self._mode is Mode.PAUSE or (self._mode is Mode.SINGLE and self._round_began))

    def _obey(self) -> None:
        wanted = self._task.control.mode
        round_is_over = self._round_began and not (self._active or self._coming)
        if wanted is Mode.SINGLE and self._mode is Mode.SINGLE and round_is_over:
            wanted = self._task.control.end_single()
        if wanted is self._mode:
            return
        before, self._mode = self._mode, wanted
        self._round_began = bool(self._active)
        if wanted is Mode.PAUSE:
            for one in self._active:
                one.running.pause()
            self._trace.write(TraceEventKind.PAUSED, Message("pauses: everything comes to a standstill where it is"))
        elif before is Mode.PAUSE:
            for one in self._active:
                one.running.resume()
            said = Message("goes on") if wanted is Mode.RUN else Message("goes on by one step")
            self._trace.write(TraceEventKind.RESUMED, said)

    # ------------------------------------------------------------------ one step

    def _may_start(self, index: int) -> bool:
        step = self._agenda.steps[index]
        agent = self._agent(step)
        runs = (*(one.run for one in self._active), *(run for run, _ in self._coming.values()))
        if any(run.agent == agent for run in runs):
            return False
        managers = self._context.managers
        if agent in managers and step.skill in managers[agent].running:
            self._write_wait(step, Message("{skill} of {agent} is running already", skill=step.skill, agent=agent))
            return False
        return True

    def _prepare(self, index: int) -> None:
        """Announces a step and starts it: at once in lockstep, otherwise once its intent is safely on disk."""
        refusal = self._take_from_stock(index)
        step = self._agenda.steps[index]
        if refusal is not None:
            self._failed.append((step, refusal))
            return
        self._started += 1
        run = StepRun(self._started, step, self._agent(step), self._context.now)
        try:
            self._coming[index] = run, self._task.starts(run)
        except DiskFault:  # the next cycle tries again
            return
        self._start(index)

    def _start(self, index: int) -> None:
        run, waits = self._coming[index]
        if not (self._context.lockstep or all(one.done() for one in waits)):
            return
        del self._coming[index]
        try:
            for one in waits:
                one.result()
        except DiskFault as fault:  # the next cycle prepares it again
            self._task.ended(run, Failure(Message("it was not started: {fault}", fault=fault), CANCELLED))
            return
        run = replace(run, start=self._context.now)
        self._round_began = True
        self._used = None
        self._trace.write(TraceEventKind.STARTED, Message("{step} starts", step=self._said(run.step)), {}, run)
        managers, task = self._context.managers, self._task.name
        try:
            if run.agent not in managers:
                raise UsageError("the skill manager of {agent} is gone", agent=run.agent)
            parent = step_id(task, run.number)
            tried = self._tried[purpose(run.step, self._skills[run.step.skill], self._context.world)]
            running = managers[run.agent].start(
                run.step.skill, run.step.arguments, task=task, parent=parent, tried=tried, ahead=self._ahead(index)
            )
        except UsageError as refusal:
            failure = Failure(str(refusal), CANCELLED)  # not the target's fault
            self._note_end(run, failure, {})
            self._failed.append((run.step, failure))
            return
        self._agenda.running[index] = Active(run, robot_of(self._context.world, run.agent), running)

    def _ahead(self, index: int) -> frozenset[str]:
        """Returns what the next steps of the same robot are about, up to the next one with the same skill."""
        first = self._agenda.steps[index]
        robot, found = robot_of(self._context.world, self._agent(first)), set[str]()
        for step in self._agenda.steps[index + 1 :]:
            if robot_of(self._context.world, self._agent(step)) == robot:
                if step.skill == first.skill:
                    break
                found.update(step.arguments.values())
        return frozenset(found)

    def _forget_coming(self) -> None:
        """Drops the steps that wait for the disk; they were never started."""
        for run, _ in self._coming.values():
            self._task.ended(run, Failure(Message("it was not started"), CANCELLED))
        self._coming.clear()

    def _take_from_stock(self, index: int) -> Failure | None:
        """Creates individuals for the things a step takes from stock; this and later steps refer to them."""
        step = self._agenda.steps[index]
        tokens = tokens_of((step,))
        if not tokens:
            return None
        try:
            with self._context.world.transaction(
                self._task.name, Message("{step} is next", step=self._said(step))
            ) as tx:
                taken = {token: take(tx, token) for token in tokens}
        except WorldError as refusal:
            return Failure(str(refusal), CANCELLED)  # caused by the plan, not by the step
        self._agenda.rename(taken)
        if self._task.plan is not None:
            self._task.plan = self._task.plan.renamed(taken)
        self._used = None
        self._claim()
        return None

    def _collect(self) -> None:
        for index, one in tuple(self._agenda.running.items()):
            if not one.running.done and not self._context.offers(one.run.agent, one.step.skill):
                one.running.stop()
            if one.running.done:
                self._end(index, one)

    def _end(self, index: int, one: Active) -> None:
        outcome = one.running.result
        self._used = None
        if isinstance(outcome, Failure) and not one.leaving:
            del self._agenda.running[index]
            self._failed.append((one.step, outcome))
        else:
            self._agenda.end(index)
        if isinstance(outcome, Failure) and one.leaving:
            outcome = Failure(outcome.reason, CANCELLED)
        self._note_end(one.run, outcome, one.running.account)

    def _note_end(self, run: StepRun, outcome: Outcome, account: Mapping[str, object]) -> None:
        skill, now = self._skills[run.step.skill], self._context.now
        self._ended.append(StepEnd(run, skill, outcome, now))
        said, data = self._said(run.step), {"start": run.start, "seconds": now - run.start, **account}
        if isinstance(outcome, Failure):
            what, text = TraceEventKind.CANCELLED, _cancelled(said, outcome.reason)
            if outcome.code != CANCELLED:
                what = TraceEventKind.FAILED
                text = Message("{step} failed: {reason}", step=said, reason=outcome.reason)
            tried = self._tried[purpose(run.step, skill, self._context.world)].as_json()
            more = {"reason": outcome.reason, "code": outcome.code, "tried": tried, **outcome.values}
            self._trace.write(what, text, data | more, run)
        else:
            self._trace.write(
                TraceEventKind.ENDED, Message("{step} is done", step=said), data | {"message": outcome.message}, run
            )
        self._task.ended(run, outcome)

    # ------------------------------------------------------------------ robots and things

    def _claim(self) -> bool:
        """Reserves the robots and things that the remaining steps use, and releases the others.

        Returns:
            True if all of them are reserved, so that steps may start.
        """
        reservations, who, view = self._context.reservations, self._task.name, self._context.world
        if self._used is None:
            running = [one.step for one in self._active]
            waiting = [self._agenda.steps[index] for index in self._agenda.waiting]
            self._used = used_by((*running, *waiting), self._skills, view), used_by(running, self._skills, view)
        everything, moving = self._used
        if self.lends:
            keeps = moving | in_hands(view, reservations.of(who))
            reservations.claim(who, keeps, keeps, starts=False)
            return False
        if reservations.claim(who, everything, moving, starts=self._goes_on):
            return self._goes_on
        others = reservations.waits_for(who)
        for index in self._agenda.ready[:1] if others else ():
            self._write_wait(self._agenda.steps[index], Message("for {things}", things=", ".join(others)))
        return False

    def _meet(self, one: Active, step: Step) -> bool:
        """Returns True if two steps involve the same robot or thing, so that one has to wait for the other."""
        if robot_of(self._context.world, self._agent(step)) == one.robot:
            return True
        return not set(one.step.arguments.values()).isdisjoint(step.arguments.values())

    # ------------------------------------------------------------------ the trace

    def _write_wait(self, step: Step, why: str) -> None:
        """Writes that a step has to wait; once per plan and reason."""
        text = Message("{step} waits: {why}", step=self._said(step), why=why)
        if text not in self._waits:
            self._waits.add(text)
            run = StepRun(0, step, self._agent(step), self._context.now)
            self._trace.write(TraceEventKind.WAITS, text, {"reason": why}, run)

    def _agent(self, step: Step) -> str:
        return step.arguments[self._skills[step.skill].agent]

    def _said(self, step: Step) -> str:
        return describe_step(step, self._skills[step.skill])


def _cancelled(step: str, why: str) -> Message:
    return Message("{step} is cancelled: {why}", step=step, why=why)
