"""A knocked camera is calibrated by pictures of a board on the kit table; the simulator's truth judges."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.geometry import Pose
from skiros_py.simulation.imperfections import knocked
from skiros_py.skills.outcome import Success
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v

pytestmark = pytest.mark.physics

SCENE = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<https://w3id.org/skiros-py/scenes/calibrating> a owl:Ontology ;
    owl:imports <https://w3id.org/skiros-py/core> , <https://w3id.org/skiros-py/robots/mobile_panda> .
scene:this a sk:Scene .
scene:floor a sk:Floor ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ; sk:size "6 6"^^sk:vectorLiteral .
scene:unknown_location a sk:UnknownLocation .
scene:base_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .
scene:board_1 a sk:MarkerBoard ; sk:on scene:floor ; sk:pose "0.72 0 0.35 0 0 0.1"^^sk:poseLiteral .
"""


def test_a_knocked_camera_is_found(open_session: Callable[..., Session], tmp_path: Path) -> None:
    scene = tmp_path / "calibrating.ttl"
    scene.write_text(SCENE)
    session = open_session(str(scene), seed=1)
    truth = knocked(1, 0.005, math.radians(1.0))
    session.simulation.knock_camera("camera_1", truth)

    outcome = session.run_module("calibrate_camera", {"arm": "arm_1", "camera": "camera_1", "board": "board_1"})

    assert isinstance(outcome, Success), outcome
    found = session.world.value("camera_1", v.MOUNTING)
    assert isinstance(found, Pose)
    off = truth.inverse() @ found
    assert math.hypot(*off.position) < 0.001
    assert 2.0 * math.acos(min(1.0, abs(off.orientation[3]))) < math.radians(0.2)
    residual = session.world.value("camera_1", v.CALIBRATION_RESIDUAL)
    assert isinstance(residual, float)
    assert residual < 0.8
