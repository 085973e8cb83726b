from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.modules import ModuleDetails, ModuleRunInfo
from skiros_py.client.request import Call, result_of
from skiros_py.client.topics import Modules
from skiros_py.server.services import Services

OVER = ("succeeded", "failed", "stopped")


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as client:
        yield client


@pytest.fixture
def services(served: Served) -> Services:
    return served.services


def done(api: httpx2.Client, call: Call[Any]) -> Any:
    query = {key: value for key, value in call.query.items() if value is not None}
    response = api.request(call.method, call.path, json=call.json, params=query)
    assert response.is_success, response.text
    return result_of(call, response)


def turns(api: httpx2.Client, run: ModuleRunInfo, least: int) -> list[dict[str, Any]]:
    """Waits until a run has been told so often to stand or to go on, and returns that."""
    deadline = time.monotonic() + 90.0
    while True:
        told = api.get("/events/recent", params={"kind": "module", "type": ["paused", "resumed"]}).json()["items"]
        own: list[dict[str, Any]] = [event for event in told if event["data"]["run"] == run.id]
        if len(own) >= least or time.monotonic() > deadline:
            assert len(own) >= least, own
            return own
        time.sleep(0.01)


def followed(api: httpx2.Client, run: ModuleRunInfo) -> ModuleRunInfo:
    deadline = time.monotonic() + 90.0
    while run.status not in OVER and time.monotonic() < deadline:
        time.sleep(0.01)
        run = done(api, Modules.get_run(run.id))
    return run


def test_each_subsystem_lists_its_modules_and_its_robot(api) -> None:
    managers = {manager.agent: manager for manager in done(api, Modules.managers()).items}

    assert managers.keys() == {"arm_1", "base_1"}
    assert managers["arm_1"].skills == ["hand_over", "pick", "place", "search"]
    assert "drive_base" in managers["base_1"].primitives
    assert {manager.robot for manager in managers.values()} == {"robot_1"}


def test_a_module_is_listed_once_with_all_subsystems_that_can_run_it(api) -> None:
    listed = {module.name: module for module in done(api, Modules.list()).items}

    assert [place.agent for place in listed["confirm"].agents] == ["arm_1", "base_1"]
    assert (listed["pick"].kind, listed["move_arm"].kind) == ("skill", "primitive")


def test_a_module_description_contains_everything_that_a_form_needs(api) -> None:
    pick: ModuleDetails = done(api, Modules.get("arm_1", "pick"))

    by_key = {parameter.key: parameter for parameter in pick.parameters}
    assert by_key["Object"].json_schema["class"] == "sk:Manipulatable"
    assert by_key["Robot"].planning
    assert not by_key["Object"].planning
    assert [way.driver for way in pick.implementations] == ["fake"]
    (way,) = pick.implementations
    assert [(node.path, node.kind) for node in way.nodes] == [("body", "assert_effects")]
    assert [(edge.source, edge.target, edge.label) for edge in way.edges] == [("", "body", "")]
    assert any(condition.word == "EmptyHanded" for condition in pick.pre)
    assert pick.post


def test_a_module_description_lists_its_output_values(api) -> None:
    (answer,) = done(api, Modules.get("arm_1", "choose")).outputs

    assert (answer.name, answer.type, answer.unit, answer.help) == ("answer", "text", "", "What the person chose.")
    assert answer.json_schema["type"] == "string"
    assert done(api, Modules.get("arm_1", "pick")).outputs == []


def test_a_skill_description_contains_its_planning_action(api) -> None:
    drive = done(api, Modules.skill("drive"))

    assert drive in done(api, Modules.skills()).items
    assert (drive.agent, drive.target, drive.agent_class) == ("Base", "Location", "sk:Base")
    assert len(drive.needs) > len(drive.pre) or drive.needs == drive.pre
    assert [place.agent for place in drive.agents] == ["base_1"]


