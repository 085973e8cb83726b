"""The planning process: a replica of the world with planners, which answers each request in a forked copy.

What the planners have loaded is there for every request. A copy that hangs, crashes or is killed affects no other.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import signal
from collections.abc import Callable, Sequence
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.requests import Request, answered
from skiros_py.programs import kill_marked
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.queries.replica import Replica

MARK = "SKIROS_PLANNING"
"""Environment variable that marks programs started by the process or its copies."""
PROCESSOR_TIME = 120.0
"""CPU time limit of an answer; external planner programs have their own limits [s]."""


class PlanningReplica(Replica):
    """The replica and its planners.

    Args:
        index: The state of the world.
        make_planners: Pickled; makes the planners.
        mark: Identifies the programs of this process.
    """

    patience = 0.5

    def __init__(self, index: Index, make_planners: bytes, mark: str) -> None:
        super().__init__(index)
        self._make_planners: Callable[[], Planners] = pickle.loads(make_planners)  # noqa: S301  from our own parent
        self._planners: Planners | None = None
        self._mark = mark
        os.environ[MARK] = mark
        self._warm_up()

    def follow(self, changes: Sequence[Change]) -> None:
        """Applies changes, before each request: planners that have died are started again, too."""
        super().follow(changes)
        self._warm_up()

    def _warm_up(self) -> None:
        with contextlib.suppress(Exception):  # a request will report what is wrong with them
            self._planners = self._planners or self._make_planners()
            self._planners.warm_up()

    def after(self, pid: int, code: int) -> None:
        """Ends the programs of a copy that was killed."""
        if code != 0:
            kill_marked(MARK, self._mark_of(pid))

    def _mark_of(self, pid: int) -> str:
        return f"{self._mark}.{pid}."

    def answer(self, order: bytes, answer: int) -> object:
        """Answers one request; stops when it is cancelled.

        Raises:
            SkirosError: There is no answer.
        """
        os.environ[MARK] = self._mark_of(os.getpid())
        waiting = select.poll()
        waiting.register(answer, select.POLLERR)
        signal.signal(signal.SIGVTALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_VIRTUAL, PROCESSOR_TIME)
        planners = self._planners or self._make_planners()
        try:
            return answered(_request(order), self.index, planners, lambda: bool(waiting.poll(0)))
        finally:
            planners.close()


def _request(order: bytes) -> Request[Any]:
    try:
        request: Request[Any] = pickle.loads(order)  # noqa: S301  from our own parent
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise UsageError(f"it cannot be read in another process: {why}") from error
    return request
