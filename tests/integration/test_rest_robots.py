from __future__ import annotations

import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.modules import ModuleRunInfo
from skiros_py.client.request import Call, result_of
from skiros_py.client.topics import Devices, Modules, Robots

OVER = ("succeeded", "failed", "stopped")
STEP = (0.1, 0.0, 0.0, 0.0, 0.0, 0.0, -0.2)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=60.0) as client:  # a model takes a while, once
        yield client


def sent(api: httpx2.Client, call: Call[Any]) -> httpx2.Response:
    return api.request(call.method, call.path, json=call.json)


def done(api: httpx2.Client, call: Call[Any]) -> Any:
    response = sent(api, call)
    assert response.is_success, response.text
    return result_of(call, response)


def followed(api: httpx2.Client, run: ModuleRunInfo) -> ModuleRunInfo:
    deadline = time.monotonic() + 20.0
    while run.status not in OVER and time.monotonic() < deadline:
        time.sleep(0.01)
        run = done(api, Modules.get_run(run.id))
    return run


def test_a_robot_is_described_with_its_devices_and_joint_limits(api) -> None:
    (robot,) = done(api, Robots.list()).items

    assert robot == done(api, Robots.get("robot_1"))
    devices = {device.id: device for device in robot.devices}
    arm, home = devices["arm_1"], devices["arm_1"].description["home"]
    assert len(arm.joints) == len(home) == 7
    limits = [(joint.lower, angle, joint.upper) for joint, angle in zip(arm.joints, home, strict=True)]
    assert all(lower < angle < upper for lower, angle, upper in limits)
    assert (robot.carrier, robot.agents) == ("base_1", ("arm_1", "base_1"))
    assert (devices["gripper_1"].mounted_on, len(devices["gripper_1"].joints)) == ("arm_1", 2)


def test_devices_of_any_kind_are_described_with_their_values(api) -> None:
    told = {device.id: device for device in done(api, Devices.list()).items}
    gripper = done(api, Devices.get("gripper_1"))
    reading = done(api, Devices.state("gripper_1"))

    assert {id_: device.kind for id_, device in told.items()} == {
        "base_1": "base",
        "localiser_1": "localiser",
        "scanner_1": "scanner",
        "arm_1": "arm",
        "gripper_1": "gripper",
        "camera_1": "camera",
        "force_torque_1": "force_torque",
    }
    assert gripper == told["gripper_1"]
    assert (gripper.robot, gripper.description["max_gap"]) == ("robot_1", 0.08)
    assert [(one.module, one.agent) for one in gripper.jog] == [("gripper_control", "arm_1")]
    assert [one.module for one in told["arm_1"].jog] == ["jog_joints", "jog_tool", "home"]
    assert (told["arm_1"].frames, len(told["arm_1"].joints), told["camera_1"].jog) == (("tcp",), 7, ())
    assert {signal.name: (signal.unit, signal.dimension) for signal in gripper.signals} == {
        "gap": ("m", "length"),
        "force": ("N", "force"),
        "still": ("", ""),
    }
    assert reading.state is not None
    assert reading.signals["gap"] == reading.state["gap"]
    assert done(api, Devices.state("camera_1")).state is None
    assert sent(api, Devices.state("nobody")).status_code == 404


def test_the_state_of_a_robot_contains_the_pose_of_its_tool_in_the_map(api) -> None:
    state = done(api, Robots.state("robot_1"))

    assert state.pose.position[:2] == pytest.approx((0.0, 0.0), abs=0.5)
    assert state.frames["base_1"] == state.pose
    assert state.frames["arm_1"].position[2] > 0.5
    assert state.devices["gripper_1"].holds is None


def positions(api: httpx2.Client) -> Any:
    state = done(api, Devices.state("arm_1")).state
    assert state is not None
    return state["positions"]


def gap(api: httpx2.Client) -> Any:
    return done(api, Devices.state("gripper_1")).signals["gap"]


def test_joints_are_jogged_and_the_arm_is_returned_home(api) -> None:
    before, tool = positions(api), done(api, Robots.state("robot_1")).frames["arm_1"]

    run = followed(api, done(api, Devices.jog("arm_1", {"deltas": STEP})))
    after, moved = positions(api), done(api, Robots.state("robot_1")).frames["arm_1"]
    home = followed(api, done(api, Devices.jog("arm_1", module="home")))

    assert (run.module, run.agent, run.status) == ("jog_joints", "arm_1", "succeeded")
    assert after == pytest.approx([a + b for a, b in zip(before, STEP, strict=True)])
    assert moved != tool
    assert home.status == "succeeded"
    assert positions(api) == pytest.approx(before)


def test_the_fingers_move_to_a_width(api) -> None:
    run = followed(api, done(api, Devices.jog("gripper_1", {"gap": 0.03})))

    assert run.status == "succeeded"
    assert gap(api) == pytest.approx(0.03)


def test_a_taught_docking_pose_is_listed_among_the_learned_concepts(api) -> None:
    run = followed(api, done(api, Devices.teach("base_1", {"location": "pallet_a"})))

    assert run.status == "succeeded"
    (edit,) = run.changes[0]["edits"]
    assert edit["new"]["type"] == "sk:TaughtDrivingPose"
    assert edit["element"] in api.get("/learned").text


