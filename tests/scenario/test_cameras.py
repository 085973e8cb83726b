"""One camera that is not where its calibration says is noticed by two pictures; one over the kit verifies."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from skiros_py.config import find_scene
from skiros_py.devices.arm import ArmState
from skiros_py.execution.monitor import ModuleEvent
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.simulation.imperfections import knocked
from skiros_py.skills.outcome import Failure, Success
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v

pytestmark = pytest.mark.physics

_SEEDS = range(1, 6)


def looked_twice(session: Session) -> list[Message]:
    """Drives to the pallet and looks at a part as before a pick; returns what was said of the camera."""
    told: list[Message] = []

    def hear(event: ModuleEvent) -> None:
        if isinstance(event.text, Message) and event.text.template.startswith("{camera} sees things"):
            told.append(event.text)

    session.monitor.subscribe(hear)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    camera = {"arm": "arm_1", "camera": "camera_1"}
    assert isinstance(session.run_module("locate", {**camera, "place": "pallet_a", "part": "starter_1"}), Success)
    assert isinstance(session.run_module("register_part", {**camera, "part": "starter_1"}), Success)
    return told


@pytest.mark.parametrize("seed", _SEEDS)
def test_a_knocked_camera_is_noticed_and_the_person_told_which_and_how_much(
    open_session: Callable[..., Session], seed: int
) -> None:
    session = open_session("kitting", seed=seed, imperfections=1.0)
    session.simulation.knock_camera("camera_1", knocked(seed, 0.005, math.radians(1.0)))

    told = looked_twice(session)

    error = session.world.value("camera_1", v.SIGHT_ERROR)
    assert isinstance(error, float)
    assert 0.008 < error < 0.020
    (said,) = told
    assert said.values["camera"] == "camera_1"
    assert said.values["error"] == pytest.approx(1e3 * error, abs=0.1)


@pytest.mark.parametrize("seed", _SEEDS)
def test_of_a_calibrated_camera_nothing_is_said(open_session: Callable[..., Session], seed: int) -> None:
    session = open_session("kitting", seed=seed, imperfections=1.0)

    told = looked_twice(session)

    assert told == []
    assert session.world.value("camera_1", v.SIGHT_ERROR) is None
    assert "camera_1" in session.runtime.context.pictures.compared


OVER_THE_KIT = """
scene:kit_camera a sk:Camera ;
    rdfs:label "kit camera" ;
    sk:on scene:floor ;
    sk:pose "-1.55 0 1.15 3.141592653589793 0 0"^^sk:poseLiteral ;
    sk:width 640 ; sk:height 480 ; sk:verticalFov 0.9774 ;
    sk:minDepth 0.05 ; sk:maxDepth 2.0 ; sk:depthNoise 0.0015 ; sk:latency 0.1 .
"""


def test_a_camera_over_the_kit_that_belongs_to_no_robot_verifies_what_was_placed(
    open_session: Callable[..., Session], tmp_path: Path
) -> None:
    scene = tmp_path / "watched.ttl"
    scene.write_text(find_scene("kitting").read_text(encoding="utf-8") + OVER_THE_KIT)
    session = open_session(str(scene), seed=1)
    assert session.run(["ObjectAtLocation(starter_1, kit_1_a)"]).reached
    known = {"arm": "arm_1", "camera": "kit_camera", "part": "starter_1", "compartment": "kit_1_a"}
    arm = session.cycle.board.snapshot.state("arm_1", ArmState).positions

    there = session.run_module("verify_place", known)
    session.simulation.move_body("starter_1", Pose((3.0, 2.0, 0.0)))
    gone = session.run_module("verify_place", known)

    assert isinstance(there, Success), there
    assert isinstance(gone, Failure)
    assert "nothing of its kind is seen there" in gone.reason
    moved = np.subtract(arm, session.cycle.board.snapshot.state("arm_1", ArmState).positions)
    assert np.abs(moved).max() < 0.01
