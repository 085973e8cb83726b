"""What cameras saw last and where robots are about to go, over REST."""

from __future__ import annotations

import base64
import math
import time
from collections.abc import Iterator
from typing import Any

import httpx2
import numpy as np
import pytest
from support.serving import Served, serving

from skiros_py.api.robots import DeviceMotion, Observation
from skiros_py.client.client import Client
from skiros_py.client.topics import Events
from skiros_py.station.session import Options

PATIENCE = 60.0


@pytest.fixture(scope="module")
def pretending(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("fake")) as server:
        yield server


@pytest.fixture(scope="module")
def worked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Served, list[dict[str, Any]]]]:
    """A simulated robot that has picked a part, and the motions that were seen meanwhile."""
    with serving("kitting", tmp_path_factory.mktemp("data"), Options()) as server:
        yield server, follow_a_pick(server.url)


def follow_a_pick(url: str) -> list[dict[str, Any]]:
    motions: list[dict[str, Any]] = []
    with httpx2.Client(base_url=f"{url}/api/v1", timeout=PATIENCE) as http:
        http.put("/jobs/pick", json={"goal": "Holding(gripper_1, starter_1)"}).raise_for_status()
        deadline = time.monotonic() + PATIENCE
        seen: dict[str, int] = {}
        while time.monotonic() < deadline:
            state = http.get("/state").json()
            for device in [name for name, number in state["motions"].items() if number != seen.get(name)]:
                motion = http.get(f"/devices/{device}/motion").json()
                motions.append(motion | {"device": device, "platforms": state["platforms"]})
            seen = state["motions"]
            if http.get("/jobs/pick").json()["outcome"]:
                break
            time.sleep(0.01)
        assert http.get("/jobs/pick").json()["outcome"] == "succeeded"
    return motions


def points_of(observation: Observation) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(observation.points), "<f4").reshape(-1, 3)


def test_before_the_first_look_the_look_is_empty_and_has_number_zero(pretending: Served) -> None:
    with Client(pretending.url) as client:
        observation, motion = client.devices.observation("camera_1"), client.devices.motion("base_1")
        state = client.send(Events.state())
    assert (observation.number, observation.pose, observation.points, observation.seen) == (0, None, "", ())
    assert motion == DeviceMotion(number=0, poses=())
    assert (state.observations, state.motions) == ({"camera_1": 0}, {"arm_1": 0, "base_1": 0})


@pytest.mark.parametrize("what", ["observation", "motion"])
def test_unknown_devices_are_not_found(pretending: Served, what: str) -> None:
    answer = httpx2.get(f"{pretending.url}/api/v1/devices/camera_2/{what}")
    assert answer.status_code == 404
    assert "unknown device 'camera_2'" in answer.json()["detail"]


@pytest.mark.physics
def test_the_points_of_a_look_lie_on_the_true_parts_of_the_pallet(worked) -> None:
    server, _ = worked
    with Client(server.url) as client:
        observation = client.devices.observation("camera_1")
    with httpx2.Client(base_url=f"{server.url}/api/v1") as http:
        truth = {one["id"]: one["position"] for one in http.get("/simulation/bodies").json()["items"]}
    points = points_of(observation)
    colours = np.frombuffer(base64.b64decode(observation.colours), np.uint8).reshape(-1, 3)
    assert 5_000 < len(points) <= 20_000
    assert len(colours) == len(points)
    x, y, z = truth["relay_box_1"]
    on_it = points[(np.hypot(points[:, 0] - x, points[:, 1] - y) < 0.02) & (points[:, 2] > z + 0.01)]
    assert len(on_it) > 10
    assert on_it[:, 2].max() < z + 0.10
    assert colours.std() > 5.0


@pytest.mark.physics
def test_a_look_contains_its_detections_with_their_poses(worked) -> None:
    server, _ = worked
    with Client(server.url) as client:
        observation, state = client.devices.observation("camera_1"), client.send(Events.state())
    assert observation.purpose == "parts"
    assert state.observations == {"camera_1": observation.number}
    assert observation.number >= 1
    assert observation.pose is not None
    assert 0.0 < observation.time < state.time
    height = points_of(observation)[:, 2].max()
    assert height < observation.pose.position[2]
    assert all(0.0 <= one.cost < 0.02 for one in observation.seen)


@pytest.mark.physics
def test_a_planned_motion_is_shown_until_the_device_stands_still(worked) -> None:
    server, motions = worked
    with Client(server.url) as client:
        last = client.devices.motion("base_1")
    numbers = [one["number"] for one in motions if one["device"] == "base_1"]
    assert numbers == sorted(numbers)
    driven = next(one for one in motions if one["device"] == "base_1" and one["poses"])
    start, end = (driven["poses"][index]["position"] for index in (0, -1))
    assert math.dist(start, driven["platforms"]["base_1"]["position"]) < 0.5
    assert math.dist(start, end) > 1.0
    assert last.poses == ()
    assert last.number > driven["number"]
