"""Those who look on hear what modules ask of libraries, and change nothing by that."""

from __future__ import annotations

import numpy as np
import pytest

from skiros_py.execution.library_monitor import LibraryCall, LibraryMonitor
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import BasePath, BasePathRequest, MotionPlan, MotionRequest
from skiros_py.ports.pending import Done
from skiros_py.ports.perception import LookRequest, LookResult, Region, RegistrationRequest, RegistrationResult
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Snapshot
from skiros_py.skills.context import Libraries

IMAGE = DepthImage(
    Snapshot(0, 0.0),
    np.zeros((2, 2), np.float32),
    np.zeros((2, 2, 3), np.uint8),
    CameraIntrinsics(2, 2, 1.0, 1.0, 1.0, 1.0, 0.1, 2.0),
)
LOOK = LookRequest(IMAGE, Pose(), Region(Pose(), (0.1, 0.1)), ())
REGISTRATION = RegistrationRequest(IMAGE, Pose(), Solid.box(0.1, 0.1, 0.1), Pose())
MOTION = MotionRequest("arm_1", (0.0,), Pose(), ())
PATH = BasePathRequest(Pose(), Pose(), (), ())


class Everything:
    """All four libraries, which answer at once."""

    def __init__(self, motion: MotionPlan | BasePath) -> None:
        self.motion = Done(motion, latency=0.5)
        self.look = Done(LookResult(None, (), 1.0))
        self.registration = Done(RegistrationResult(None, 0.0, "not there"))
        self.frame = Done(Pose.of(1.0, 2.0, 3.0))

    def plan(self, _request: object) -> Done[MotionPlan | BasePath]:
        return self.motion

    def frame_pose(self, _arm: str, _positions: object, _frame: str) -> Done[Pose]:
        return self.frame

    def detect(self, _request: object) -> Done[LookResult]:
        return self.look

    def register(self, _request: object) -> Done[RegistrationResult]:
        return self.registration


ARMS, REST = Everything(MotionPlan(0, ())), Everything(BasePath((), 0.0))


def monitored() -> LibraryMonitor:
    return LibraryMonitor(Libraries(ARMS, REST, REST, REST))


def ask_all(libraries: Libraries) -> list[object]:
    arms, bases, parts, kits = (
        libraries.arm_planner,
        libraries.base_planner,
        libraries.detector,
        libraries.registrar,
    )
    assert arms is not None
    assert bases is not None
    assert parts is not None
    assert kits is not None
    return [arms.plan(MOTION), bases.plan(PATH), parts.detect(LOOK), kits.register(REGISTRATION)]


def test_what_modules_ask_is_heard_with_the_very_answers_that_they_get() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)
    answers = ask_all(monitor.libraries)
    assert [call.request for call in heard] == [MOTION, PATH, LOOK, REGISTRATION]
    assert [call.answer for call in heard] == answers == [ARMS.motion, REST.motion, REST.look, REST.registration]


def test_frames_are_answered_and_not_told_of() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)
    planner = monitor.libraries.arm_planner
    assert planner is not None
    assert planner.frame_pose("arm_1", (0.0,), "tip").result() == Pose.of(1.0, 2.0, 3.0)
    assert heard == []


def test_whoever_has_left_hears_no_more() -> None:
    monitor, heard = monitored(), list[LibraryCall]()
    monitor.subscribe(heard.append)()
    ask_all(monitor.libraries)
    assert heard == []


def test_a_listener_that_breaks_keeps_nobody_from_an_answer(caplog: pytest.LogCaptureFixture) -> None:
    monitor, heard = monitored(), list[LibraryCall]()

    def broken(_call: LibraryCall) -> None:
        raise RuntimeError("oh")

    monitor.subscribe(broken)
    monitor.subscribe(heard.append)
    assert len(ask_all(monitor.libraries)) == len(heard) == 4
    assert "a listener of what libraries are asked broke" in caplog.text


def test_libraries_that_are_not_there_stay_so() -> None:
    assert LibraryMonitor(Libraries()).libraries == Libraries()
