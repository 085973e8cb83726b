from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.tasks import InsertStep, NewSequence, NewTask, RunSequence, SequenceInfo, TaskInfo, WantedStep
from skiros_py.client.calls import sequences as seq
from skiros_py.client.calls import tasks as calls
from skiros_py.client.request import Call

TO_PALLET = WantedStep(skill="drive", arguments={"Location": "pallet_a"})
TO_KIT = WantedStep(skill="drive", arguments={"Location": "kit_1"})


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=40.0) as client:
        yield client


def sent(api: httpx2.Client, call: Call[Any]) -> httpx2.Response:
    query = {key: value for key, value in call.query.items() if value is not None}
    return api.request(call.method, call.path, json=call.json, params=query, headers=dict(call.headers))


def done(api: httpx2.Client, call: Call[Any]) -> Any:
    response = sent(api, call)
    assert response.is_success, response.text
    return call.result(response)


def until(api: httpx2.Client, name: str, *statuses: str) -> TaskInfo:
    deadline = time.monotonic() + 20.0
    while True:
        task: TaskInfo = done(api, calls.get_task(name))
        if task.status in statuses or time.monotonic() > deadline:
            assert task.status in statuses, task
            return task
        time.sleep(0.01)


def skills(sequence: SequenceInfo) -> list[str]:
    return [step.arguments.get("Location", step.skill) for step in sequence.steps]


# ---------------------------------------------------------------------- tasks


def test_a_goal_is_pursued_and_kept_with_plan_order_steps_and_report(api) -> None:
    response = api.post("/tasks", json={"goal": ["InKit(Starter, kit_1)"]})
    assert response.status_code == 202
    task = until(api, response.json()["name"], "ended")
    trace = done(api, calls.get_task_trace(task.name))

    assert response.headers["location"] == f"/api/v1/tasks/{task.name.replace(' ', '%20')}"
    assert [step.skill for step in task.plan] == ["drive", "pick", "drive", "place"]
    assert [step.after for step in task.plan] == [(), (0,), (1,), (2,)]
    assert [step.skill for step in task.steps] == [step.skill for step in task.plan]
    assert all(step.ended == "ended" and step.end is not None for step in task.steps)
    assert task.report is not None
    assert (task.report.outcome, task.report.reached) == ("reached", True)
    assert [trace.entries[0]["what"], trace.entries[-1]["what"]] == ["begun", "finished"]
    assert done(api, calls.list_tasks(active=False)).items[0].name == task.name


def test_a_goal_that_nobody_understands_begins_nothing(api) -> None:
    before = done(api, calls.list_tasks())

    for goal in (["InKit(Starter"], ["Nonsense(kit_1)"], ["InKit(Nothing, kit_1)"]):
        assert api.post("/tasks", json={"goal": goal}).status_code == 422

    assert done(api, calls.list_tasks()) == before


