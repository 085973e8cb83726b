"""Stop, reset, alarms and answers over a real server: obeyed past everything, and nothing goes on by itself."""

import json
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import httpx2
import pytest
from support.serving import serving

from skiros_py.devices.mobile_base import BaseState
from skiros_py.errors import DeviceError, WrongState
from skiros_py.skills.context import QuestionKind
from skiros_py.station.session import Options
from skiros_py.tasks.jobs.job import JobOrder, JobState

STARTER = "InKit(Starter, kit_1)"


@pytest.fixture
def served(tmp_path):
    with serving("kitting", tmp_path) as served:
        yield served


@pytest.fixture
def http(served):
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=30) as http:
        yield http


def until(reached, patience=60.0):
    deadline = time.monotonic() + patience
    while not (value := reached()):
        assert time.monotonic() < deadline, "it was never reached"
        time.sleep(0.002)
    return value


def active(http, kind):
    return [one for one in http.get("/alarms", params={"active": True}).json()["items"] if one["kind"] == kind]


@contextmanager
def hanging(served):
    """The control thread hangs while the block runs."""
    hangs, goes_on = threading.Event(), threading.Event()

    def hang(_session):
        hangs.set()
        goes_on.wait(60)

    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(served.services.station.control.call, hang)
        assert hangs.wait(20)
        try:
            yield
        finally:
            goes_on.set()
            call.exception(20)


def halted_job(served, http, id_="kit"):
    """Orders a job, and stops everything in the midst of its first step."""
    began = threading.Event()
    session = served.services.station.session

    def listen(task):
        task.before_step(lambda _step: began.set() or session.cycle.forbid("the test stops it"))

    end = session.tasks.on_begin(listen)
    session.jobs.submit(JobOrder(id=id_, goal=(STARTER,)))
    assert began.wait(60)
    end()
    return http.post("/stop", json={"reason": "a person is in the cell"}).json()


# ---------------------------------------------------------------------- stop


def test_a_stop_halts_everything_and_records_its_author_and_reason(http):
    stopped = http.post("/stop", json={"reason": "a person is in the cell"})
    assert stopped.status_code == 200
    said = stopped.json()
    assert (said["halted"], said["obeyed"], said["standing"]) == (True, True, True)
    assert (said["why"], said["by"]) == ("a person is in the cell", "local")
    assert http.get("/stop").json() == said


def test_a_stop_takes_effect_in_the_next_cycle(served, http):
    """The cycle after the one in which it came begins with no task left."""
    session = served.services.station.session
    ticks, halts = [], []

    def work():
        while True:
            ticks.append(session.cycle.board.snapshot.cycle)
            yield

    original = session.cycle.forbid
    session.cycle.forbid = lambda why: (halts.append(session.cycle.board.snapshot.cycle), original(why))
    served.services.station.control.call(lambda _s: session.cycle.start(work(), "work"))
    until(lambda: len(ticks) > 5)
    http.post("/stop")
    assert ticks[-1] <= halts[0] + 1


def test_a_second_stop_changes_nothing(http):
    first = http.post("/stop", json={"reason": "one"}).json()
    assert http.post("/stop", json={"reason": "two"}).json() == first


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"[[[[" * 5000,
        b"\xff\xfe\x00",
        b'{"reason": 7}',
        b'{"reason": "\\ud800"}',
        b'{"reason": "\\u0000"}',
        json.dumps({"reason": "x" * 100_000}).encode(),
        b"x" * (2 << 20),
    ],
)
@pytest.mark.parametrize("type_", ["application/json", "text/plain", "no type at all"])
def test_a_stop_takes_effect_with_any_body(shared, body, type_):
    served, http = shared
    try:
        answer = http.post("/stop", content=body, headers={"Content-Type": type_})
        assert answer.status_code == 200
        assert len(answer.json()["why"]) <= 1000
        assert served.services.station.session.cycle.halted
    finally:
        http.post("/reset")


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    with (
        serving("kitting", tmp_path_factory.mktemp("data")) as served,
        httpx2.Client(base_url=f"{served.url}/api/v1", timeout=30) as http,
    ):
        yield served, http


