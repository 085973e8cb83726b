from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from functools import partial

import pytest

from skiros_py.errors import DeviceError, UnknownName
from skiros_py.workers import Worker
from skiros_py.world.names import Names


@pytest.fixture(scope="module")
def names_worker() -> Iterator[Worker]:
    with closing(Worker("names", partial(Names, {"tiny": "https://tiny#"}))) as worker:
        yield worker


def test_a_worker_calls_methods_of_its_object(names_worker: Worker) -> None:
    assert names_worker.call("iri", "tiny:Ball").result() == "https://tiny#Ball"


def test_calls_are_answered_in_order(names_worker: Worker) -> None:
    calls = [names_worker.call("iri", f"tiny:B{n}") for n in range(5)]

    assert [call.result() for call in calls] == [f"https://tiny#B{n}" for n in range(5)]
    assert all(call.done() for call in calls)


def test_a_call_bears_its_declared_latency(names_worker: Worker) -> None:
    assert names_worker.call("iri", "tiny:Ball", latency=0.3).latency == pytest.approx(0.3)


def test_a_fault_comes_back_as_it_was_raised(names_worker: Worker) -> None:
    with pytest.raises(UnknownName) as caught:
        names_worker.call("iri", "tinny:Ball").result()

    assert (caught.value.kind, caught.value.nearest) == ("prefix", "tiny")


def test_after_a_fault_the_worker_still_answers(names_worker: Worker) -> None:
    with pytest.raises(UnknownName):
        names_worker.call("iri", "tinny:Ball").result()

    assert names_worker.call("iri", "tiny:Ball").result() == "https://tiny#Ball"


@pytest.mark.filterwarnings("ignore:A worker stopped while some jobs")
def test_an_interrupt_meant_for_the_parent_does_not_reach_a_worker() -> None:
    with closing(Worker("clock", partial(__import__, "os"))) as worker:
        child = worker.call("getpid").result()
        os.kill(child, signal.SIGINT)
        time.sleep(0.1)

        assert worker.call("getpid").result() == child


def test_a_worker_that_dies_is_a_device_error_with_its_name() -> None:
    with (
        closing(Worker("doomed", partial(__import__, "os"))) as worker,
        pytest.raises(DeviceError, match="the doomed worker process died"),
    ):
        worker.call("_exit", 1).result()


def test_a_call_to_a_worker_that_died_is_a_device_error_too() -> None:
    with closing(Worker("doomed", partial(__import__, "os"))) as worker:
        with pytest.raises(DeviceError):
            worker.call("_exit", 1).result()

        with pytest.raises(DeviceError, match="the doomed worker process died"):
            worker.call("getpid").result()


def test_an_object_that_cannot_be_built_is_a_device_error_with_the_workers_name(
    capfd: pytest.CaptureFixture[str],
) -> None:
    broken = Worker("broken", partial(__import__, "no_such_module"))
    with closing(broken), pytest.raises(DeviceError, match="the broken worker process died"):
        broken.call("anything").result()
    capfd.readouterr()
