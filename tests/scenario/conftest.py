"""Scenarios: a goal goes in, the simulator's truth is judged. Disturbances come at a moment, told to nobody."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from skiros_py import workers
from skiros_py.errors import DeviceError
from skiros_py.station.session import Options, Session


@pytest.fixture(scope="package", autouse=True)
def warm_workers() -> Iterator[None]:
    """Lets worker processes serve the next session, too: each takes a second to import its libraries."""
    idle: defaultdict[str, list[workers.Worker]] = defaultdict(list)
    start, close = workers.Worker.__init__, workers.Worker.close

    def start_again(self: workers.Worker, name: str, factory: Callable[[], object]) -> None:
        if not idle[name]:
            start(self, name, factory)
            return
        self.name, self._pool = name, idle[name].pop()._pool
        self._pool.submit(workers._build, factory, os.getpid())

    def keep(self: workers.Worker) -> None:
        try:
            workers.Call(self._pool.submit(workers._build, object, os.getpid()), self.name, 0.0).result()
        except (DeviceError, *workers._DEAD):  # a test has killed it
            close(self)
        else:
            idle[self.name].append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers.Worker, "__init__", start_again)
        patch.setattr(workers.Worker, "close", keep)
        yield
    for kept in idle.values():
        for worker in kept:
            worker.close()


@pytest.fixture
def open_session() -> Iterator[Callable[..., Session]]:
    with ExitStack() as stack:

        def open_(scene: str = "kitting", **options: Any) -> Session:
            return stack.enter_context(Session(scene, Options(**options)))

        yield open_


@pytest.fixture
def when() -> Callable[[Session, Callable[[], bool], Callable[[], None]], None]:
    """Does something once, at the end of the first cycle in which a predicate holds."""

    def arrange(session: Session, predicate: Callable[[], bool], action: Callable[[], None]) -> None:
        done: list[bool] = []

        def look() -> None:
            if not done and predicate():
                done.append(True)
                action()

        session.cycle.observe(look)

    return arrange
