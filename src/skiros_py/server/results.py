"""Results of other threads, awaited in the event loop."""

from __future__ import annotations

import asyncio
from collections import deque
from concurrent.futures import Future
from contextlib import suppress
from typing import TypeVar

T = TypeVar("T")


class Results:
    """Brings results to the event loop; those that are there at the same time wake it once.

    ``asyncio.wrap_future`` wakes it for each: the thread that stores a group of orders would wait for the interpreter
    after each answer.
    """

    def __init__(self) -> None:
        self._done: deque[asyncio.Future[None]] = deque()
        self._is_woken = False

    async def of(self, future: Future[T]) -> T:
        """Returns the result of a future that another thread completes, or raises its exception."""
        loop = asyncio.get_running_loop()
        waiting = loop.create_future()
        future.add_done_callback(lambda _: self._add(waiting, loop))
        await waiting
        return future.result()

    def _add(self, waiting: asyncio.Future[None], loop: asyncio.AbstractEventLoop) -> None:
        self._done.append(waiting)
        if not self._is_woken:
            self._is_woken = True
            with suppress(RuntimeError):  # the loop is closed, and no caller waits
                loop.call_soon_threadsafe(self._answer)

    def _answer(self) -> None:
        self._is_woken = False  # first: what comes from now on wakes the loop again
        while self._done:
            waiting = self._done.popleft()
            if not waiting.done():  # it is cancelled when the caller is gone
                waiting.set_result(None)
