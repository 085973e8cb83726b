"""A module or document that was started: its run and its handle."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import Any

from skiros_py.behaviours.children import run_until
from skiros_py.errors import UsageError
from skiros_py.execution.module_faults import contained
from skiros_py.execution.monitor import Status
from skiros_py.execution.scope import ModuleRun, Scope
from skiros_py.execution.task import Task
from skiros_py.messages import Message, joined
from skiros_py.skills.outcome import BROKEN, Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import missing, read_arguments
from skiros_py.skills.skill import RunnableDocument


class BehaviourRun(ModuleRun):
    """Runs a document once, as it was when the run began.

    Its devices are taken by the modules that it calls; what is cancelled with it recovers as in any composition.

    Args:
        name: The module ("tree:tidy_up").
        document: What is run.
        arguments: Its parameters, and further values that its nodes read.
        scope: What it runs in.
        run: Id of this run; a new one where left out.
    """

    def __init__(
        self, name: str, document: RunnableDocument, arguments: Mapping[str, Any], scope: Scope, run: str = ""
    ) -> None:
        super().__init__("document", name, arguments, scope, run)
        self._document = document
        self._arguments = dict(arguments)
        values: dict[str, Any] = {}
        self._scope = self.inner_scope(arguments=ChainMap(self._arguments, values), values=values)

    @property
    def implementation(self) -> str:
        """The revision of the document."""
        return f"revision {self._document.revision}"

    def run(self) -> Execution[Outcome]:
        """Runs its behaviour."""
        self.started = True
        self.tell(Status.STARTED, 0, self.implementation)
        self._outer.check_depth(self.name)
        specified = contained(self.name, self._specify)
        if isinstance(specified, Failure):
            return specified
        outcome = yield from run_until(self._document.behaviour, "body", self._scope, self.tick)
        if isinstance(outcome, Failure) or not self._document.outputs:
            return outcome
        written = self._scope.values
        return Success(outcome.message, {key: written[key] for key in self._document.outputs if key in written})

    def _specify(self) -> None:
        """Reads the arguments of declared parameters.

        Raises:
            SkirosError: A value is missing or wrong.
        """
        params = self._document.params
        if not params:
            return
        values = read_arguments(params, self._arguments, self._scope.context.world)
        if open_ := missing(params, values):
            raise UsageError("{keys}: not specified", keys=", ".join(open_))
        self._arguments.update(values)

    def leave(self) -> bool:
        """Ends it at once: its modules keep their own devices to recover."""
        self._outer.unfinished.extend(self._scope.unfinished)
        return False


class RunningModule:
    """A module that runs in this process's control cycle.

    Args:
        run: What runs.
        task: Its task.
        scope: Its outermost scope; its devices are kept until all stands.

    Attributes:
        name: The module.
        id: Id of this run.
        changes: Numbers of its changes of the world; filled in by its skill manager.
    """

    def __init__(self, run: ModuleRun, task: Task[Outcome], scope: Scope) -> None:
        self.name = run.name
        self.id = run.id
        self.run = run
        self.task = task
        self.scope = scope
        self.changes: list[int] = []

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Its parameters; those that are inferred come in the first cycle."""
        return self.run.arguments

    @property
    def breakpoints(self) -> set[str]:
        """Paths of nodes before which it is paused (``pick/body/1``); they may be changed while it runs."""
        return self.scope.breakpoints

    @property
    def account(self) -> Mapping[str, Any]:
        """What it was run with, what was found of its conditions, and what it changed, as plain data.

        ``inputs``: values by parameter key; ``conditions``: what was found last of each one that was looked at;
        ``implementation``: of a skill, the label of the way that was tried last; ``changes``: numbers of its changes
        of the world.
        """
        return {**self.run.account(), "changes": list(self.changes)}

    @property
    def done(self) -> bool:
        """True when it ended, or when it was stopped and all it moved stands."""
        return self.task.done and not self.task.stopping

    @property
    def status(self) -> str:
        """One of "running", "paused", "stopping", "stopped", "ended"."""
        task = self.task
        if task.stopping:
            return "stopping"
        if task.done:
            return "stopped" if task.stopped else "ended"
        return "paused" if task.paused else "running"

    @property
    def result(self) -> Outcome:
        """How it ended; a module that was stopped, or broke, has failed.

        Raises:
            UsageError: It still runs.
        """
        task = self.task
        if not task.done:
            raise UsageError("{name} still runs", name=self.name)
        if task.fault is not None:
            return Failure(Message("{name} broke: {fault}", name=self.name, fault=task.fault), BROKEN)
        if task.stopped or task.stopping:
            stopped = Message("{name} was stopped", name=self.name)
            return Failure(joined(": ", (stopped, task.reason)) if task.reason else stopped)
        return task.result

    def cancel(self, reason: str) -> None:
        """Cancels it because the world changed; finishing motion, such as stowing the arm, still runs."""
        if self.run.cancel(reason):
            self.task.resume()  # what was paused must be able to end
        else:
            self.task.stop(reason)

    def pause(self) -> None:
        """Lets it come to a standstill where it is; its devices stay its own."""
        self.task.pause()

    def resume(self) -> None:
        """Goes on after a pause."""
        self.task.resume()

    def step(self) -> None:
        """Lets it do one cycle while it is paused."""
        self.task.step()

    def stop(self) -> None:
        """Stops it in this cycle; nothing follows. It is done when all it moved stands."""
        self.task.stop()