def test_a_stop_whose_body_never_arrives_takes_effect(served, http):
    url = httpx2.URL(served.url)
    with socket.create_connection((url.host, url.port), timeout=20) as one:
        one.sendall(b"POST /api/v1/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 500\r\n\r\n{")
        assert one.recv(4096).startswith(b"HTTP/1.1 200")
    assert http.get("/stop").json()["halted"]


def test_a_stop_works_and_reports_when_the_control_thread_hangs_and_all_worker_threads_are_busy(served, http):
    http.get("/stop")
    with ThreadPoolExecutor(60) as pool, hanging(served):
        waiting = [pool.submit(http.post, "/reset") for _ in range(60)]  # each waits in a thread of the server
        until(lambda: all(one.running() for one in waiting))
        time.sleep(0.3)
        answer = http.post("/stop", json={"reason": "now"})
        assert not any(one.done() for one in waiting)
        assert answer.status_code == 202
        assert answer.json()["halted"] is True
        assert (answer.json()["obeyed"], answer.json()["standing"]) == (False, None)
        assert served.services.station.session.cycle.halted == "now"


def test_a_stop_while_the_station_reopens_applies_to_the_new_session(served, http):
    opening, go_on = threading.Event(), threading.Event()
    original = served.services.station.control._opening

    def slow():
        opening.set()
        go_on.wait(20)
        return original()

    served.services.station.control._opening = slow
    with ThreadPoolExecutor(1) as pool:
        reopened = pool.submit(served.services.station.control.reopen)
        assert opening.wait(20)
        assert http.post("/stop", json={"reason": "not now"}).json()["halted"]
        go_on.set()
        reopened.result(60)
    assert served.services.station.session.cycle.halted == "not now"
    assert http.get("/stop").json()["why"] == "not now"


def test_a_stop_while_the_station_brakes_before_reopening_holds_until_a_reset(served, http):
    """A job that is queued must not start in the new session as if nobody had pressed anything."""
    session, control = served.services.station.session, served.services.station.control
    braking, go_on = threading.Event(), threading.Event()

    def brake():
        if session.cycle.halted:
            braking.set()
            go_on.wait(20)

    control.call(lambda _: session.cycle.observe(brake))
    with ThreadPoolExecutor(1) as pool:
        reopened = pool.submit(control.reopen)
        assert braking.wait(20)
        session.jobs.submit(JobOrder(id="kit", goal=(STARTER,)))
        stopped = http.post("/stop", json={"reason": "a person is in the cell"}).json()
        assert (stopped["halted"], stopped["why"], stopped["by"]) == (True, "a person is in the cell", "local")
        go_on.set()
        reopened.result(60)
    beat = control.beat
    until(lambda: control.beat > beat + 20)
    assert served.services.station.session.jobs.job("kit").state is JobState.ALLOWED_TO_START
    assert http.get("/stop").json() | {"standing": None, "obeyed": None} == stopped | {"standing": None, "obeyed": None}
    assert http.post("/reset").status_code == 200
    until(lambda: served.services.station.session.jobs.job("kit").state is JobState.ENDED)


def test_a_reopened_station_reports_no_author_of_a_halt(served, http):
    served.services.station.control.reopen()
    assert http.get("/stop").json()["halted"] is False
    assert [one["type"] for one in http.get("/events/recent").json()["items"] if one["kind"] == "alarm"] == []
    assert "halted" not in [one["type"] for one in http.get("/events/recent").json()["items"]]


# ---------------------------------------------------------------------- reset


def test_a_reset_allows_starts_again_and_is_published(served, http):
    http.post("/stop")
    assert http.post("/reset").json()["halted"] is False
    types = [one["type"] for one in http.get("/events/recent", params={"kind": "system"}).json()["items"]]
    assert types[-2:] == ["halted", "reset"]
    again = http.post("/stop", json={"reason": "again"}).json()
    assert (again["why"], again["by"]) == ("again", "local")


def test_a_reset_without_a_halt_changes_nothing(http):
    answer = http.post("/reset")
    assert (answer.status_code, answer.json()["halted"]) == (200, False)


