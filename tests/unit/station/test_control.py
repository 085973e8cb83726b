"""The control thread does what others ask between two cycles, and outlives whatever breaks in there."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest

from skiros_py.errors import Busy, DeviceError, UsageError, WrongState
from skiros_py.station import control as module
from skiros_py.station.control import ControlThread
from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import JobOrder

Start = Callable[..., ControlThread]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    with ExitStack() as stack:

        def start_(
            *,
            opened: Callable[[Session], object] = lambda _: None,
            closed: Callable[[Session], object] = lambda _: None,
        ) -> ControlThread:
            control = ControlThread(lambda: Session("kitting", Options(fake=True, data=tmp_path)))
            control.on_open(opened)
            control.on_open(lambda session: session.on_close(lambda: closed(session)))
            stack.callback(control.close)
            control.start()
            return control

        yield start_


def wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(3000):
        if condition():
            return
        threading.Event().wait(0.01)
    raise AssertionError("it did not come to be so")


def raise_(error: BaseException) -> None:
    raise error


def test_work_runs_in_the_control_thread_and_returns_its_result(start: Start) -> None:
    assert start().call(lambda session: (threading.current_thread().name, session.scene)) == (
        "skiros-control",
        "kitting",
    )


def test_an_exception_of_the_work_is_raised_at_its_caller(start: Start) -> None:
    control = start()

    with pytest.raises(WrongState, match="no"):
        control.call(lambda _: raise_(WrongState("no")))
    with pytest.raises(TimeoutError, match="own"):
        control.call(lambda _: raise_(TimeoutError("own")))
    assert control.alive


def test_system_exit_in_submitted_work_does_not_end_the_control_thread(start: Start) -> None:
    control = start()

    with pytest.raises(DeviceError, match="aborted: SystemExit"):
        control.call(lambda _: sys.exit(3))
    assert control.call(lambda session: session.resting)


def test_work_submitted_in_the_control_thread_runs_immediately(start: Start) -> None:
    control = start()

    assert control.call(lambda _: control.call(lambda session: session.scene)) == "kitting"


def test_the_control_thread_does_not_reopen_its_own_session(start: Start) -> None:
    control = start()

    with pytest.raises(UsageError, match="in another thread"):
        control.call(lambda _: control.reopen())
    assert control.alive


def test_a_request_that_waits_too_long_is_refused_with_a_retry_time(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    control, go_on, done = start(), threading.Event(), []
    control.soon(lambda _: go_on.wait(30.0))
    monkeypatch.setattr(module, "_PATIENCE", 0.05)

    with pytest.raises(Busy, match="did not run"):
        control.call(lambda _: done.append(1))
    go_on.set()
    monkeypatch.setattr(module, "_PATIENCE", 10.0)

    assert control.call(lambda _: done) == []


def test_running_work_that_times_out_is_not_reported_as_not_executed(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    control, go_on = start(), threading.Event()
    monkeypatch.setattr(module, "_PATIENCE", 0.2)

    with pytest.raises(DeviceError, match="is not known"):
        control.call(lambda _: go_on.wait(30.0))
    go_on.set()


def test_after_a_broken_cycle_calls_are_refused_until_a_new_session(start: Start) -> None:
    ends: list[str] = []
    control = start(closed=lambda session: ends.append(session.scene))
    control.call(lambda session: session.cycle.observe(lambda: raise_(RuntimeError("observer"))))
    wait_for(lambda: control.fault is not None)

    with pytest.raises(Busy, match="not running: the control cycle broke: observer"):
        control.call(lambda session: session.scene)
    assert not control.alive

    control.reopen()
    assert control.alive
    assert control.call(lambda session: session.resting)
    assert ends == ["kitting"]


def test_a_call_during_a_reopening_gets_the_new_session(start: Start) -> None:
    opened: list[Session] = []
    control = start(opened=opened.append)
    with ThreadPoolExecutor(8) as pool:
        calls = [pool.submit(control.call, id) for _ in range(50)]
        again = [pool.submit(control.reopen) for _ in range(3)]
        calls += [pool.submit(control.call, id) for _ in range(50)]

        assert {call.result() for call in calls} <= {id(session) for session in opened}
        assert [one.result() for one in again] == [None] * 3
    assert len(opened) == 4
    assert control.session is opened[-1]


def test_a_session_is_kept_if_its_closing_is_refused(start: Start) -> None:
    control = start()
    session = control.session

    with pytest.raises(WrongState, match="busy"):
        control.reopen(lambda _: raise_(WrongState("busy")))
    assert control.session is session
    assert control.alive


def test_the_previous_state_is_restored_if_the_new_session_cannot_be_opened(start: Start) -> None:
    broken: list[str] = []
    control = start(opened=lambda _: raise_(DeviceError(broken[0])) if broken else None)

    with pytest.raises(DeviceError, match="no gripper"):
        control.reopen(lambda _: broken.append("no gripper"), broken.clear)
    assert control.alive
    assert control.call(lambda session: session.resting)


def test_without_an_open_session_every_request_is_refused_with_the_reason(start: Start) -> None:
    broken: list[str] = []
    control = start(opened=lambda _: raise_(DeviceError(broken[0])) if broken else None)

    with pytest.raises(DeviceError, match="no gripper"):
        control.reopen(lambda _: broken.append("no gripper"))
    with pytest.raises(Busy, match="not running: no gripper"):
        _ = control.session
    broken.clear()
    control.reopen()

    assert control.alive


def test_a_failure_to_open_the_first_session_is_raised_by_start(tmp_path: Path) -> None:
    control = ControlThread(lambda: Session("nowhere", Options(fake=True, data=tmp_path)))

    with pytest.raises(UsageError, match="unknown scene 'nowhere'"):
        control.start()
    with pytest.raises(Busy):
        control.call(lambda session: session.scene)
    control.close()


def test_an_exception_in_a_close_listener_does_not_prevent_closing(
    start: Start, caplog: pytest.LogCaptureFixture
) -> None:
    control = start(closed=lambda _: raise_(RuntimeError("listener")))
    control.reopen()

    assert control.alive
    control.close()
    assert caplog.text.count("closing a session failed: listener") == 2


def test_close_listeners_run_in_reverse_order_even_if_one_raises(
    start: Start, caplog: pytest.LogCaptureFixture
) -> None:
    ends: list[str] = []

    def attach(session: Session) -> None:
        session.on_close(lambda: ends.append("first"), lambda: raise_(RuntimeError("second")))
        session.on_close(lambda: ends.append("third"))

    control = start(opened=attach)
    control.reopen()

    assert ends == ["third", "first"]
    assert "closing a session failed: second" in caplog.text


def test_what_a_session_has_opened_is_not_searched_for_garbage_until_it_is_closed(start: Start) -> None:
    before = gc.get_freeze_count()
    control = start()
    assert control.call(lambda _: gc.get_freeze_count()) > before + 10_000
    control.close()
    assert gc.get_freeze_count() == 0


def test_a_halt_persists_into_the_next_session(start: Start) -> None:
    control = start()
    control.call(lambda session: session.cycle.halt("somebody stood there"))
    control.reopen()

    assert control.call(lambda session: session.cycle.halted) == "somebody stood there"
    control.call(Session.reset)
    control.reopen()
    assert control.call(lambda session: session.cycle.halted) == ""


def test_a_job_running_at_the_end_of_the_server_waits_for_a_person_at_the_next_start(start: Start) -> None:
    def end_in_the_midst_of_it(session: Session) -> None:
        def look() -> None:
            if "job" in session.jobs.open and session.jobs.open["job"].attempts:
                control.close()

        session.cycle.observe(look)

    control = start()
    control.call(end_in_the_midst_of_it)
    control.call(lambda session: session.jobs.submit(JobOrder(id="job", goal=("InKit(Starter, kit_1)",))))
    wait_for(lambda: control.fault is not None)

    job = start().call(lambda session: session.jobs.job("job"))
    assert (job.state.name, job.choices) == ("INTERRUPTED", ("retry", "abort"))


def test_a_queued_job_continues_in_the_next_session_without_a_request(start: Start) -> None:
    control = start()
    control.call(lambda session: session.cycle.halt("first look"))
    control.session.jobs.submit(JobOrder(id="job", goal=("RobotAtLocation(robot_1, pallet_a)",)))
    control.reopen()
    control.call(Session.reset)

    wait_for(lambda: not control.session.jobs.job("job").state.is_open)


def test_after_closing_waiting_and_new_requests_are_refused(start: Start) -> None:
    control, go_on = start(), threading.Event()
    control.soon(lambda _: go_on.wait(30.0))
    with ThreadPoolExecutor(2) as pool:
        waiting = pool.submit(control.reopen), pool.submit(control.call, id)
        wait_for(lambda: len(control._queue._waiting) == 2)
        ending = pool.submit(threading.Thread(target=control.close).start)
        wait_for(lambda: control._ending)
        go_on.set()
        for one in waiting:
            assert one.exception() is None or isinstance(one.exception(), Busy)
        ending.result()
    control.close()

    for ask in (control.reopen, lambda: control.call(id)):
        with pytest.raises(Busy, match="not running"):
            ask()
    control.soon(lambda _: raise_(AssertionError("it is not done")))


def test_constant_requests_do_not_stop_the_cycle(start: Start) -> None:
    control, ending = start(), threading.Event()

    def ask(_session: Session) -> None:
        if not ending.is_set():
            control.soon(ask)

    for _ in range(20):
        control.soon(ask)
    before = control.beat
    wait_for(lambda: control.beat > before + 20)
    ending.set()


def test_an_exception_of_unawaited_work_is_logged(start: Start, caplog: pytest.LogCaptureFixture) -> None:
    control = start()
    control.soon(lambda _: raise_(RuntimeError("quietly")))
    control.call(lambda _: None)

    assert "failed: quietly" in caplog.text
    assert control.alive


def test_requests_beyond_the_limit_are_refused_except_urgent_ones(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PLACES", 2)
    control, held, go_on = start(), threading.Event(), threading.Event()
    control.soon(lambda _: (held.set(), go_on.wait(30)))
    assert held.wait(30)
    with ThreadPoolExecutor(3) as pool:
        waiting = [pool.submit(control.call, lambda _: "done") for _ in range(2)]
        wait_for(lambda: len(control._queue._waiting) == 2)
        with pytest.raises(Busy, match="very many"):
            control.call(lambda _: "done")
        urgent = pool.submit(control.call, lambda _: "urgent", urgent=True)
        wait_for(lambda: len(control._queue._waiting) == 3)
        go_on.set()

        assert [one.result() for one in (*waiting, urgent)] == ["done", "done", "urgent"]
    assert control.call(lambda _: "again") == "again"
