from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.documents import DocumentInfo
from skiros_py.api.tasks import NewTask, TaskInfo, WantedStep
from skiros_py.client.request import Call, result_of
from skiros_py.client.topics import Documents, Tasks

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
    headers = {name: value for name, value in call.headers.items() if value is not None}
    return api.request(call.method, call.path, json=call.json, params=query, headers=headers)


def done(api: httpx2.Client, call: Call[Any]) -> Any:
    response = sent(api, call)
    assert response.is_success, response.text
    return result_of(call, response)


def until(api: httpx2.Client, name: str, *statuses: str) -> TaskInfo:
    deadline = time.monotonic() + 20.0
    while True:
        task: TaskInfo = done(api, Tasks.get(name))
        if task.status in statuses or time.monotonic() > deadline:
            assert task.status in statuses, task
            return task
        time.sleep(0.01)


def step(skill: str, **arguments: str) -> dict[str, Any]:
    return {"skill": skill, "arguments": arguments}


def written(api: httpx2.Client, id_: str, *steps: dict[str, Any], seen: int | None = None) -> DocumentInfo:
    made: DocumentInfo = done(api, Documents.put("sequence", id_, {"steps": list(steps)}, seen=seen))
    return made


def places(document: DocumentInfo) -> list[str]:
    return [problem.place for problem in document.problems]


# ---------------------------------------------------------------------- tasks


def test_a_task_keeps_its_goal_plan_order_steps_and_report(api) -> None:
    response = api.post("/tasks", json={"goal": ["InKit(Starter, kit_1)"]})
    assert response.status_code == 202
    task = until(api, response.json()["name"], "ended")
    trace = done(api, Tasks.trace(task.name))

    assert response.headers["location"] == f"/api/v1/tasks/{task.name.replace(' ', '%20')}"
    assert [step.skill for step in task.plan] == ["drive", "pick", "drive", "place"]
    assert [step.after for step in task.plan] == [(), (0,), (1,), (2,)]
    assert [step.skill for step in task.steps] == [step.skill for step in task.plan]
    assert all(step.ended == "ended" and step.end is not None for step in task.steps)
    assert task.report is not None
    assert (task.report.outcome, task.report.reached) == ("reached", True)
    assert [trace.items[0]["what"], trace.items[-1]["what"]] == ["begun", "finished"]
    assert done(api, Tasks.list(active=False)).items[0].name == task.name


def test_an_unparsable_goal_starts_nothing(api) -> None:
    before = done(api, Tasks.list())

    for goal in (["InKit(Starter"], ["Nonsense(kit_1)"], ["InKit(Nothing, kit_1)"]):
        assert api.post("/tasks", json={"goal": goal}).status_code == 422

    assert done(api, Tasks.list()) == before


