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

from skiros_py.api.robots import Look, RobotMotion
from skiros_py.client.calls.events import get_state
from skiros_py.client.client import Client
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
        seen = -1
        while time.monotonic() < deadline:
            state = http.get("/state").json()
            if state["motions"]["robot_1"] != seen:
                motions.append(http.get("/robots/robot_1/motion").json() | {"platforms": state["platforms"]})
                seen = state["motions"]["robot_1"]
            if http.get("/jobs/pick").json()["outcome"]:
                break
            time.sleep(0.01)
        assert http.get("/jobs/pick").json()["outcome"] == "succeeded"
    return motions


def points_of(look: Look) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(look.points), "<f4").reshape(-1, 3)


def test_where_nobody_has_looked_yet_a_look_is_empty_and_numbered_zero(pretending: Served) -> None:
    with Client(pretending.url) as client:
        look, motion = client.robots.look("robot_1", "camera_1"), client.robots.motion("robot_1")
        state = client.send(get_state())
    assert (look.number, look.pose, look.points, look.seen) == (0, None, "", ())
    assert motion == RobotMotion(number=0, base=(), arms=())
    assert (state.looks, state.motions) == ({"camera_1": 0}, {"robot_1": 0})


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("/robots/robot_1/cameras/eye/look", "unknown camera 'eye' of robot 'robot_1'. Known: camera_1"),
        ("/robots/nobody/cameras/camera_1/look", "unknown robot 'nobody'"),
        ("/robots/nobody/motion", "unknown robot 'nobody'"),
    ],
)
def test_unknown_robots_and_cameras_are_not_found(pretending: Served, path: str, said: str) -> None:
    answer = httpx2.get(f"{pretending.url}/api/v1{path}")
    assert answer.status_code == 404
    assert said in answer.json()["detail"]


@pytest.mark.physics
def test_the_points_of_a_look_lie_on_what_is_on_the_pallet_in_truth(worked) -> None:
    server, _ = worked
    with Client(server.url) as client:
        look = client.robots.look("robot_1", "camera_1")
    with httpx2.Client(base_url=f"{server.url}/api/v1") as http:
        truth = {one["id"]: one["position"] for one in http.get("/simulation/bodies").json()["items"]}
    points = points_of(look)
    colours = np.frombuffer(base64.b64decode(look.colours), np.uint8).reshape(-1, 3)
    assert 5_000 < len(points) <= 20_000
    assert len(colours) == len(points)
    x, y, z = truth["relay_box_1"]
    on_it = points[(np.hypot(points[:, 0] - x, points[:, 1] - y) < 0.02) & (points[:, 2] > z + 0.01)]
    assert len(on_it) > 10
    assert on_it[:, 2].max() < z + 0.10
    assert colours.std() > 5.0


@pytest.mark.physics
def test_a_look_says_what_was_made_out_in_it_and_where(worked) -> None:
    server, _ = worked
    with Client(server.url) as client:
        look, state = client.robots.look("robot_1", "camera_1"), client.send(get_state())
    assert look.purpose == "parts"
    assert state.looks == {"camera_1": look.number}
    assert look.number >= 1
    assert look.pose is not None
    assert 0.0 < look.time < state.time
    height = points_of(look)[:, 2].max()
    assert height < look.pose.position[2]
    assert all(0.0 <= one.cost < 0.02 for one in look.seen)


@pytest.mark.physics
def test_a_motion_is_there_while_it_is_about_to_be_done_and_gone_when_the_robot_stands(worked) -> None:
    server, motions = worked
    with Client(server.url) as client:
        last = client.robots.motion("robot_1")
    numbers = [one["number"] for one in motions]
    assert numbers == sorted(numbers)
    driven = next(one for one in motions if one["base"])
    at_start, end = driven["base"][0], driven["base"][-1]
    assert math.dist((at_start["x"], at_start["y"]), driven["platforms"]["base_1"]["position"][:2]) < 0.5
    assert math.dist((at_start["x"], at_start["y"]), (end["x"], end["y"])) > 1.0
    assert (last.base, last.arms) == ((), ())
    assert last.number > driven["number"]
