"""Observers get what modules ask of adapters, and change nothing."""

from __future__ import annotations

import numpy as np
import pytest

from skiros_py.errors import DeviceError
from skiros_py.execution.runtime import LibraryCall, LibraryMonitor
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.adapters import NO_PORTS, GivenPorts
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import ArmPlanner, BasePathRequest, BasePlanner, MotionPlan, MotionRequest
from skiros_py.ports.paths import BasePath
from skiros_py.ports.perception import (
    DetectionRequest,
    DetectionResult,
    PartDetector,
    Region,
    Registrar,
    RegistrationRequest,
    RegistrationResult,
)
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Done, Snapshot

IMAGE = DepthImage(
    Snapshot(0, 0.0),
    np.zeros((2, 2), np.float32),
    np.zeros((2, 2, 3), np.uint8),
    CameraIntrinsics(2, 2, 1.0, 1.0, 1.0, 1.0, 0.1, 2.0),
)
LOOK = DetectionRequest(IMAGE, Pose(), Region(Pose(), (0.1, 0.1)), ())
REGISTRATION = RegistrationRequest(IMAGE, Pose(), Solid.box(0.1, 0.1, 0.1), Pose())
MOTION = MotionRequest("arm_1", (0.0,), Pose(), ())
PATH = BasePathRequest(Pose(), Pose(), (), ())


class Everything:
    """All adapters, which answer at once."""

    def __init__(self, motion: MotionPlan | BasePath) -> None:
        self.motion = Done(motion, latency=0.5)
        self.look = Done(DetectionResult(None, (), 1.0))
        self.registration = Done(RegistrationResult(None, 0.0, "not there"))

    def plan(self, _request: object) -> Done[MotionPlan | BasePath]:
        return self.motion

    def pose(self, _link: str, _positions: object) -> Pose:
        return Pose.of(1.0, 2.0, 3.0)

    def detect(self, _request: object) -> Done[DetectionResult]:
        return self.look

    def register(self, _request: object) -> Done[RegistrationResult]:
        return self.registration


ARMS, REST = Everything(MotionPlan(0, ())), Everything(BasePath((), 0.0))


def monitored() -> LibraryMonitor:
    given = {ArmPlanner: ARMS, Kinematics: ARMS, BasePlanner: REST, PartDetector: REST, Registrar: REST}
    return LibraryMonitor(GivenPorts(given))


def ask_all(ports: LibraryMonitor) -> list[object]:
    return [
        ports.port(ArmPlanner, "arm_1").plan(MOTION),
        ports.port(BasePlanner).plan(PATH),
        ports.port(PartDetector).detect(LOOK),
        ports.port(Registrar).register(REGISTRATION),
    ]


def test_listeners_receive_the_questions_of_modules_with_their_answers() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)
    answers = ask_all(monitor)
    assert [call.request for call in heard] == [MOTION, PATH, LOOK, REGISTRATION]
    assert [call.answer for call in heard] == answers == [ARMS.motion, REST.motion, REST.look, REST.registration]


def test_a_question_answered_at_once_is_not_published() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)
    assert monitor.port(Kinematics, "arm_1").pose("tip", {}) == Pose.of(1.0, 2.0, 3.0)
    assert heard == []


def test_an_unsubscribed_listener_receives_nothing() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)()
    ask_all(monitor)
    assert heard == []


def test_a_listener_that_raises_does_not_prevent_the_answer(caplog: pytest.LogCaptureFixture) -> None:
    monitor, heard = monitored(), list[LibraryCall]()

    def broken(_call: LibraryCall) -> None:
        raise RuntimeError("oh")

    monitor.subscribe(broken)
    monitor.subscribe(heard.append)
    assert len(ask_all(monitor)) == len(heard) == 4
    assert "a listener of requests to adapters broke" in caplog.text


def test_a_missing_adapter_is_refused_by_the_name_of_its_port() -> None:
    monitor = LibraryMonitor(NO_PORTS)
    assert monitor.find(ArmPlanner, "arm_1") is None
    with pytest.raises(DeviceError, match="no adapter for ArmPlanner of arm_1"):
        monitor.port(ArmPlanner, "arm_1")