def test_the_task_of_a_job_is_there_by_its_id_and_is_commanded_through_the_job(api) -> None:
    api.put("/jobs/kit-1", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
    deadline = time.monotonic() + 20.0
    while api.get("/tasks/kit-1").status_code == 404 and time.monotonic() < deadline:
        time.sleep(0.005)
    refused = api.post("/tasks/kit-1/pause")
    task = until(api, "kit-1", "ended")

    assert (task.job, task.by) == ("kit-1", "")
    assert refused.status_code == 409


def test_a_task_is_paused_goes_on_step_by_step_and_ends_when_it_is_stopped(api) -> None:
    task = done(api, calls.begin_task(NewTask(steps=[TO_PALLET, TO_KIT], iterate=None)))
    done(api, calls.command_task(task.name, "pause"))
    paused = until(api, task.name, "paused")
    done(api, calls.command_task(task.name, "step"))
    done(api, calls.command_task(task.name, "stop"))
    stopped = until(api, task.name, "ended")

    assert paused.report is None
    assert stopped.report is not None
    assert stopped.report.outcome == "stopped"
    assert done(api, calls.command_task(task.name, "stop")) == stopped
    assert sent(api, calls.command_task(task.name, "resume")).status_code == 409


def test_what_is_unknown_is_not_found_and_unknown_commands_are_refused(api) -> None:
    assert api.get("/tasks/nix").status_code == 404
    assert api.get("/tasks/nix/trace").status_code == 404
    assert api.post("/tasks/nix/pause").status_code == 404
    assert api.post("/tasks/nix/dance").status_code == 422
    assert api.post("/tasks", json={}).status_code == 422
    assert api.post("/tasks", json={"goal": ["x"], "steps": []}).status_code == 422


# ---------------------------------------------------------------------- sequences


def test_each_edit_answers_all_steps_checked_as_those_before_leave_the_world(api) -> None:
    made = done(api, seq.create_sequence(NewSequence(id="round", title="One round", steps=[TO_PALLET])))
    pick = InsertStep(skill="pick", arguments={"Object": "alternator_1"})
    picked = done(api, seq.insert_step("round", made.version, pick))
    first = done(api, seq.insert_step("round", picked.version, InsertStep(**TO_KIT.model_dump(), at=1)))
    away = done(api, seq.move_step("round", first.version, 1, 0))
    other = done(api, seq.change_step("round", away.version, 0, TO_PALLET))
    without = done(api, seq.remove_step("round", other.version, 0))

    assert (made.works, picked.works) == (True, True)
    assert skills(first) == ["pallet_a", "kit_1", "pick"]
    assert [step.works for step in first.steps] == [True, True, False]
    assert first.steps[2].problems
    assert skills(away) == ["kit_1", "pallet_a", "pick"]
    assert away.works
    assert skills(other) == ["pallet_a", "pallet_a", "pick"]
    assert skills(without) == ["pallet_a", "pick"]
    assert done(api, seq.get_sequence("round")) == without
    assert {one.id: one.count for one in done(api, seq.list_sequences()).items}["round"] == 2


def test_nobody_edits_what_they_have_not_seen(api) -> None:
    made = done(api, seq.create_sequence(NewSequence(steps=[TO_PALLET])))
    done(api, seq.insert_step(made.id, made.version, InsertStep(**TO_KIT.model_dump(), at=None)))

    stale = sent(api, seq.remove_step(made.id, made.version, 0))
    blind = api.delete(f"/sequences/{made.id}")

    assert (stale.status_code, blind.status_code) == (412, 428)
    assert len(done(api, seq.get_sequence(made.id)).steps) == 2


def test_wrong_steps_and_places_are_refused_and_nothing_changes(api) -> None:
    made = done(api, seq.create_sequence(NewSequence(id="a", steps=[TO_PALLET])))
    refusals = {
        422: [
            seq.insert_step("a", made.version, InsertStep(skill="fly", at=None)),
            seq.insert_step("a", made.version, InsertStep(skill="drive", arguments={"Location": "nix"}, at=None)),
            seq.insert_step("a", made.version, InsertStep(**TO_KIT.model_dump(), at=7)),
            seq.move_step("a", made.version, 0, 5),
        ],
        404: [seq.remove_step("a", made.version, 3), seq.remove_step("nix", made.version, 0)],
        409: [seq.create_sequence(NewSequence(id="a"))],
    }

    for status, wrong in refusals.items():
        assert [sent(api, call).status_code for call in wrong] == [status] * len(wrong)

    assert done(api, seq.get_sequence("a")) == made


def test_a_sequence_is_made_of_a_plan_and_run_so_often_as_wanted(api) -> None:
    until(api, api.post("/tasks", json={"goal": ["RobotAtLocation(robot_1, kit_1)"]}).json()["name"], "ended")
    made = done(api, seq.create_sequence(NewSequence(goal=["RobotAtLocation(robot_1, pallet_a)"])))
    made = done(api, seq.insert_step(made.id, made.version, InsertStep(**TO_KIT.model_dump(), at=None)))

    begun = done(api, seq.run_sequence(made.id, RunSequence(iterate=3)))
    ended = until(api, begun.name, "ended")

    assert skills(made) == ["pallet_a", "kit_1"]
    assert ended.report is not None
    assert ended.report.fault == ""
    assert [step.arguments["Location"] for step in ended.steps] == ["pallet_a", "kit_1"] * 3
    again = done(api, seq.create_sequence(NewSequence(task=ended.name)))
    assert [step.skill for step in again.steps] == ["drive", "drive"]


def test_a_sequence_is_made_of_the_kept_plan_of_a_job_whose_task_is_forgotten(tmp_path) -> None:
    goal = {"goal": "InKit(Starter, kit_1)"}
    with serving("kitting", tmp_path) as first, httpx2.Client(base_url=f"{first.url}/api/v1", timeout=60.0) as http:
        http.put("/jobs/kept", json=goal, headers={"Prefer": "wait=30"}).raise_for_status()
        fresh = http.post("/sequences", json={"job": "kept"}).raise_for_status().json()
    with serving("kitting", tmp_path) as second, httpx2.Client(base_url=f"{second.url}/api/v1", timeout=60.0) as http:
        assert http.get("/tasks/kept").status_code == 404
        kept = http.post("/sequences", json={"job": "kept"}).raise_for_status().json()
        http.put("/jobs/later", json=goal, params={"start": "false"}).raise_for_status()
        refused = http.post("/sequences", json={"job": "later"})
        unknown = http.post("/sequences", json={"job": "never"})

    assert [step["skill"] for step in kept["steps"]] == ["drive", "pick", "drive", "place"]
    assert [step["arguments"] for step in kept["steps"]] == [step["arguments"] for step in fresh["steps"]]
    assert (refused.status_code, refused.json()["detail"]) == (409, "job 'later' has no plan")
    assert unknown.status_code == 422


def test_there_is_no_sequence_of_a_goal_that_has_no_plan(api) -> None:
    before = done(api, seq.list_sequences())

    response = api.post("/sequences", json={"goal": ["InKit(Starter, kit_1)", "not InKit(Starter, kit_1)"]})

    assert (response.status_code, response.json()["code"]) == (409, "NoPlan")
    assert response.json()["reasons"]
    assert done(api, seq.list_sequences()) == before


def test_what_cannot_work_is_run_only_where_somebody_wants_it_anyway(api) -> None:
    place = WantedStep(skill="place", arguments={"Object": "alternator_1"})
    made = done(api, seq.create_sequence(NewSequence(steps=[place])))

    refused = sent(api, seq.run_sequence(made.id))
    anyway = done(api, seq.run_sequence(made.id, RunSequence(anyway=True)))
    ended = until(api, anyway.name, "ended")

    assert (refused.status_code, refused.json()["code"]) == (409, "CannotWork")
    assert "step 0 (place)" in refused.json()["detail"]
    assert ended.report is not None
    assert not ended.report.reached


def test_a_sequence_without_steps_is_never_run(api) -> None:
    made = done(api, seq.create_sequence(NewSequence()))

    for how in (RunSequence(), RunSequence(anyway=True, iterate=None)):
        assert sent(api, seq.run_sequence(made.id, how)).status_code == 409


def test_a_step_whose_element_has_gone_is_said_to_and_can_be_taken_out(served, api) -> None:
    pick = WantedStep(skill="pick", arguments={"Object": "compressor_1"})
    made = done(api, seq.create_sequence(NewSequence(steps=[TO_PALLET, pick])))
    with served.services.station.session.world.transaction("person", "throws it away") as tx:
        tx.remove("compressor_1")

    shown = done(api, seq.get_sequence(made.id))
    mended = done(api, seq.remove_step(made.id, made.version, 1))

    assert [step.works for step in shown.steps] == [True, False]
    assert "compressor_1" in shown.steps[1].problems[0]
    assert mended.works


def test_sequences_outlive_the_server(tmp_path) -> None:
    for run in range(2):
        with serving("kitting", tmp_path) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as api:
            if run == 0:
                made = done(api, seq.create_sequence(NewSequence(id="kept", title="Kept", steps=[TO_PALLET])))
            else:
                assert done(api, seq.get_sequence("kept")) == made
                assert sent(api, seq.delete_sequence("kept", made.version)).status_code == 204
                assert api.get("/sequences/kept").status_code == 404