def test_a_halted_job_is_held_and_continues_after_a_reset_and_an_answer(served, http):
    stopped = halted_job(served, http)
    assert stopped["halted"]
    until(lambda: served.services.station.session.jobs.job("kit").state is JobState.INTERRUPTED)
    (alarm,) = until(lambda: active(http, "job"))
    assert (alarm["job"], alarm["severity"], alarm["choices"]) == ("kit", "high", ["retry", "abort"])
    (halt,) = active(http, "halted")
    early = http.post(f"/alarms/{alarm['id']}/answer", json={"answer": "retry"})
    assert (early.status_code, early.json()["code"]) == (409, "WrongState")
    assert http.post("/reset").status_code == 200
    assert http.post(f"/alarms/{alarm['id']}/answer", json={"answer": "retry"}).status_code == 200
    until(lambda: served.services.station.session.jobs.job("kit").state is JobState.ENDED)
    assert http.get(f"/alarms/{alarm['id']}").json()["state"] == "normal"
    assert http.get(f"/alarms/{halt['id']}").json()["state"] == "returned"
    assert http.get("/alarms", params={"active": True}).json()["items"] == []


# ---------------------------------------------------------------------- alarms


def test_a_question_of_a_robot_is_an_alarm_that_can_be_answered(served, http):
    session = served.services.station.session

    def ask(_session):
        return session.questions.ask(QuestionKind.REFILL, "bring starters", ("done", "skip"), asker="pick", time=1.0)

    asked = served.services.station.control.call(ask)
    (alarm,) = until(lambda: active(http, "question"))
    assert (alarm["text"], alarm["choices"], alarm["question"]) == ("bring starters", ["done", "skip"], 1)
    wrong = http.post(f"/alarms/{alarm['id']}/answer", json={"answer": "perhaps"})
    assert wrong.status_code == 422
    assert "done, skip" in wrong.json()["detail"]
    assert http.post(f"/alarms/{alarm['id']}/answer", json={"answer": "done"}).status_code == 200
    assert (asked.answer, asked.by) == ("done", "local")
    until(lambda: not active(http, "question"))
    late = http.post(f"/alarms/{alarm['id']}/answer", json={"answer": "done"})
    assert late.status_code == 409


def test_a_broken_module_is_an_alarm_until_it_is_acknowledged(served, http):
    from skiros_py.execution.monitor import ModuleEvent, Status

    event = ModuleEvent(0.0, "primitive", "grasp", Status.ERROR, -3, "it broke: KeyError", agent="arm_1")
    served.services.station.control.call(lambda session: session.monitor.publish(event))
    (alarm,) = active(http, "module")
    assert alarm["text"] == "grasp of arm_1 is broken: it broke: KeyError"
    acknowledged = http.post(f"/alarms/{alarm['id']}/acknowledge").json()
    assert (acknowledged["active"], acknowledged["by"]) == (False, "local")
    assert active(http, "module") == []


def test_a_lost_manager_is_an_alarm_until_it_is_replaced(served, http):
    def lose(session):
        session.managers["arm_1"].lose("its process is gone")

    served.services.station.control.call(lose)
    (alarm,) = until(lambda: active(http, "manager"))
    assert (alarm["source"], alarm["text"]) == ("arm_1", "the skill manager of arm_1 is lost: its process is gone")
    served.services.station.control.call(lambda session: session.managers.open("arm_1"))
    until(lambda: not active(http, "manager"))


def test_a_broken_control_cycle_is_an_alarm_until_the_station_is_reopened(served, http):
    def breaks():
        raise RuntimeError("the driver is gone")

    served.services.station.control.call(lambda session: session.cycle.observe(breaks))
    (alarm,) = until(lambda: active(http, "station"))
    assert "the driver is gone" in alarm["text"]
    assert alarm["severity"] == "critical"
    served.services.station.control.reopen()
    assert active(http, "station") == []


def test_a_reset_opens_the_station_again_after_a_fault_of_a_device(served, http):
    def breaks():
        raise DeviceError("arm_1: no answer")

    control = served.services.station.control
    control.call(lambda session: session.cycle.observe(breaks))
    until(lambda: active(http, "station"))
    assert http.get("/robots").status_code == 503

    answer = http.post("/reset")

    assert (answer.status_code, answer.json()["halted"]) == (200, False)
    assert http.get("/robots").status_code == 200
    assert active(http, "station") == []


