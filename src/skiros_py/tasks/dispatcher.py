"""Dispatches the steps of a plan to the skill managers; independent steps run concurrently."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import UsageError, WorldError
from skiros_py.execution.running import Running
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.stock import tokens_of
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import Mode, TaskContext
from skiros_py.tasks.handle import StepRun, TaskHandle
from skiros_py.tasks.history import History
from skiros_py.tasks.reservations import in_hands, robot_of, used_by
from skiros_py.tasks.trace import TraceEventKind, step_id
from skiros_py.tasks.trace_writer import TraceWriter
from skiros_py.world.stock import take


class Agenda:
    """The steps of one plan and their progress. Steps are identified by index.

    Args:
        steps: The steps, in a feasible order.
        after: For each step the indices of the steps that must have ended before it starts.
    """

    def __init__(self, steps: Sequence[Step], after: Sequence[Collection[int]]) -> None:
        self.steps = list(steps)
        self._after = [set(before) for before in after]
        self._waiting = dict.fromkeys(range(len(self.steps)))
        self._running: dict[int, None] = {}

    @property
    def waiting(self) -> tuple[int, ...]:
        """The steps that have not started, in order."""
        return tuple(self._waiting)

    @property
    def running(self) -> tuple[int, ...]:
        """The running steps."""
        return tuple(self._running)

    @property
    def done(self) -> bool:
        """True when every step has ended."""
        return not self._waiting and not self._running

    @property
    def ready(self) -> tuple[int, ...]:
        """The steps that no unfinished step precedes, in order."""
        open_ = self._waiting.keys() | self._running.keys()
        return tuple(index for index in self._waiting if open_.isdisjoint(self._after[index]))

    def start(self, index: int) -> None:
        """Marks a step as running."""
        del self._waiting[index]
        self._running[index] = None

    def end(self, index: int) -> None:
        """Marks a step as successfully ended."""
        del self._running[index]

    def again(self, index: int) -> None:
        """Marks a step as ended and to be repeated."""
        del self._running[index]
        self._waiting = dict.fromkeys(sorted((*self._waiting, index)))

    def rename(self, names: Mapping[str, str]) -> None:
        """Renames elements in the steps' arguments."""
        self.steps = [step.renamed(names) for step in self.steps]

    def leads_to(self, earlier: int, later: int) -> bool:
        """Returns True if the later step has to wait for the earlier one, directly or transitively."""
        open_, seen = [later], set[int]()
        while open_:
            before = self._after[open_.pop()] - seen
            if earlier in before:
                return True
            seen |= before
            open_ += before
        return False

    def with_running(self, running: Sequence[Step], shared: Collection[tuple[int, int]]) -> Agenda:
        """Returns the agenda preceded by steps of another plan that are already running.

        Args:
            running: These steps; they get the first indices and are marked as running.
            shared: Pairs of a running step and the step of this agenda, by its index here, that has to wait for it.
        """
        more = len(running)
        after = [{one + more for one in before} for before in self._after]
        for earlier, later in shared:
            after[later].add(earlier)
        joined = Agenda((*running, *self.steps), (*(set[int]() for _ in running), *after))
        for index in range(more):
            joined.start(index)
        return joined


class Share:
    """The robots and things of one task.

    Args:
        who: Name of the task.
        context: World and reservations.
        skills: The available skills by name; extended as managers appear.

    Attributes:
        lent: True while the task waits for the user, which may take long: other tasks may use what is at rest, except
            robots that hold a thing of this task, so that it is not put down elsewhere.
    """

    def __init__(self, who: str, context: TaskContext, skills: Mapping[str, SkillDescription]) -> None:
        self.lent = False
        self._who = who
        self._context = context
        self._reservations = context.reservations
        self._skills = skills

    def ask(self, steps: Sequence[Step]) -> None:
        """Requests what running and remaining steps use; anything else becomes free for others."""
        self._reservations.request(self._who, self._used(steps))

    def granted(self, running: Collection[Step], *, going_on: bool) -> bool:
        """Returns whether no other task holds, or requested earlier, what this task requested; takes it if free now.

        Args:
            running: The running steps; what they use is always kept.
            going_on: False while no step may start: then it takes nothing and does not block others. It has to request
                again afterwards.
        """
        reservations, who = self._reservations, self._who
        if self.lent:
            own = in_hands(self._context.world, reservations.of(who))
            reservations.withdraw(who, self._used(running) | own)
        elif reservations.waits(who) and not going_on:
            reservations.withdraw(who, self._used(running))
        elif reservations.waits(who):
            return reservations.granted(who, self._used(running))
        return going_on and not self.lent

    @property
    def waits_for(self) -> tuple[str, ...]:
        """What its request is waiting for: "robot_1 (kit 7)"."""
        return self._reservations.waits_for(self._who)

    def release(self, moving: Iterable[str], stands: Callable[[], bool]) -> None:
        """Releases everything.

        Args:
            moving: Those elements that become free only once they are at rest.
            stands: Returns whether they are at rest.
        """
        self._reservations.release(self._who, moving, stands)

    def _used(self, steps: Iterable[Step]) -> frozenset[str]:
        return used_by(tuple(steps), self._skills, self._context.world)


