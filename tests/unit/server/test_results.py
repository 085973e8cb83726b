"""Results of other threads in the event loop."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future

import pytest

from skiros_py.server.results import Results


def _later(futures, do):
    thread = threading.Thread(target=lambda: [do(number, future) for number, future in enumerate(futures)])
    thread.start()
    return thread


def test_each_caller_gets_its_own_result_also_when_many_come_at_once():
    async def ask():
        results, futures = Results(), [Future() for _ in range(500)]
        asked = [asyncio.ensure_future(results.of(future)) for future in futures]
        await asyncio.sleep(0)
        thread = _later(futures, lambda number, future: future.set_result(number))
        found = await asyncio.wait_for(asyncio.gather(*asked), 30.0)
        thread.join()
        return found

    assert asyncio.run(ask()) == list(range(500))


def test_results_at_the_same_time_wake_the_loop_once():
    async def ask():
        results, futures, loop = Results(), [Future() for _ in range(20)], asyncio.get_running_loop()
        woken, wake = [], loop.call_soon_threadsafe
        loop.call_soon_threadsafe = lambda *call, **options: woken.append(call) or wake(*call, **options)
        asked = [asyncio.ensure_future(results.of(future)) for future in futures]
        await asyncio.sleep(0)
        _later(futures, lambda _number, future: future.set_result(None)).join()  # the loop cannot answer meanwhile
        await asyncio.gather(*asked)
        return len(woken)

    assert asyncio.run(ask()) == 1


def test_an_exception_is_raised_where_it_is_awaited_and_a_caller_that_is_gone_disturbs_no_other():
    async def ask():
        results, futures = Results(), [Future() for _ in range(3)]
        gone, refused, answered = (asyncio.ensure_future(results.of(future)) for future in futures)
        await asyncio.sleep(0)
        gone.cancel()
        futures[0].set_result("not asked for")
        futures[1].set_exception(ValueError("refused"))
        futures[2].set_result("answered")
        with pytest.raises(ValueError, match="refused"):
            await refused
        return await answered

    assert asyncio.run(ask()) == "answered"