def test_unknown_subsystems_modules_and_runs_are_answered_with_404(api) -> None:
    answers = {
        "/modules/nix/pick": "UnknownAgent",
        "/modules/arm_1/nix": "UnknownModule",
        "/skills/nix": "NotFound",
        "/module-runs/nix": "NotFound",
    }

    for path, code in answers.items():
        response = api.get(path)
        assert (response.status_code, response.json()["code"]) == (404, code)


def test_checking_a_call_infers_arguments_and_lists_failed_conditions_without_running_it(api) -> None:
    before = api.get("/module-runs").json()

    panel = done(api, Modules.panel("arm_1", "pick", {"Object": "starter_1"}))

    assert not panel.ready
    assert panel.arguments["Gripper"] == "gripper_1"
    assert any(row.holds is False and row.why for row in panel.conditions if row.kind == "pre")
    assert api.get("/module-runs").json() == before


@pytest.mark.parametrize(
    "arguments",
    [
        {"Location": "nix"},
        {"Nowhere": "kit_1"},
        {"Location": 17},
        {"Location": ["kit_1"]},
        {"Location": 10**400},
        {"Location": "\x00"},
        {"Location": {"a": {"b": []}}},
    ],
)
def test_wrong_arguments_are_refused_before_anything_starts(api, arguments) -> None:
    before = len(done(api, Modules.runs()).items)

    for what in ("panel", "runs"):
        response = api.post(f"/modules/base_1/drive/{what}", json={"arguments": arguments})
        assert response.status_code in (400, 422), response.text

    assert len(done(api, Modules.runs()).items) == before


@pytest.mark.parametrize("value", ["NaN", "1e999", '"\\ud800"'])
def test_arguments_that_json_cannot_represent_are_refused(api, value) -> None:
    text = f'{{"arguments": {{"Location": {value}}}}}'
    response = api.post("/modules/base_1/drive/runs", content=text, headers={"Content-Type": "application/json"})

    assert response.status_code in (400, 422)


def test_the_details_of_a_run_contain_inferred_arguments_events_and_changes(api) -> None:
    response = api.post("/modules/base_1/drive/runs", json={"arguments": {"Location": "pallet_a"}})
    assert response.status_code == 202
    run = followed(api, ModuleRunInfo.model_validate(response.json()))

    assert response.headers["location"] == f"/api/v1/module-runs/{run.id}"
    assert (run.status, run.done, run.succeeded) == ("succeeded", 1, 1)
    assert run.arguments == {"Base": "base_1", "Robot": "robot_1", "Location": "pallet_a"}
    assert [run.progress[0].status, run.progress[-1].status] == ["started", "terminated"]
    edits = [edit for change in run.changes for edit in change["edits"]]
    assert {"relation": "sk:at", "place": "pallet_a"} in [edit["new"] for edit in edits]


def test_a_failed_run_gives_its_reason(api) -> None:
    with_nothing = followed(api, done(api, Modules.run("arm_1", "place", {"Object": "alternator_1"})))

    assert with_nothing.status == "failed"
    assert with_nothing.rounds[0].text
    assert with_nothing.changes == []


def test_a_module_is_repeated_as_requested_and_its_successes_are_counted(api) -> None:
    run = followed(api, done(api, Modules.run("base_1", "drive", {"Location": "kit_1"}, repeat=3)))

    assert (run.status, run.repeat, run.done, run.succeeded) == ("succeeded", 3, 3, 3)
    assert len(run.rounds) == 3
    assert all(a.end <= b.start for a, b in zip(run.rounds, run.rounds[1:], strict=False))