class Dispatcher:
    """Runs the steps of one task's plans.

    Args:
        task: The task, with its control requests and trace.
        context: The task's environment: world, managers, planning.
        history: Records every step that was run.
        skills: The available skills by name; extended as managers appear.

    Attributes:
        agenda: The remaining steps of the current plan.
        trace: Writes the trace.
    """

    def __init__(
        self, task: TaskHandle, context: TaskContext, history: History, skills: Mapping[str, SkillDescription]
    ) -> None:
        self.agenda = Agenda((), ())
        self._task = task
        self._context = context
        self._history = history
        self._skills = skills
        self.trace = TraceWriter(task.name, task.trace, context, skills)
        self._share = Share(task.name, context, skills)
        self._active: list[Active] = []
        self._coming: dict[int, tuple[StepRun, tuple[Future[None], ...]]] = {}  # steps whose intent is being saved
        self._started = 0
        self._mode = Mode.RUN
        self._round_began = False
        self._granted = True

    # ------------------------------------------------------------------ the agenda

    @property
    def active(self) -> tuple[Active, ...]:
        """The running steps."""
        return tuple(self._active)

    @property
    def rest(self) -> tuple[Step, ...]:
        """The steps that have not started, in order."""
        return tuple(self.agenda.steps[index] for index in self.agenda.waiting)

    def adopt(self, agenda: Agenda, kept: Mapping[int, Active]) -> None:
        """Switches to another plan; running steps of the old plan that are not in the new one finish first.

        Args:
            agenda: The new agenda.
            kept: Its steps that are already running, by index.
        """
        self._forget_coming()
        before = [one for one in self._active if one not in kept.values()]
        later = [index for index in agenda.waiting if index not in kept]
        shared = {(n, i) for n, one in enumerate(before) for i in later if self._meet(one, agenda.steps[i])}
        self.agenda = agenda.with_running([one.step for one in before], shared)
        for index, one in enumerate(before):
            one.index = index
        for index, one in kept.items():
            one.index = index + len(before)
            self.agenda.start(one.index)
        self.trace.forget_waits()
        self._reserve()

    def break_off(self, one: Active, reason: str) -> None:
        """Cancels a step that is no longer useful; it still runs its cleanup, such as stowing the arm."""
        if not one.leaving:
            one.leaving = reason
            one.running.break_off(reason)

    # ------------------------------------------------------------------ each cycle

    def attend(self) -> list[tuple[Step, Failure]]:
        """Applies control requests and collects ended steps.

        Returns:
            The steps that failed; they are to be repeated.
        """
        self._obey()
        failed: list[tuple[Step, Failure]] = []
        for one in self.active:
            if not one.running.done and not self._context.offers(one.run.agent, one.step.skill):
                one.running.stop()
            if one.running.done:
                outcome = self._end(one)
                if isinstance(outcome, Failure) and not one.leaving:
                    failed.append((one.step, outcome))
        self._granted = self._has_its_robots()
        return failed

    def start_ready(self) -> list[tuple[Step, Failure]]:
        """Starts the steps that are ready.

        Returns:
            The steps that could not be started.
        """
        refused: list[tuple[Step, Failure]] = []
        if not self._granted or self.paused:
            return refused
        for index in self.agenda.ready:
            if index in self._coming:
                refused += self._start_prepared(index)
            elif self._goes_on and self._may_start(index):
                refused += self._prepare(index)
        self._round_began = self._round_began or bool(self._coming)
        return refused

    def halt(self, reason: str) -> Execution[None]:
        """Stops all running steps and waits until they have come to rest."""
        self._forget_coming()
        for one in self._active:
            one.leaving = one.leaving or reason
            one.running.stop()
        while self._active:
            for one in self.active:
                if one.running.done:
                    self._end(one)
            if self._active:
                yield

    def leave(self) -> None:
        """Stops all running steps at once and releases the reservations: those of moving devices once at rest."""
        why = self._context.cycle.halted or "stopped"
        for one in self._active:
            one.running.stop()
            said = f"{self.trace.describe(one.step)} is broken off: {why}"
            self.trace.write_step(TraceEventKind.BROKEN_OFF, said, one.run, {"reason": why, **one.running.account})
        braking = tuple(one.running for one in self._active)
        moving = {id_ for one in self._active for id_ in (one.robot, *one.step.arguments.values())}
        self._active.clear()
        self._share.release(moving, lambda: all(running.done for running in braking))

    @property
    def idle(self) -> bool:
        """True if nothing can happen now: paused, or waiting for reservations of other tasks with no step running."""
        return self.paused or not (self._granted or self._active)

    @property
    def _goes_on(self) -> bool:
        """True while control requests allow steps to start."""
        return not (self._mode is Mode.PAUSE or (self._mode is Mode.SINGLE and self._round_began))

    @property
    def paused(self) -> bool:
        """True if no step may start and running steps are at rest or coming to rest."""
        return self._mode is Mode.PAUSE

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
            self._each(lambda one: one.running.pause())
            self.trace.write(TraceEventKind.PAUSED, "pauses: everything comes to a standstill where it is")
        elif before is Mode.PAUSE:
            self._each(lambda one: one.running.resume())
            self.trace.write(TraceEventKind.RESUMED, "goes on" if wanted is Mode.RUN else "goes on by one step")
        self._reserve()  # nothing was reserved while paused

    def _each(self, action: Callable[[Active], None]) -> None:
        for one in self._active:
            action(one)

    # ------------------------------------------------------------------ one step

    def _may_start(self, index: int) -> bool:
        step = self.agenda.steps[index]
        agent = self.trace.agent(step)
        if any(
            run.agent == agent for run in (*(a.run for a in self._active), *(run for run, _ in self._coming.values()))
        ):
            return False
        managers = self._context.managers
        if agent in managers and step.skill in managers[agent].running:
            self.trace.write_wait(step, f"{step.skill} of {agent} is running already")
            return False
        return True

    def _prepare(self, index: int) -> list[tuple[Step, Failure]]:
        """Announces a step and starts it: at once in lockstep, otherwise once its intent is safely on disk."""
        refusal = self._take_from_stock(index)
        if refusal is not None:
            return [(self.agenda.steps[index], refusal)]
        step = self.agenda.steps[index]
        self._started += 1
        run = StepRun(self._started, step, self.trace.agent(step), self._context.now)
        self._coming[index] = run, self._task.starts(run)
        return self._start_prepared(index)

    def _start_prepared(self, index: int) -> list[tuple[Step, Failure]]:
        run, waits = self._coming[index]
        if not (self._context.lockstep or all(one.done() for one in waits)):
            return []
        del self._coming[index]
        for one in waits:
            one.result()
        return self._start(index, replace(run, start=self._context.now))

    def _start(self, index: int, run: StepRun) -> list[tuple[Step, Failure]]:
        self._round_began = True
        self.agenda.start(index)
        self.trace.write_step(TraceEventKind.STARTED, f"{self.trace.describe(run.step)} starts", run)
        try:
            running = self._begin(run)
        except UsageError as refusal:
            failure = Failure(str(refusal), BROKEN_OFF)  # not the target's fault
            self.agenda.again(index)
            self._note_end(run, failure, {})
            return [(run.step, failure)]
        self._active.append(Active(index, run, robot_of(self._context.world, run.agent), running))
        return []

    def _forget_coming(self) -> None:
        """Drops the steps that wait for the disk; they were never started."""
        for run, _ in self._coming.values():
            self._task.ended(run, Failure("it was not started", BROKEN_OFF))
        self._coming.clear()

    def _take_from_stock(self, index: int) -> Failure | None:
        """Creates individuals for the things a step takes from stock; this and later steps refer to them."""
        step = self.agenda.steps[index]
        tokens = tokens_of((step,))
        if not tokens:
            return None
        try:
            with self._context.world.transaction(self._task.name, f"{self.trace.describe(step)} is next") as tx:
                taken = {token: take(tx, token) for token in tokens}
        except WorldError as refusal:
            return Failure(str(refusal), BROKEN_OFF)  # caused by the plan, not by the step
        self.agenda.rename(taken)
        if self._task.plan is not None:
            self._task.plan = self._task.plan.renamed(taken)
        self._reserve()
        return None

    def _begin(self, run: StepRun) -> Running:
        managers = self._context.managers
        if run.agent not in managers:
            raise UsageError(f"the skill manager of {run.agent} is gone")
        task, parent = self._task.name, step_id(self._task.name, run.number)
        return managers[run.agent].start(run.step.skill, run.step.arguments, task=task, parent=parent)

    def _end(self, one: Active) -> Outcome:
        outcome = one.running.result
        self._active.remove(one)
        if isinstance(outcome, Failure) and one.leaving:
            outcome = Failure(outcome.reason, BROKEN_OFF)
        if isinstance(outcome, Failure) and not one.leaving:
            self.agenda.again(one.index)
        else:
            self.agenda.end(one.index)
        self._note_end(one.run, outcome, one.running.account)
        self._reserve()
        return outcome

    def _note_end(self, run: StepRun, outcome: Outcome, account: Mapping[str, Any]) -> None:
        now = self._context.now
        self._history.record(run.step, self._skills[run.step.skill], run.start, now, outcome)
        said, data = self.trace.describe(run.step), {"start": run.start, "seconds": now - run.start, **account}
        if isinstance(outcome, Failure):
            what = TraceEventKind.BROKEN_OFF if outcome.code == BROKEN_OFF else TraceEventKind.FAILED
            verb = "is broken off" if outcome.code == BROKEN_OFF else "failed"
            more = {"reason": outcome.reason, "code": outcome.code}
            self.trace.write_step(what, f"{said} {verb}: {outcome.reason}", run, data | more)
        else:
            self.trace.write_step(TraceEventKind.ENDED, f"{said} is done", run, data | {"message": outcome.message})
        self._task.ended(run, outcome)

    # ------------------------------------------------------------------ what others use

    @contextmanager
    def lending(self) -> Iterator[None]:
        """While entered, releases idle robots and things to other tasks; no step may start."""
        self._share.lent = True
        try:
            yield
        finally:
            self._share.lent = False
            self._reserve()

    def _reserve(self) -> None:
        """Reserves the robots and things the remaining steps use and releases the others."""
        self._share.ask((*(one.step for one in self._active), *self.rest))

    def _has_its_robots(self) -> bool:
        """Returns True if no other task holds, or requested earlier, anything the remaining plan uses."""
        if self._share.granted([one.step for one in self._active], going_on=self._goes_on):
            return True
        others = self._share.waits_for
        for index in self.agenda.ready[:1] if others else ():
            self.trace.write_wait(self.agenda.steps[index], "for " + ", ".join(others))
        return False

    def _meet(self, one: Active, step: Step) -> bool:
        """Returns True if two steps involve the same robot or thing, so that one has to wait for the other."""
        if robot_of(self._context.world, self.trace.agent(step)) == one.robot:
            return True
        return not set(one.step.arguments.values()).isdisjoint(step.arguments.values())


@dataclass(slots=True, eq=False)
class Active:
    """A running step.

    Attributes:
        index: Its index in the current agenda.
        run: The step, its number and the agent that runs it.
        robot: Id of that agent's robot.
        running: Handle of the running skill.
        leaving: Why it was cancelled; empty if it was not.
    """

    index: int
    run: StepRun
    robot: str
    running: Running
    leaving: str = ""

    @property
    def step(self) -> Step:
        """The skill with its arguments."""
        return self.run.step
