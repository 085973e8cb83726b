"""A person moves the robot by hand through the door for machines, and shows it what nobody wrote down."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import httpx2
import pytest
from support.serving import serving

from skiros_py.station.session import Options

pytestmark = pytest.mark.physics

SCENES = Path(__file__).parents[2] / "scenes"
START = 'scene:base_1 sk:pose "0 0 0 0 0 0"'


def test_an_arm_is_jogged_until_it_would_collide_and_the_docking_pose_is_taught(tmp_path) -> None:
    scene = tmp_path / "docked.ttl"
    text = (SCENES / "kitting.ttl").read_text(encoding="utf-8")
    scene.write_text(text.replace(START, 'scene:base_1 sk:pose "4.22 1.6 0 0 0 0"'), encoding="utf-8")
    with (
        serving(str(scene), tmp_path / "data", Options()) as served,
        httpx2.Client(base_url=f"{served.url}/api/v1") as api,
    ):

        def state() -> dict[str, Any]:
            found: dict[str, Any] = api.get("/robots/robot_1/state").json()
            return found

        def follow(response: httpx2.Response) -> dict[str, Any]:
            assert response.status_code == 202, response.text
            path = response.headers["location"].removeprefix("/api/v1")
            deadline = time.monotonic() + 120.0
            while (run := api.get(path).json())["status"] in ("running", "stopping") and time.monotonic() < deadline:
                time.sleep(0.02)
            found: dict[str, Any] = run
            return found

        def jog(device: str, module: str, **arguments: Any) -> dict[str, Any]:
            return follow(api.post(f"/devices/{device}/jog", json={"module": module, "arguments": arguments}))

        joints = state()["devices"]["arm_1"]["state"]["positions"]
        turned = jog("arm_1", "jog_joints", deltas=[0.1, 0, 0, 0, 0, 0, -0.2])
        after_turn = state()["devices"]["arm_1"]["state"]["positions"]
        tool = state()["frames"]["arm_1"]["position"]
        lowered = jog("arm_1", "jog_tool", frame="map", translation=[0.0, 0.0, -0.05])
        after = state()["frames"]["arm_1"]["position"]
        held_back = jog("base_1", "jog_base", dx=0.1)
        home = jog("arm_1", "home")
        for _ in range(2):
            jog("arm_1", "jog_tool", frame="map", translation=[0.1, 0.0, 0.0])
        down = [jog("arm_1", "jog_tool", frame="map", translation=[0.0, 0.0, -0.1]) for _ in range(6)]
        jog("arm_1", "home")
        before = state()["pose"]["position"]
        into_it = jog("base_1", "jog_base", dx=0.2)
        driven = jog("base_1", "jog_base", dx=-0.1)
        base = state()["pose"]["position"]
        taught = follow(api.post("/devices/base_1/teach", json={"arguments": {"location": "pallet_a"}}))
        learned = api.get("/learned").text

    assert [run["status"] for run in (turned, lowered, home, driven, taught)] == ["succeeded"] * 5
    assert after_turn[0] - joints[0] == pytest.approx(0.1, abs=0.02)
    assert after_turn[6] - joints[6] == pytest.approx(-0.2, abs=0.02)
    assert [b - a for a, b in zip(tool, after, strict=True)] == pytest.approx([0.0, 0.0, -0.05], abs=0.005)
    assert held_back["status"] == "failed"
    assert "stretched out" in held_back["rounds"][0]["text"]
    assert "would touch pallet_a" in down[-1]["rounds"][0]["text"]
    assert into_it["rounds"][0]["text"] == "base_1 would touch pallet_a"
    assert base[0] - before[0] == pytest.approx(-0.1, abs=0.03)
    (edit,) = taught["changes"][0]["edits"]
    assert edit["element"] in learned
