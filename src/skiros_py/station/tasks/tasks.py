"""Use cases: active and ended tasks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

from skiros_py.api.jobs import JobPolicy
from skiros_py.api.tasks import NewTask, TaskInfo, Tasks, TaskTrace
from skiros_py.errors import Refused
from skiros_py.planning.plan import Step
from skiros_py.station.requests import LIBRARY, Author, Service, addressed
from skiros_py.station.session import Session
from skiros_py.station.tasks.book import KeptTask
from skiros_py.station.tasks.steps import Workbench, require_works
from skiros_py.station.tasks.views import task_info, task_trace
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.sequences import StepSequence

_PLAIN = JobPolicy()


class TaskService(Service):
    """Starts, follows and commands tasks."""

    def all(self, *, active: bool | None = None, limit: int = 100) -> Tasks:
        """Lists tasks, newest first.

        Args:
            active: True for active tasks only, False for ended tasks only.
            limit: Maximum number of tasks.
        """
        wanted = [task for task in self._station.task_book.all() if active is None or active != task.over]
        return Tasks(items=tuple(task_info(task, in_full=False) for task in wanted[:limit]))

    def begin(self, request: NewTask, author: Author = LIBRARY) -> TaskInfo:
        """Starts to pursue a goal, or to run steps without planning.

        Raises:
            UsageError: The goal or a step cannot be parsed.
            Refused: A step cannot work, and running it anyway was not requested.
            WrongState: Everything is halted.
        """
        if request.goal is not None:
            conditions = self._station.session.parse(request.goal)
            policy = Policy(**request.policy.model_dump())
            return self._note(lambda session: session.begin(conditions, policy), author)
        bench = Workbench.of(self._station.session)
        steps = tuple(bench.read(step) for step in request.steps or [])
        return self.run_steps(steps, request.iterate, author, anyway=request.anyway, policy=request.policy)

    def run_steps(
        self,
        steps: Sequence[Step],
        iterate: int | None,
        author: Author,
        *,
        anyway: bool,
        policy: JobPolicy = _PLAIN,
    ) -> TaskInfo:
        """Starts to run steps without planning.

        Raises:
            Refused: There are none; or they cannot work now, and running them anyway was not requested.
            UsageError: A step refers to something that does not exist.
            WrongState: Everything is halted.
        """
        if not steps:  # repetitions without steps take no time: the control cycle would never end
            raise Refused("CannotWork", "the sequence has no steps: add one")
        if not anyway:
            require_works(self._station.session, steps)

        def begin(session: Session) -> TaskHandle:
            sequence = StepSequence(session.world, Workbench.of(session).skills, steps)
            # Checked above: the control thread has no time to check again.
            session.runtime.require_ready()
            return session.tasks.execute(sequence, iterate=iterate, policy=Policy(**policy.model_dump()), anyway=True)

        return self._note(begin, author)

    def _note(self, begin: Callable[[Session], TaskHandle], author: Author) -> TaskInfo:
        def do(session: Session) -> KeptTask:
            return self._station.task_book.note(begin(session), by=author.name)

        return task_info(self._station.control.call(do))

    def get(self, name: str) -> TaskInfo:
        """Describes a task: its plan, steps, pending question and result.

        Raises:
            NotFound: There is none with this name.
        """
        return task_info(self._find(name))

    def trace(self, name: str, limit: int = 1000) -> TaskTrace:
        """Returns the last entries of a task's trace.

        Raises:
            NotFound: There is none with this name.
        """
        return task_trace(self._find(name), limit)

    def command(
        self, name: str, command: Literal["pause", "resume", "step", "stop"], author: Author = LIBRARY
    ) -> TaskInfo:
        """Commands a task; takes effect in the next control cycle.

        Raises:
            NotFound: There is none with this name.
            WrongState: It does not accept that command now.
        """
        task = self._find(name)
        task.command(command, author.name)
        return task_info(task)

    def _find(self, name: str) -> KeptTask:
        with addressed():
            return self._station.task_book.find(name)
