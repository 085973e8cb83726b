"""Cases 3 and 6: ended at bad moments, and a world that changes behind the plan."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.tasks.jobs.job import JobState
from skiros_py.world.change import Writer
from skiros_py.world.world import World

from .hard import (
    ANYHOW,
    HOLDS,
    SLOWLY,
    STARTER,
    HeldPlanner,
    api_of,
    begin_anew,
    cycles,
    freeze_planner,
    gone,
    happened,
    job_of,
    moves,
    over,
    steps,
    until,
)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data"), SLOWLY) as served:
        yield served


@pytest.fixture
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        begin_anew(api)
        yield api


@pytest.fixture(scope="module")
def planner(tmp_path_factory: pytest.TempPathFactory) -> HeldPlanner:
    return HeldPlanner(tmp_path_factory.mktemp("planner"))


@pytest.fixture(scope="module")
def planned(planner: HeldPlanner, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    options = replace(SLOWLY, planner_command=planner.command)
    with serving("kitting", tmp_path_factory.mktemp("data"), options) as served:
        yield served


@pytest.fixture
def held(planner: HeldPlanner, planned: Served) -> Iterator[httpx2.Client]:
    """The API of a station whose planner does not answer."""
    with api_of(planned) as api:
        begin_anew(api)
        planner.hold()
        yield api
        planner.let_go()


def order(api: httpx2.Client, id_: str = "kit", **more: object) -> None:
    api.put(f"/jobs/{id_}", json={**STARTER, **more}).raise_for_status()


def ends(api: httpx2.Client, id_: str) -> list[str]:
    """Returns the states in which a job ended: one, if all is right."""
    told = api.get(f"/jobs/{id_}/transitions").json()["items"]
    return [text for one in told if (text := one["state"]["text"]) in ("Ended", "Aborted")]


# ------------------------------------------------------------------ case 3: ended at bad moments


@pytest.mark.parametrize("command", ["stop", "abort"])
def test_a_job_ended_during_planning_ends_once_and_kills_all_planner_processes(
    held: httpx2.Client, planner: HeldPlanner, command: str
) -> None:
    order(held)
    until(lambda: len(planner.processes) == 2)

    answers = [held.post(f"/jobs/kit/{command}", json={"comment": "enough"}) for _ in range(2)]

    assert [answer.status_code for answer in answers] == [200, 200]
    job = over(held, "kit")
    assert job["state"]["text"] == ("Ended" if command == "stop" else "Aborted")
    assert ends(held, "kit") == [job["state"]["text"]]
    until(lambda: not planner.processes)
    assert steps(held, "kit") == []
    assert held.put("/jobs/next", json=HOLDS, headers={"Prefer": "wait=30"}).json()["outcome"]


def test_aborting_a_job_kills_a_frozen_fast_downward_with_its_process_group(served: Served, api: httpx2.Client) -> None:
    with ThreadPoolExecutor(1) as pool:
        freezing = pool.submit(freeze_planner, os.getpid())
        for id_ in map("kit-{}".format, range(100)):  # a plan takes so little time that it may be missed
            order(api, id_)
            until(lambda id_=id_: freezing.done() or moves(api, id_))
            if freezing.done():
                break
            api.post(f"/jobs/{id_}/abort").raise_for_status()
            over(api, id_)
        planner = freezing.result()
    assert job_of(api, id_)["state"]["substates"] == ["Planning"]

    api.post(f"/jobs/{id_}/abort").raise_for_status()

    assert over(api, id_)["outcome"] == "aborted"
    until(lambda: gone(planner))
    order(api, "next")
    until(lambda: moves(api, "next"))


def test_a_stop_during_planning_holds_the_job_and_no_plan_starts_afterwards(
    held: httpx2.Client, planner: HeldPlanner
) -> None:
    order(held)
    until(lambda: planner.processes)

    held.post("/stop", json={"reason": "a person is in the cell"}).raise_for_status()
    planner.let_go()

    until(lambda: job_of(held, "kit")["state"]["substates"] == ["Held"])
    until(lambda: not planner.processes)
    cycles(held)
    assert steps(held, "kit") == []


def test_a_job_ended_by_many_callers_during_a_motion_ends_once_and_the_robot_stands(
    served: Served, api: httpx2.Client
) -> None:
    order(api)
    until(lambda: moves(api, "kit"))

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda n: api.post(f"/jobs/kit/{'stop' if n % 2 else 'abort'}"), range(16)))

    assert {answer.status_code for answer in answers} <= {200, 409}
    job = over(api, "kit")
    assert ends(api, "kit") == [job["state"]["text"]]
    until(lambda: not moves(api, "kit"))
    pose = api.get("/state").json()["platforms"]["base_1"]
    cycles(api)
    assert api.get("/state").json()["platforms"]["base_1"] == pose


def test_a_stop_at_the_moment_of_completion_leaves_exactly_one_correct_outcome(
    served: Served, api: httpx2.Client
) -> None:
    jobs = served.services.station.session.jobs
    for number in range(12):
        id_, running = f"race-{number}", threading.Event()
        end = jobs.subscribe(lambda job, seen=running: job.state is JobState.RUNNING and seen.set())
        api.put(f"/jobs/{id_}", json=HOLDS).raise_for_status()
        assert running.wait(30)
        answer = api.post(f"/jobs/{id_}/{'stop' if number % 2 else 'abort'}")
        end()
        job = over(api, id_)
        assert answer.status_code in (200, 409)
        assert ends(api, id_) == [job["state"]["text"]]
        assert job["outcome"] in ("goal already satisfied", "stopped", "aborted")


# ------------------------------------------------------------------ case 6: the world changes behind the plan


def test_a_part_removed_during_the_plan_ends_the_job_cleanly(api: httpx2.Client) -> None:
    order(api)
    until(lambda: moves(api, "kit"))

    assert api.delete("/elements/starter_1", headers=ANYHOW).status_code in (200, 204)

    job = over(api, "kit")
    assert job["outcome"] in ("no plan", "failed")
    assert "there is no Starter" in job["conditions"][0]["reason"]
    assert "place" not in steps(api, "kit")


def test_a_part_moved_during_the_plan_is_fetched_from_its_new_place(api: httpx2.Client) -> None:
    order(api)
    until(lambda: moves(api, "kit"))

    moved = {"placement": {"relation": "sk:in", "place": "pallet_b"}}
    api.patch("/elements/starter_1", json=moved, headers=ANYHOW).raise_for_status()

    assert over(api, "kit")["outcome"] == "succeeded"
    assert happened(api, "kit").count("planned") == 2
    (actual,) = api.get("/jobs/kit/response").json()["material_actuals"]
    assert actual["place"].startswith("kit_1_")


def test_a_compartment_filled_during_the_plan_is_left_alone(api: httpx2.Client) -> None:
    order(api)
    until(lambda: moves(api, "kit"))
    wanted = api.get("/jobs/kit/plan").json()["items"][-1]["arguments"]["Compartment"]

    there = {"placement": {"relation": "sk:in", "place": wanted}}
    api.patch("/elements/relay_box_1", json=there, headers=ANYHOW).raise_for_status()

    assert over(api, "kit")["outcome"] == "succeeded"
    place = api.get("/elements/starter_1").json()["placement"]["place"]
    assert place.startswith("kit_1_")
    assert place != wanted


def test_a_job_in_a_constantly_changing_world_ends_after_a_bounded_number_of_plans(
    served: Served, api: httpx2.Client
) -> None:
    session = served.services.station.session
    end = session.tasks.on_begin(lambda task: task.before_step(lambda _: move_away(session.world)) and None)

    order(api)

    job = over(api, "kit")
    end()
    assert job["outcome"] in ("failed", "no plan")
    assert job["conditions"][0]["reason"]
    assert happened(api, "kit").count("planned") < 60


def move_away(world: World) -> None:
    """Puts the part where it is not expected."""
    there, places = world.placement("starter_1").place, ["pallet_a", "pallet_b"]
    if there in places:
        with world.transaction("anna", "teases the robot", writer=Writer.PERSON) as tx:
            tx.place("starter_1", "sk:in", places[1 - places.index(there)])
