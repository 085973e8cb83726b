"""Planning in threads of this process: for tests, and where nothing else needs the interpreter meanwhile."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import TypeVar

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.requests import Answer, Asked, Request, answered
from skiros_py.world.world import World

__all__ = ["ThreadHost"]

T = TypeVar("T")


class ThreadHost:
    """Answers requests in threads.

    Args:
        world: What requests are about.
        planners: What solves the PDDL: one planner, or several to choose from. They are not closed.
    """

    def __init__(self, world: World, planners: Planner | Planners) -> None:
        self._world = world
        self._planners = planners if isinstance(planners, Planners) else Planners.only(planners)
        self._threads = ThreadPoolExecutor(thread_name_prefix="skiros-planning")
        self._closed = Event()

    def ask(self, request: Request[T]) -> Asked[T]:
        """Begins to answer a request about the world as it is now.

        Raises:
            PlanningError: It was closed.
        """
        stop = Event()
        version, state = self._world.state()

        def work() -> Answer[T]:
            value = answered(request, state, self._planners, lambda: stop.is_set() or self._closed.is_set())
            return Answer(version, value)

        try:
            return Asked(self._threads.submit(work), stop.set)
        except RuntimeError:
            raise PlanningError("planning was stopped") from None

    def close(self) -> None:
        """Ends everything that is under way."""
        self._closed.set()
        self._threads.shutdown(wait=True, cancel_futures=True)