@pytest.mark.parametrize(
    ("device", "request_", "status"),
    [
        ("base_1", {"arguments": {"dx": 0.3}}, 422),
        ("base_1", {"arguments": {"dyaw": 1}}, 422),
        ("base_1", {"arguments": {"base": "arm_1"}}, 422),
        ("base_1", {"module": "jog_joints"}, 422),
        ("arm_1", {"arguments": {"deltas": [0.5, 0, 0, 0, 0, 0, 0]}}, 422),
        ("arm_1", {"arguments": {"arm": "nix", "deltas": list(STEP)}}, 422),
        ("arm_1", {"module": "jog_tool", "arguments": {"translation": [0.1, 0.2, 0]}}, 422),
        ("arm_1", {"module": "jog_tool", "arguments": {"rotation": [0.3, 0.4, 0]}}, 422),
        ("gripper_1", {"arguments": {"gap": -1}}, 422),
        ("gripper_1", {"arguments": {"width": 0.02}}, 422),
        ("gripper_1", {"gap": 0.02}, 422),
        ("camera_1", {}, 422),
        ("nix", {}, 404),
    ],
)
def test_an_invalid_jog_step_is_refused_without_a_run(api, device, request_, status) -> None:
    before = len(done(api, Modules.runs()).items)

    assert api.post(f"/devices/{device}/jog", json=request_).status_code == status
    assert len(done(api, Modules.runs()).items) == before


def test_a_refused_jog_or_teach_request_names_the_modules_of_the_device_kind(api) -> None:
    other = sent(api, Devices.jog("base_1", module="jog_joints")).json()["detail"]
    none = sent(api, Devices.teach("gripper_1")).json()["detail"]

    assert "unknown module 'jog_joints' to jog base_1" in other
    assert "Known: jog_base" in other
    assert none == "gripper_1: devices of kind 'gripper' have no module to teach"


def test_a_busy_robot_cannot_be_jogged(api) -> None:
    asks = done(api, Modules.run("arm_1", "confirm", {"question": "Is it so?"}))
    refused = sent(api, Devices.jog("base_1", {"dx": 0.1}))
    home = sent(api, Devices.jog("arm_1", module="home"))
    done(api, Modules.command(asks.id, "stop"))
    followed(api, asks)

    assert (refused.status_code, home.status_code) == (409, 409)
    assert "confirm of arm_1" in refused.json()["detail"]
    assert followed(api, done(api, Devices.jog("base_1", {"dx": 0.1}))).status == "succeeded"


def test_a_robot_with_a_running_task_cannot_be_jogged(api) -> None:
    steps = [{"skill": "drive", "arguments": {"Location": place}} for place in ("pallet_a", "kit_1")]
    name = api.post("/tasks", json={"steps": steps, "iterate": None}).json()["name"]
    refused = sent(api, Devices.jog("gripper_1", {"gap": 0.02}))
    api.post(f"/tasks/{name}/stop").raise_for_status()
    deadline = time.monotonic() + 20.0
    while api.get(f"/tasks/{name}").json()["status"] != "ended" and time.monotonic() < deadline:
        time.sleep(0.01)

    assert refused.status_code == 409
    assert name in refused.json()["detail"]
    run = followed(api, done(api, Devices.jog("gripper_1", {"gap": 0.02})))
    assert run.status == "succeeded"


def test_an_unknown_robot_is_answered_with_404(api) -> None:
    calls = (Robots.get("nix"), Robots.state("nix"), Devices.teach("nix"))

    assert [sent(api, call).status_code for call in calls] == [404] * 3


def test_jogging_a_device_in_use_fails_and_does_not_start_later(served, api) -> None:
    claims = served.services.station.session.managers.claims
    held = served.services.station.control.call(lambda _session: claims.request("somebody", {"gripper_1"}))
    try:
        run = followed(api, done(api, Devices.jog("gripper_1", {"gap": 0.01})))
    finally:
        served.services.station.control.call(lambda _session: held.release())

    assert run.status == "failed"
    assert "something else uses its devices" in run.rounds[0].text
    assert gap(api) != pytest.approx(0.01)


def model_of_robot_1(api: httpx2.Client) -> httpx2.Response:
    """Reads the model, however long it takes to be made."""
    while (response := sent(api, Robots.model("robot_1"))).status_code == 202:
        time.sleep(float(response.headers["Retry-After"]))
    return response


def test_the_model_of_a_robot_and_its_meshes_are_served_and_no_other_files(api) -> None:
    model = model_of_robot_1(api)
    assert model.headers["content-type"].startswith("application/xml")

    named = [mesh.get("filename") for mesh in ET.fromstring(model.content).iter("mesh")]
    mesh = api.get(str(model.url.join(named[0])))  # as a browser makes an address of it
    assert (mesh.status_code, mesh.headers["content-type"]) == (200, "model/stl")
    assert "immutable" in mesh.headers["cache-control"]
    assert len(mesh.content) == 84 + 50 * int.from_bytes(mesh.content[80:84], "little")
    for wrong in ("robot.urdf", "%2e%2e%2frobot.urdf", "..%2f..%2fjournal.db", "%2fetc%2fpasswd", ""):
        assert api.get(f"/robots/robot_1/model/meshes/{wrong}").status_code == 404
    assert sent(api, Robots.model("nobody")).json()["code"] == "NotFound"


def test_a_robot_is_described_with_the_joints_that_a_drawing_moves(api) -> None:
    robot = done(api, Robots.get("robot_1"))
    model = ET.fromstring(model_of_robot_1(api).content)

    joints = {joint.get("name") for joint in model.iter("joint")}
    links = {link.get("name") for link in model.iter("link")}
    assert {joint.name for device in robot.devices for joint in device.joints} <= joints
    assert {"panda_joint1", "panda_finger_joint1"} <= {
        joint.name for device in robot.devices for joint in device.joints
    }
    assert {frame for device in robot.devices for frame in device.frames} <= links
