"""Frames and scene of a recording: where everything is, as other programs see it."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Pose
from skiros_py.recording import Recording
from skiros_py.station.recordings.runs import run_recorder
from skiros_py.station.session import Options, Session


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Session, Path]:
    folder = tmp_path_factory.mktemp("data")
    session = Session("kitting", Options(fake=True, goal="InKit(Starter, kit_1)"))
    with session, run_recorder(session, folder) as recorder:
        recorder.conclude(session.run())
    return session, next((folder / "runs").iterdir())


def poses(frames: dict[str, Any]) -> dict[str, Pose]:
    """Returns where each frame is in the map."""
    parents = {one["child_frame_id"]: one for one in frames["transforms"]}

    def pose(name: str) -> Pose:
        if name == "map":
            return Pose()
        one = parents[name]
        own = Pose(tuple(one["translation"].values()), tuple(one["rotation"].values()))
        return pose(one["parent_frame_id"]) @ own

    return {name: pose(name) for name in parents}


def test_recorded_frames_are_those_of_forward_kinematics_at_the_time(recorded: tuple[Session, Path]) -> None:
    from skiros_py.motion.pinocchio.kinematics import kinematics_of

    (robot,) = recorded[0].spec.robots
    (arm,) = robot.of(ArmSpec)
    model = kinematics_of(robot.model)
    with Recording(recorded[1]) as recording:
        frames = {time: message for _, time, message in recording.messages("/frames")}
        states = {frame.time: frame.devices for frame in recording.frames()}

    assert frames.keys() == states.keys()
    for time, message in frames.items():
        found, base = poses(message), states[time]["base_1"]["pose"]
        positions = dict(zip(arm.joints, states[time]["arm_1"]["positions"], strict=True))
        robot_pose = Pose(tuple(base["position"]), tuple(base["orientation"]))
        for link in ("panda_link4", "panda_hand", arm.tip):
            expected = robot_pose @ model.pose(link, positions)
            assert np.allclose(found[f"robot_1/{link}"].matrix(), expected.matrix(), atol=1e-4), link
        assert found["gripper_1"] == found[f"robot_1/{arm.tip}"]


def test_every_message_matches_its_schema_and_the_scene_shows_the_believed_world(
    recorded: tuple[Session, Path],
) -> None:
    scenes = []
    with recorded[1].open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            data = json.loads(message.data)
            Draft202012Validator(json.loads(schema.data)).validate(data)
            if channel.topic == "/scene":
                scenes.append({one["id"]: one for one in data["entities"]})
    frames = [scene["starter_1"]["frame_id"] for scene in scenes]
    assert [frames[0], *(after for before, after in pairwise(frames) if after != before)][:2] == ["map", "gripper_1"]
    assert any(entity["cubes"] for entity in scenes[0].values())


def test_the_scene_and_the_model_of_the_robot_are_attached_without_paths_of_this_machine(
    recorded: tuple[Session, Path],
) -> None:
    with Recording(recorded[1]) as recording:
        attached = {one.name: one.data.decode() for one in recording.attachments()}
    assert "starter_1" in attached["scene.ttl"]
    assert "package://pybullet_data/" in attached["mobile_panda.urdf"]
    assert "site-packages" not in attached["mobile_panda.urdf"]
