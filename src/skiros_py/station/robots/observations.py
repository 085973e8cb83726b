"""The last observations of the cameras, for display: requests are noted, and converted to points on demand."""

from __future__ import annotations

import base64
import math
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from skiros_py.api.robots import Observation, Seen
from skiros_py.errors import SkirosError
from skiros_py.execution.runtime import LibraryCall
from skiros_py.geometry import Array, Pose
from skiros_py.ports.perception import DetectionRequest, DetectionResult, RegistrationRequest, RegistrationResult
from skiros_py.ports.values import DepthImage
from skiros_py.station.requests import find
from skiros_py.station.session import Session

MOST_POINTS = 20_000
"""Maximum number of points of one observation."""
_KEPT = 2
"""Shots kept of a camera: the last answered one, and a pending one."""


@dataclass(frozen=True, slots=True, eq=False)
class _Shot:
    """A picture used in a perception request.

    Attributes:
        number: Its number among the shots of the camera.
        time: When it was taken [s, run time].
        call: The request and its answer.
        what: Class of the body to be registered; None for other requests.
    """

    number: int
    time: float
    call: LibraryCall
    what: str | None


class Observations:
    """The last observation of each camera, of whatever kind; thread-safe.

    Nothing is copied or computed in the control thread.
    """

    def __init__(self) -> None:
        self._shots: dict[str, deque[_Shot]] = {}
        self._counts: Counter[str] = Counter()
        self._shown: dict[str, Observation] = {}

    def open(self, session: Session) -> None:
        """Records the observations of a session."""
        only_asked = (id_ for id_, spec in session.spec.devices.items() if spec.state_type is None)
        self._shots = {id_: deque(maxlen=_KEPT) for id_ in only_asked}
        self._shown = {}
        session.on_close(self._forget, session.runtime.asked.subscribe(partial(self._note, session)))

    def _forget(self) -> None:
        self._shots = {}

    def numbers(self) -> dict[str, int]:
        """Returns the number of the last observation of each camera; 0 for none."""
        return {id_: shot.number if (shot := _last(shots)) else 0 for id_, shots in tuple(self._shots.items())}

    def observation(self, session: Session, device: str) -> Observation:
        """Returns the last observation of a device.

        Raises:
            NotFound: There is no such device.
        """
        find("device", device, session.spec.devices)
        shot = _last(self._shots.get(device, ()))
        if shot is None:
            return Observation(number=0, camera=device, time=0.0, pose=None, points="", colours="", seen=(), purpose="")
        shown = self._shown.get(device)
        if shown is None or shown.number != shot.number:
            self._shown[device] = shown = _observation(device, shot)
        return shown

    def _note(self, session: Session, call: LibraryCall) -> None:
        """Records a request; called in the control thread."""
        request = call.request
        if not isinstance(request, DetectionRequest | RegistrationRequest):
            return
        if request.camera not in session.spec.devices:  # the request does not name its camera
            return
        board, what = session.cycle.board, None
        if isinstance(request, RegistrationRequest) and session.world.has(request.body):
            what = session.world.element(request.body).type
        self._counts[request.camera] += 1
        taken = board.now - (board.snapshot.cycle - request.image.snapshot.cycle) * board.period
        shots = self._shots.setdefault(request.camera, deque(maxlen=_KEPT))
        shots.append(_Shot(self._counts[request.camera], taken, call, what))


def _last(shots: Iterable[_Shot]) -> _Shot | None:
    """Returns the last shot whose request has been answered."""
    return next((shot for shot in reversed(tuple(shots)) if shot.call.answer.done()), None)


def _observation(camera: str, shot: _Shot) -> Observation:
    request = shot.call.request
    points, colours = points_of(request.image, request.camera_pose)
    return Observation.view_of(
        shot,
        camera=camera,
        pose=request.camera_pose,
        points=base64.b64encode(points.tobytes()).decode("ascii"),
        colours=base64.b64encode(colours.tobytes()).decode("ascii"),
        seen=_seen(shot),
        purpose="parts" if isinstance(request, DetectionRequest) else "kit",
    )


def points_of(image: DepthImage, camera: Pose, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """Returns points in the map [m] and their colours (red, green, blue from 0 to 255).

    Args:
        image: The image.
        camera: Pose of the optical frame in the map.
        most: Maximum number of points.
    """
    step = max(1, math.ceil(math.sqrt(np.count_nonzero(image.depth) / most)))
    thin = _thinned(image, step)
    colours = thin.colour[thin.depth > 0.0]
    every = max(1, math.ceil(len(colours) / most))  # if the measured pixels coincide with the pattern of the step
    points = camera.apply(thin.points()[::every]).astype("<f4") if len(colours) else np.empty((0, 3), "<f4")
    return points, np.ascontiguousarray(colours[::every], dtype=np.uint8)


def _thinned(image: DepthImage, step: int) -> DepthImage:
    """Returns an image with only every ``step``-th row and column."""
    depth, colour, whole = image.depth[::step, ::step], image.colour[::step, ::step], image.intrinsics
    height, width = depth.shape
    fx, fy, cx, cy = (value / step for value in (whole.fx, whole.fy, whole.cx, whole.cy))
    intrinsics = replace(whole, width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)
    return replace(image, depth=depth, colour=colour, intrinsics=intrinsics)


def _seen(shot: _Shot) -> Sequence[Any]:
    """Returns what was recognised, or registered."""
    try:
        result = shot.call.answer.result()
    except SkirosError:  # reported by the caller of the request
        return ()
    if isinstance(result, DetectionResult):
        return result.detections
    if not isinstance(result, RegistrationResult) or result.pose is None:
        return ()
    low, high = shot.call.request.solid.bounds()
    return (Seen.view_of(result, type=shot.what, size=(high - low).tolist(), margin=0.0),)
