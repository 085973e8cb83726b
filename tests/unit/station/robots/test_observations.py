"""Pictures as points: what is kept of the last one of each camera."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skiros_py.errors import DeviceError
from skiros_py.execution.runtime import LibraryMonitor
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.adapters import GivenPorts
from skiros_py.ports.perception import (
    Detection,
    DetectionRequest,
    DetectionResult,
    PartDetector,
    Region,
    Registrar,
    RegistrationRequest,
)
from skiros_py.ports.perception import RegistrationResult as Registered
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Done, Snapshot
from skiros_py.station.robots.asked import MOST_POINTS, Observations
from skiros_py.station.session import Options, Session

DOWN = Pose.of(1.0, 2.0, 1.5, roll=np.pi)
SEEN = Detection("kitting:Starter", Pose.of(1.0, 2.0, 0.5), 0.001, 0.004, (0.1, 0.05, 0.05))


def shot(height: int = 480, width: int = 640, depth: float = 1.0) -> DepthImage:
    """A picture of a floor, red on its left and blue on its right."""
    colour = np.zeros((height, width, 3), np.uint8)
    colour[:, : width // 2, 0], colour[:, width // 2 :, 2] = 200, 100
    intrinsics = CameraIntrinsics(width, height, 500.0, 500.0, (width - 1) / 2, (height - 1) / 2, 0.1, 3.0)
    return DepthImage(Snapshot(0, 0.0), np.full((height, width), depth, np.float32), colour, intrinsics)


def request(image: DepthImage, camera: str = "camera_1") -> DetectionRequest:
    return DetectionRequest(image, DOWN, Region(Pose(), (0.1, 0.1)), (), camera=camera)


class Slow(Done[Any]):
    """An answer that is not there yet."""

    def done(self) -> bool:
        return False


class Dead(Done[Any]):
    """An answer that never comes: the worker died."""

    def result(self) -> Any:
        raise DeviceError("the worker died")


class Perception:
    """Answers what it is told to."""

    answer: Done[Any] = Done(DetectionResult(0.5, (SEEN,), 1.0))

    def detect(self, _request: DetectionRequest) -> Done[Any]:
        return self.answer

    def register(self, _request: RegistrationRequest) -> Done[Any]:
        return self.answer


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session("kitting", Options(fake=True)) as opened:
        yield opened


class Station:
    """A session whose robot looks through a perception of ours."""

    def __init__(self, session: Session) -> None:
        self.perception = Perception()
        self.session = session
        given = GivenPorts({PartDetector: self.perception, Registrar: self.perception})
        self.ports = session.runtime.asked = LibraryMonitor(given)
        self.observations = Observations()
        self.observations.open(session)

    def see(self, image: DepthImage, answer: Done[Any] = Perception.answer, camera: str = "camera_1") -> None:
        self.perception.answer = answer
        self.ports.port(PartDetector).detect(request(image, camera))

    def observation(self) -> Any:
        return self.observations.observation(self.session, "camera_1")


@pytest.fixture
def station(session: Session) -> Station:
    return Station(session)


def points_of(observation: Any) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(observation.points), "<f4").reshape(-1, 3)


def colours_of(observation: Any) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(observation.colours), np.uint8).reshape(-1, 3)


@pytest.mark.parametrize("size", [(480, 640), (1000, 1000), (10, 20), (1, 50_000)])
def test_a_look_contains_a_sample_of_the_points_at_their_measured_positions(
    station: Station, size: tuple[int, int]
) -> None:
    station.see(shot(*size))
    points, colours = points_of(station.observation()), colours_of(station.observation())
    assert min(size[0] * size[1], MOST_POINTS) / 3 < len(points) <= MOST_POINTS
    assert points[:, 2] == pytest.approx(0.5, abs=1e-5)
    reach = size[1] / 2 / 500.0
    assert points[:, 0].min() == pytest.approx(1.0 - reach, abs=0.02 * max(1.0, reach))
    assert points[:, 0].max() == pytest.approx(1.0 + reach, abs=0.02 * max(1.0, reach))
    assert {tuple(colour) for colour in colours[points[:, 0] < 1.0 - 0.01]} == {(200, 0, 0)}
    assert {tuple(colour) for colour in colours[points[:, 0] > 1.0 + 0.01]} == {(0, 0, 100)}


def test_a_look_without_measured_depth_has_no_points(station: Station) -> None:
    station.see(shot(depth=0.0))
    assert (station.observation().points, station.observation().colours, station.observation().number) == ("", "", 1)


def test_a_look_is_counted_after_its_detections_are_known(station: Station) -> None:
    station.see(shot(10, 20))
    station.see(shot(10, 20), Slow(None))
    assert station.observations.numbers() == {"camera_1": 1}
    station.see(shot(10, 20))
    assert station.observations.numbers() == {"camera_1": 3}
    assert station.observation().seen[0].type == "kitting:Starter"


def test_a_look_of_an_unknown_camera_is_ignored(station: Station) -> None:
    station.see(shot(10, 20), camera="")
    station.see(shot(10, 20), camera="somebody's")
    assert station.observations.numbers() == {"camera_1": 0}


def test_a_look_whose_worker_died_has_points_but_no_detections(station: Station) -> None:
    station.see(shot(10, 20), Dead(None))
    assert station.observation().seen == ()
    assert len(points_of(station.observation())) == 200


def test_a_registered_body_is_shown_with_its_class_and_size(station: Station) -> None:
    station.perception.answer = Done(Registered(Pose.of(1.0, 2.0, 0.5), 0.0007))
    asked = RegistrationRequest(shot(10, 20), DOWN, Solid.box(0.3, 0.2, 0.1), Pose(), camera="camera_1", body="kit_1")
    station.ports.port(Registrar).register(asked)
    station.ports.port(Registrar).register(replace(asked, body="nobody"))
    (seen,) = station.observation().seen
    assert (seen.type, seen.size, station.observation().purpose) == (None, (0.3, 0.2, 0.1), "kit")
    station.ports.port(Registrar).register(asked)
    (seen,) = station.observation().seen
    assert (seen.type, seen.cost) == ("kitting:Kit", 0.0007)


def test_observations_are_deleted_with_their_session_and_their_numbers_continue(session: Session) -> None:
    with Session("kitting", Options(fake=True)) as first:
        station = Station(first)
        station.see(shot(10, 20))
    assert station.observations.numbers() == {}
    session.runtime.asked = station.ports
    station.observations.open(session)
    assert station.observations.numbers() == {"camera_1": 0}
    station.see(shot(10, 20))
    assert station.observations.numbers() == {"camera_1": 2}