def test_the_task_of_a_job_is_found_by_the_job_id_and_commanded_through_the_job(api) -> None:
    api.put("/jobs/kit-1", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
    deadline = time.monotonic() + 20.0
    while api.get("/tasks/kit-1").status_code == 404 and time.monotonic() < deadline:
        time.sleep(0.005)
    refused = api.post("/tasks/kit-1/pause")
    task = until(api, "kit-1", "ended")

    assert (task.job, task.by) == ("kit-1", "")
    assert refused.status_code == 409


def test_a_task_can_be_paused_stepped_and_stopped(api) -> None:
    task = done(api, Tasks.begin(NewTask(steps=[TO_PALLET, TO_KIT], iterate=None)))
    done(api, Tasks.command(task.name, "pause"))
    paused = until(api, task.name, "paused")
    done(api, Tasks.command(task.name, "step"))
    done(api, Tasks.command(task.name, "stop"))
    stopped = until(api, task.name, "ended")

    assert paused.report is None
    assert stopped.report is not None
    assert stopped.report.outcome == "stopped"
    assert done(api, Tasks.command(task.name, "stop")) == stopped
    assert sent(api, Tasks.command(task.name, "resume")).status_code == 409


def test_unknown_tasks_are_answered_with_404_and_unknown_commands_are_refused(api) -> None:
    assert api.get("/tasks/nix").status_code == 404
    assert api.get("/tasks/nix/trace").status_code == 404
    assert api.post("/tasks/nix/pause").status_code == 404
    assert api.post("/tasks/nix/dance").status_code == 422
    assert api.post("/tasks", json={}).status_code == 422
    assert api.post("/tasks", json={"goal": ["x"], "steps": []}).status_code == 422
    assert api.post("/tasks", json={"goal": ["x"], "sequence": "round"}).status_code == 422


# ---------------------------------------------------------------------- sequences

PALLET = step("drive", Location="pallet_a")
KIT = step("drive", Location="kit_1")


def test_each_step_of_a_sequence_is_checked_in_the_world_after_the_previous_steps(api) -> None:
    pick = step("pick", Object="alternator_1")
    made = written(api, "round", PALLET, pick)
    late = written(api, "round", PALLET, KIT, pick, seen=made.revision)
    early = written(api, "round", KIT, PALLET, pick, seen=late.revision)

    assert (places(made), places(late), places(early)) == ([], ["steps[2]"], [])
    assert late.problems[0].text
    assert made.agents == {"steps[0]": "base_1", "steps[1]": "arm_1"}
    assert done(api, Documents.get("sequence", "round")) == early


def test_a_sequence_cannot_be_overwritten_without_its_latest_version(api) -> None:
    made = written(api, "shared", PALLET)
    written(api, "shared", PALLET, KIT, seen=made.revision)

    stale = sent(api, Documents.put("sequence", "shared", {"steps": []}, seen=made.revision))
    blind = api.delete("/documents/sequence/shared")

    assert (stale.status_code, blind.status_code) == (412, 428)
    assert len(done(api, Documents.get("sequence", "shared")).data["steps"]) == 2


@pytest.mark.parametrize(
    ("data", "place"),
    [
        ({"steps": [PALLET, step("fly")]}, "steps[1]"),
        ({"steps": [step("drive", Location="nix")]}, "steps[0]"),
        ({"steps": [step("drive", Place="pallet_a")]}, "steps[0]"),
        ({"steps": [{"skill": "drive", "at": 3}]}, "steps[0]"),
        ({"steps": [{"skill": "drive", "arguments": {"Location": 3}}]}, "steps[0]"),
        ({"steps": [PALLET] * 101}, "steps"),
        ({"steps": [], "name": "x"}, "name"),
        ({"title": "x" * 201}, "title"),
    ],
)
def test_invalid_steps_are_refused_with_their_place_and_nothing_changes(api, data: Any, place: str) -> None:
    if api.get("/documents/sequence/kept").status_code == 404:
        written(api, "kept", PALLET)
    before = done(api, Documents.get("sequence", "kept"))

    refused = sent(api, Documents.put("sequence", "kept", data, seen=before.revision))

    assert (refused.status_code, refused.json()["code"]) == (422, "InvalidRequest")
    assert [fault["place"] for fault in refused.json()["faults"]] == [place]
    assert done(api, Documents.get("sequence", "kept")) == before


def test_a_sequence_made_from_a_plan_runs_as_often_as_requested(api) -> None:
    until(api, api.post("/tasks", json={"goal": ["RobotAtLocation(robot_1, kit_1)"]}).json()["name"], "ended")
    asked = api.post("/previews", json={"goal": "RobotAtLocation(robot_1, pallet_a)"}).raise_for_status().json()
    plan = api.get(f"/previews/{asked['id']}", params={"wait": 30}).json()["steps"]
    planned = [{"skill": one["skill"], "arguments": one["arguments"]} for one in plan]
    written(api, "planned", *planned, KIT)

    begun = done(api, Tasks.begin(NewTask(sequence="planned", iterate=3)))
    ended = until(api, begun.name, "ended")

    assert ended.report is not None
    assert ended.report.fault == ""
    assert [one.arguments["Location"] for one in ended.steps] == ["pallet_a", "kit_1"] * 3


def test_the_stored_plan_of_a_job_can_become_a_sequence_after_its_task_is_forgotten(tmp_path) -> None:
    with serving("kitting", tmp_path) as first, httpx2.Client(base_url=f"{first.url}/api/v1", timeout=60.0) as http:
        order = {"goal": "InKit(Starter, kit_1)"}
        http.put("/jobs/kept", json=order, headers={"Prefer": "wait=30"}).raise_for_status()
        fresh = http.get("/jobs/kept/plan").raise_for_status().json()["items"]
    with serving("kitting", tmp_path) as second, httpx2.Client(base_url=f"{second.url}/api/v1", timeout=60.0) as http:
        assert http.get("/tasks/kept").status_code == 404
        kept = http.get("/jobs/kept/plan").raise_for_status().json()["items"]
        steps = [{"skill": one["skill"], "arguments": one["arguments"]} for one in kept]
        http.put("/documents/sequence/again", json={"data": {"steps": steps}}).raise_for_status()

    assert [one["skill"] for one in kept] == ["drive", "pick", "drive", "place"]
    assert [one["arguments"] for one in kept] == [one["arguments"] for one in fresh]
    assert all(one["arguments"] for one in kept)


def test_a_sequence_that_cannot_work_runs_only_with_an_explicit_override(api) -> None:
    written(api, "odd", step("place", Object="alternator_1"))

    refused = sent(api, Tasks.begin(NewTask(sequence="odd")))
    anyway = done(api, Tasks.begin(NewTask(sequence="odd", anyway=True)))
    ended = until(api, anyway.name, "ended")

    assert (refused.status_code, refused.json()["code"]) == (409, "CannotWork")
    assert "step 0 (place)" in refused.json()["detail"]
    assert ended.report is not None
    assert not ended.report.reached


def test_a_sequence_without_steps_cannot_run_and_is_not_a_module(api) -> None:
    written(api, "empty")

    for how in (NewTask(sequence="empty"), NewTask(sequence="empty", anyway=True, iterate=None)):
        assert sent(api, Tasks.begin(how)).status_code == 409
    assert api.get("/modules/base_1/sequence:empty").status_code == 404
    assert sent(api, Tasks.begin(NewTask(sequence="none such"))).status_code == 422


def test_a_sequence_is_also_a_module_whose_steps_are_calls(api) -> None:
    made = written(api, "both ways", PALLET, KIT)

    (way,) = api.get("/modules/base_1/sequence:both ways").json()["implementations"]
    run = api.post("/modules/base_1/sequence:both ways/runs", json={}).raise_for_status().json()
    deadline = time.monotonic() + 30.0
    while (found := api.get(f"/module-runs/{run['id']}").json())["status"] == "running":
        assert time.monotonic() < deadline
        time.sleep(0.02)

    assert way["label"] == f"revision {made.revision}"
    assert [node["module"] for node in way["nodes"]] == ["", "drive", "drive"]
    assert found["status"] == "succeeded"


def test_a_step_with_a_removed_element_is_a_problem_and_other_steps_can_still_be_edited(served, api) -> None:
    first, second = step("pick", Object="compressor_1"), step("pick", Object="relay_box_2")
    made = written(api, "old", PALLET, first, second)
    with served.services.station.session.world.transaction("person", "throws them away") as tx:
        tx.remove("compressor_1")
        tx.remove("relay_box_2")

    shown = done(api, Documents.get("sequence", "old"))
    moved = written(api, "old", first, PALLET, second, seen=made.revision)
    mended = written(api, "old", PALLET, seen=moved.revision)

    assert places(shown) == ["steps[1]", "steps[2]"]
    assert "compressor_1" in shown.problems[0].text
    assert places(moved) == ["steps[0]", "steps[2]"]
    assert places(mended) == []
    new = sent(api, Documents.put("sequence", "old", {"steps": [first]}, seen=mended.revision))
    assert new.status_code == 422


def test_sequences_survive_a_restart_of_the_server(tmp_path) -> None:
    for run in range(2):
        with serving("kitting", tmp_path) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as api:
            if run == 0:
                made = written(api, "kept", PALLET)
            else:
                assert done(api, Documents.get("sequence", "kept")) == made
                assert sent(api, Documents.remove("sequence", "kept", seen=made.revision)).status_code == 204
                assert api.get("/documents/sequence/kept").status_code == 404