def test_a_run_can_be_paused_stepped_resumed_and_finally_stopped(api, services) -> None:
    run = done(api, Modules.run("arm_1", "confirm", {"question": "Is it so?"}, repeat=5))
    paused = done(api, Modules.command(run.id, "pause"))
    stepped = done(api, Modules.command(run.id, "step"))
    resumed = done(api, Modules.command(run.id, "resume"))
    stopped = followed(api, done(api, Modules.command(run.id, "stop")))

    assert {paused.status, stepped.status, resumed.status} <= {"running", "paused"}
    assert (stopped.status, stopped.done, stopped.succeeded) == ("stopped", 1, 0)
    assert done(api, Modules.command(run.id, "stop")) == stopped
    for command in ("pause", "step", "resume"):
        assert api.post(f"/module-runs/{run.id}/{command}").status_code == 409
    assert not any(m.running for m in services.station.session.managers.values())


def test_a_run_publishes_each_pause_and_each_resume_once(api) -> None:
    run = done(api, Modules.run("arm_1", "confirm", {"question": "Is it so?"}))
    told = []
    for command, turn in (("pause", "paused"), ("step", None), ("resume", "resumed"), ("pause", "paused")):
        done(api, Modules.command(run.id, command))
        told += [turns(api, run, len(told) + 1)[-1]] if turn else []
        status = done(api, Modules.get_run(run.id)).status
        assert status == ("running" if turn == "resumed" else "paused")
    followed(api, done(api, Modules.command(run.id, "stop")))

    assert [event["type"] for event in turns(api, run, 3)] == ["paused", "resumed", "paused"]
    assert told == turns(api, run, 3)
    assert {event["subject"] for event in told} == {"confirm"}
    assert {(event["data"]["agent"], event["data"]["kind"]) for event in told} == {("arm_1", "primitive")}


def test_a_module_runs_once_at_a_time_and_cannot_be_reset_meanwhile(api) -> None:
    run = done(api, Modules.run("arm_1", "confirm", {"question": "Is it so?"}))
    again = api.post("/modules/arm_1/confirm/runs", json={"arguments": {"question": "Is it so?"}})
    reset = api.post("/modules/arm_1/confirm/reset")
    done(api, Modules.command(run.id, "stop"))
    followed(api, run)

    assert (again.status_code, reset.status_code) == (409, 409)
    assert "running already" in again.json()["detail"]
    assert api.post("/modules/arm_1/confirm/reset").status_code == 204


def test_runs_are_listed_newest_first_and_filtered_by_whether_they_are_finished(api) -> None:
    first = followed(api, done(api, Modules.run("base_1", "drive", {"Location": "pallet_a"})))
    second = done(api, Modules.run("arm_1", "confirm", {"question": "Is it so?"}))

    active = done(api, Modules.runs(active=True)).items
    over = done(api, Modules.runs(active=False, limit=1)).items
    done(api, Modules.command(second.id, "stop"))
    followed(api, second)

    assert [run.id for run in active] == [second.id]
    assert [run.id for run in over] == [first.id]
    assert [run.id for run in done(api, Modules.runs(limit=2)).items] == [second.id, first.id]


def test_no_module_starts_while_everything_is_halted(api, services) -> None:
    services.station.session.cycle.halt("somebody pressed the button")
    try:
        refused = api.post("/modules/base_1/drive/runs", json={"arguments": {"Location": "pallet_a"}})
    finally:
        services.station.control.call(lambda session: session.reset())

    assert refused.status_code == 409
    assert "somebody pressed the button" in refused.json()["detail"]


def test_only_the_last_rounds_of_a_repeated_run_are_kept(api) -> None:
    run = followed(api, done(api, Modules.run("base_1", "drive", {"Location": "pallet_a"}, repeat=110)))

    assert run.done == 110
    assert len(run.rounds) == 100


def test_plug_ins_are_listed_with_their_origin_and_status(api) -> None:
    plugins = api.get("/plugins").json()

    drive = next(one for one in plugins["items"] if (one["group"], one["name"]) == ("skiros.skills", "drive"))
    assert drive["distribution"] == "skiros-skills"
    assert drive["works"]
    assert api.get("/plugins/faults").json() == {"items": [], "next": None}
