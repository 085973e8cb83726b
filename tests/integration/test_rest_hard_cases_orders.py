"""Cases 1, 4, 16 and 20: orders again and again, goals that lead nowhere, many orders, and clocks that jump."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.tasks.jobs.job import JobOrder
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.world.change import Writer

from .hard import HOLDS, LATER, SLOWLY, STARTER, api_of, begin_anew, cycles, happened, job_of, moves, over, steps, until

ALTERNATOR = {"goal": "InKit(Alternator, kit_1)"}


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data"), SLOWLY) as served:
        yield served


@pytest.fixture
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        begin_anew(api)
        yield api


# ------------------------------------------------------------------ case 1: the same order again and again


def test_fifty_repeats_and_fifty_other_orders_at_once_leave_a_running_job_undisturbed(api: httpx2.Client) -> None:
    begun = api.put("/jobs/kit", json=STARTER)
    assert begun.status_code == 202
    until(lambda: moves(api, "kit"))

    def put(number: int) -> httpx2.Response:
        return api.put("/jobs/kit", json=STARTER if number % 2 else {**STARTER, "priority": number + 1})

    with ThreadPoolExecutor(16) as pool:
        answers = list(pool.map(put, range(100)))

    assert {answer.status_code for answer in answers[1::2]} == {200}
    assert {answer.json()["number"] for answer in answers[1::2]} == {begun.json()["number"]}
    assert {(answer.status_code, answer.json()["code"]) for answer in answers[::2]} <= {
        (409, "UnableToAcceptJobOrder"),
        (409, "InvalidJobOrderStatus"),
    }
    assert over(api, "kit")["outcome"] == "succeeded"
    assert steps(api, "kit") == ["drive", "pick", "drive", "place"]
    assert happened(api, "kit").count("planned") == 1
    assert len(api.get("/jobs").json()["items"]) == 1


def test_fifty_different_orders_under_one_id_at_once_make_one_job_and_the_others_are_refused(
    api: httpx2.Client,
) -> None:
    def put(number: int) -> httpx2.Response:
        return api.put("/jobs/one", json={**HOLDS, **LATER, "priority": number})

    with ThreadPoolExecutor(16) as pool:
        answers = list(pool.map(put, range(50)))

    taken = [answer for answer in answers if answer.status_code == 202]
    assert len(taken) == 1
    assert {answer.status_code for answer in answers} == {202, 409}
    assert job_of(api, "one")["order"]["priority"] == taken[0].json()["order"]["priority"]


def test_fifty_different_orders_under_one_idempotency_key_at_once_are_one_job(api: httpx2.Client) -> None:
    def post(number: int) -> httpx2.Response:
        order = {**HOLDS, **LATER, "priority": number}
        return api.post("/jobs", json=order, headers={"Idempotency-Key": "one-for-all"})

    with ThreadPoolExecutor(16) as pool:
        answers = list(pool.map(post, range(50)))

    assert sorted({answer.status_code for answer in answers}) == [202, 422]
    assert [answer.status_code for answer in answers].count(202) == 1
    assert len(api.get("/jobs").json()["items"]) == 1


# ------------------------------------------------------------------ case 4: goals that lead nowhere


HOPELESS = "InKit(Starter, kit_1) and LocationEmpty(kit_1_a) and LocationEmpty(kit_1_b) and LocationEmpty(kit_1_c)"


@pytest.mark.parametrize(
    ("goal", "outcome"),
    [
        ("EmptyHanded(gripper_1)", "goal already satisfied"),
        (f"{HOPELESS} and LocationEmpty(kit_1_d)", "no plan"),
        ("LocationEmpty(kit_1_a) and not LocationEmpty(kit_1_a)", "no plan"),
        ("Holding(gripper_1, starter_1) and Holding(gripper_1, alternator_1)", "no plan"),
    ],
)
def test_goals_that_already_hold_and_unreachable_goals_have_distinct_outcomes(
    api: httpx2.Client, goal: str, outcome: str
) -> None:
    answer = api.put("/jobs/goal", json={"goal": goal})
    assert answer.status_code == 202, answer.text
    job = over(api, "goal")
    assert (job["outcome"], bool(job["reasons"])) == (outcome, outcome == "no plan")
    assert steps(api, "goal") == []


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        ("InKit(Starter, kit_7)", "UnknownName"),
        ("InKit(Rocket, kit_1)", "UnknownName"),
        ("Flies(Starter)", "UnknownName"),
        ("InKit(Starter, kit_1", "GoalSyntax"),
        ("InKit(kit_1, Starter)", "UnknownName"),
        ("InKit(Starter)", "GoalSyntax"),
    ],
)
def test_a_goal_with_unknown_names_is_refused_and_makes_no_job(api: httpx2.Client, goal: str, code: str) -> None:
    refused = api.put("/jobs/goal", json={"goal": goal})
    assert refused.status_code == 422, refused.text
    assert refused.json()["code"] in (code, "InvalidRequest")
    assert api.get("/jobs/goal").status_code == 404


BROKEN_PLANNERS = {
    "dies": ("import os; os.abort()", "failed"),
    "leaves garbage": ("import sys; open(sys.argv[3], 'w').write('(fly to the moon)\\n')", "failed"),
    "leaves nothing": ("pass", "failed"),
    "takes all memory": ("x = ' ' * (1 << 40)", "failed"),
}


def test_a_planner_that_crashes_or_answers_garbage_fails_the_job_and_the_next_job_runs(
    tmp_path: Path,
) -> None:
    script = tmp_path / "planner.py"
    options = replace(SLOWLY, planner_command=f"{sys.executable} -S {script} {{domain}} {{problem}} {{plan}}")
    script.write_text("")
    with serving("kitting", tmp_path / "data", options) as served, api_of(served) as api:
        told = {}
        for name, (text, outcome) in BROKEN_PLANNERS.items():
            script.write_text(text)
            id_ = name.replace(" ", "-")
            api.put(f"/jobs/{id_}", json=STARTER).raise_for_status()
            job = over(api, id_)
            assert (job["outcome"], job["state"]["text"]) == (outcome, "Aborted"), job
            told[name] = " ".join((job["detail"], *job["reasons"]))
            assert "Traceback" not in told[name]
        assert all(told.values())
        assert len(set(told.values())) == len(told)  # each is told apart


# ------------------------------------------------------------------ case 16: two jobs that want one robot


def test_two_jobs_that_need_the_same_robot_run_one_after_the_other(api: httpx2.Client) -> None:
    api.put("/jobs/first", json=STARTER).raise_for_status()
    api.put("/jobs/second", json=ALTERNATOR).raise_for_status()
    until(lambda: moves(api, "first"))
    waiting = job_of(api, "second")

    first, second = over(api, "first"), over(api, "second")

    assert waiting["state"]["text"] == "AllowedToStart"
    assert waiting["detail"]
    assert (first["outcome"], second["outcome"]) == ("succeeded", "succeeded")
    assert first["ended"] <= second["started"]


def test_an_aborted_job_releases_its_robot_to_the_next_job(api: httpx2.Client) -> None:
    api.put("/jobs/first", json=STARTER).raise_for_status()
    api.put("/jobs/second", json=ALTERNATOR).raise_for_status()
    until(lambda: moves(api, "first"))

    api.post("/jobs/first/abort").raise_for_status()

    assert over(api, "second")["outcome"] == "succeeded"
    assert over(api, "first")["outcome"] == "aborted"


def test_jogging_a_robot_used_by_a_job_is_refused_and_the_job_continues(api: httpx2.Client) -> None:
    api.put("/jobs/kit", json=STARTER).raise_for_status()
    until(lambda: moves(api, "kit"))

    refused = api.post("/devices/arm_1/jog", json={"module": "home"})

    assert refused.status_code == 409, refused.text
    assert over(api, "kit")["outcome"] == "succeeded"


# ------------------------------------------------------------------ case 20: many orders, and clocks that jump


def test_an_urgent_job_is_done_despite_ten_thousand_queued_jobs(tmp_path: Path) -> None:
    with serving("kitting", tmp_path / "data", SLOWLY) as served, api_of(served) as api:
        jobs = served.services.station.session.jobs
        ordered = [JobOrder(id=f"q-{n}", goal=(HOLDS["goal"],), not_before=4e9) for n in range(10_000)]
        with ThreadPoolExecutor(16) as pool:
            list(pool.map(jobs.submit, ordered))
        api.put("/jobs/urgent", json={**STARTER, "priority": 9}).raise_for_status()
        assert over(api, "urgent")["outcome"] == "succeeded"
        assert len(api.get("/jobs", params={"limit": 1000, "cursor": "9000"}).json()["items"]) == 1000
        assert job_of(api, "q-9999")["state"]["text"] == "AllowedToStart"


def iso(seconds: float) -> str:
    return (datetime.now(UTC) + timedelta(seconds=seconds)).isoformat()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """By how much the wall clock is wrong [s]; the monotonic one goes on."""
    real, wrong = time.time, [0.0]
    monkeypatch.setattr(time, "time", lambda: real() + wrong[0])
    assert JobManager.__init__.__kwdefaults__["clock"] is real
    monkeypatch.setitem(JobManager.__init__.__kwdefaults__, "clock", time.time)
    return wrong


def test_a_wall_clock_that_jumps_by_an_hour_neither_stops_nor_repeats_jobs(clock: list[float], tmp_path: Path) -> None:
    with serving("kitting", tmp_path / "data", SLOWLY) as served, api_of(served) as api:
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: moves(api, "kit"))
        clock[0] = -3600.0
        assert over(api, "kit")["outcome"] == "succeeded"
        with served.services.station.session.world.transaction("anna", "edits", writer=Writer.PERSON) as tx:
            tx.set("rack_1", "rdfs:label", "earlier")
        assert api.post("/locks", json={"elements": ["kit_1"], "seconds": 60}).status_code == 201
        api.put("/jobs/in-30-min", json={**ALTERNATOR, "not_before": iso(1800 - 3600)}).raise_for_status()
        cycles(api)
        assert job_of(api, "in-30-min")["state"]["substates"] == ["Waiting"]
        clock[0] = 0.0
        assert over(api, "in-30-min")["outcome"] == "succeeded"
        assert steps(api, "in-30-min").count("pick") == 1
        assert [lock["element"] for lock in api.get("/locks").json()["items"]]  # it lasts by the clock that never jumps
        again = api.put("/jobs/kit", json=STARTER)
        assert (again.status_code, again.json()["outcome"]) == (200, "succeeded")


def test_an_order_with_times_in_another_time_zone_is_the_same_order(api: httpx2.Client) -> None:
    first = api.put("/jobs/zone", json={**HOLDS, "not_before": "2100-01-01T00:00:00Z"})
    again = api.put("/jobs/zone", json={**HOLDS, "not_before": "2100-01-01T05:30:00+05:30"})
    naive = api.put("/jobs/naive", json={**HOLDS, "not_before": "2100-01-01T00:00:00"})
    assert again.json() == first.json()
    assert naive.status_code == 422