def test_a_reset_says_why_the_station_cannot_be_opened_again(served, http, monkeypatch):
    control = served.services.station.control
    opening = control._opening

    def breaks():
        raise DeviceError("arm_1: no answer")

    control.call(lambda session: session.cycle.observe(breaks))
    until(lambda: active(http, "station"))
    monkeypatch.setattr(control, "_opening", breaks)

    refused = http.post("/reset")
    monkeypatch.setattr(control, "_opening", opening)

    assert refused.status_code == 409
    assert refused.json()["detail"] == "the station cannot be opened again: arm_1: no answer"
    assert http.post("/reset").status_code == 200


def test_each_page_of_alarms_continues_where_the_previous_one_ended(served, http):
    from skiros_py.api.alarms import AlarmKind

    for n in range(25):
        served.services.station.alarms.raise_(AlarmKind.WEBHOOK, f"message {n}", str(n))
    texts, cursor = [], None
    while True:
        page = http.get("/alarms", params={"limit": 10} | ({"cursor": cursor} if cursor else {})).json()
        texts += [one["text"] for one in page["items"]]
        cursor = page["next"]
        if cursor is None:
            break
    assert texts == [f"message {n}" for n in range(25)]


@pytest.mark.parametrize("path", ["/alarms/never", "/alarms/%00", "/alarms/..%2f"])
def test_an_unknown_alarm_is_answered_with_404(http, path):
    assert http.get(path).status_code in (400, 404)


# ---------------------------------------------------------------------- with physics


@pytest.mark.physics
def test_moving_arms_and_bases_stand_still_after_a_stop(tmp_path):
    with serving("kitting", tmp_path, Options()) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        session = served.services.station.session
        board = session.cycle.board
        session.jobs.submit(JobOrder(id="kit", goal=(STARTER,)))
        until(lambda: not board.still)
        cycle = board.snapshot.cycle
        answer = http.post("/stop", json={"reason": "a person is in the cell"})
        assert (answer.status_code, answer.json()["obeyed"]) == (200, True)
        until(lambda: http.get("/stop").json()["standing"])
        until(lambda: session.jobs.job("kit").state is JobState.INTERRUPTED)
        before = board.snapshot
        until(lambda: board.snapshot.cycle > max(cycle, before.cycle) + 200)
        assert board.still
        assert board.snapshot.state("base_1", BaseState).pose.position == pytest.approx(
            before.state("base_1", BaseState).pose.position, abs=0.02
        )
        assert http.post("/reset").status_code == 200
        assert session.jobs.job("kit").state is JobState.INTERRUPTED  # nothing goes on by itself

        session.jobs.answer("kit", "retry", by="anna")
        until(lambda: not board.still)

        def reset_at_once(_session):
            session.cycle.forbid("while it moves")
            served.services.station.stops.reset("anna")

        with pytest.raises(WrongState, match="not yet"):
            served.services.station.control.call(reset_at_once)


@pytest.mark.physics
def test_a_stop_while_robots_and_bodies_are_being_loaded_holds_until_a_reset(tmp_path):
    with serving("kitting", tmp_path, Options()) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        control = served.services.station.control
        http.get("/stop")
        with ThreadPoolExecutor(1) as pool:
            reopened = pool.submit(control.reopen)
            until(lambda: control.opening)
            stopped = http.post("/stop", json={"reason": "not now"}).json()
            assert control.opening  # it takes seconds to start libraries and physics
            assert (stopped["halted"], stopped["obeyed"], stopped["why"]) == (True, True, "not now")
            reopened.result(120)
        said = http.get("/stop").json()
        assert (said["halted"], said["why"], said["by"]) == (True, "not now", "local")
        assert served.services.station.session.cycle.halted == "not now"
        served.services.station.session.jobs.submit(JobOrder(id="kit", goal=(STARTER,)))
        beat = control.beat
        until(lambda: control.beat > beat + 20)
        assert served.services.station.session.jobs.job("kit").state is JobState.ALLOWED_TO_START
        assert http.post("/reset").json()["halted"] is False
        until(lambda: served.services.station.session.jobs.job("kit").state is JobState.RUNNING)
