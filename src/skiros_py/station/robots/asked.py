"""What modules asked of adapters, for display: the last observations of cameras, and the planned motions of devices."""

from __future__ import annotations

import base64
import logging
import math
import threading
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from skiros_py.api.robots import DeviceMotion, Observation, Seen
from skiros_py.errors import SkirosError
from skiros_py.execution.runtime import LibraryCall
from skiros_py.execution.task import Task
from skiros_py.geometry import Array, Pose
from skiros_py.ports.board import Commander
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import DepthView, MotionCheck, NoMotion, ReachRequest
from skiros_py.ports.perception import DetectionRequest, DetectionResult, RegistrationRequest, RegistrationResult
from skiros_py.ports.values import DepthImage
from skiros_py.station.requests import find
from skiros_py.station.session import Session

MOST_POINTS = 20_000
"""Maximum number of points of one observation."""
_KEPT_SHOTS = 2
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
        self._shots = {id_: deque(maxlen=_KEPT_SHOTS) for id_ in only_asked}
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
        shots = self._shots.setdefault(request.camera, deque(maxlen=_KEPT_SHOTS))
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


_log = logging.getLogger(__name__)

_KEPT_PLANS = 64
"""Number of requests kept that were not answered yet."""


@dataclass(frozen=True, slots=True, eq=False)
class _Plan:
    """A plan for one device.

    Attributes:
        device: The device.
        call: The request and its answer.
        asker: The module that requested it; None if unknown.
        time: Time of the request [s, run time].
    """

    device: DeviceSpec[Any, Any]
    call: LibraryCall
    asker: Commander | None
    time: float

    @property
    def answer(self) -> Any:
        """The plan; None if there is none."""
        try:
            answer = self.call.answer.result()
        except Exception:  # noqa: BLE001 - an adapter's code; reported by the caller of the request
            return None
        return None if isinstance(answer, NoMotion) else answer

    @property
    def is_answered(self) -> bool:
        """Whether there is an answer, or the adapter fails, which the caller of the request reports."""
        try:
            return bool(self.call.answer.done())
        except Exception:  # noqa: BLE001 - an adapter's code
            return True

    def is_over(self, session: Session) -> bool:
        """Returns whether the device has reached the end, or the requesting module has abandoned the plan."""
        if isinstance(self.asker, Task) and self.asker.done:
            return True
        device, board = self.device, session.cycle.board
        snapshot = board.snapshot
        cycles = (snapshot.time - self.time) / board.period
        try:
            pose = session.spec.group_of(device.id).pose(snapshot, board.guard)
            state, request = snapshot.devices.get(device.id), self.call.request
            return bool(board.guard.call(device, "has_arrived", state, pose, request, self.answer, cycles))
        except SkirosError:  # of a kind that fails; the alarms name it
            return True


class Motions:
    """The planned motion of each device; thread-safe.

    Nothing is computed in the control thread, which only records the plans.
    """

    def __init__(self) -> None:
        self._session: Session | None = None
        self._lock = threading.Lock()
        self._asked: deque[_Plan] = deque(maxlen=_KEPT_PLANS)
        self._plans: dict[str, _Plan] = {}
        self._counts: Counter[str] = Counter()

    def open(self, session: Session) -> None:
        """Records the plans of a session."""
        self._session = session
        session.on_close(self._forget, session.runtime.asked.subscribe(partial(self._note, session)))

    def _forget(self) -> None:
        with self._lock:
            self._session = None
            self._asked.clear()
            self._plans.clear()

    def numbers(self) -> dict[str, int]:
        """Returns for each device that plans its motions a number that changes with its planned motion."""
        with self._lock:
            session = self._session
            if session is None:
                return {}
            self._update(session)
            return {id_: self._counts[id_] for id_, spec in session.spec.devices.items() if spec.plans_motions()}

    def motion(self, session: Session, device: str) -> DeviceMotion:
        """Returns the planned motion of a device.

        Raises:
            NotFound: There is no such device.
        """
        find("device", device, session.spec.devices)
        with self._lock:
            if self._session is session:
                self._update(session)
            plan, number = self._plans.get(device), self._counts[device]
        if plan is None:
            return DeviceMotion(number=number, poses=())
        kinematics = session.runtime.context.ports.find(Kinematics, device)
        guard = session.cycle.board.guard
        try:
            poses = tuple(guard.call(plan.device, "planned_poses", plan.call.request, plan.answer, kinematics))
            return DeviceMotion(number=number, poses=poses)
        except Exception as error:  # noqa: BLE001 - a kind's code: the others are drawn
            _log.error("%s: its planned motion is not drawn, planned_poses failed: %s", device, error)
            return DeviceMotion(number=number, poses=())

    def _note(self, session: Session, call: LibraryCall) -> None:
        """Records a request; called in the control thread."""
        device = session.spec.devices.get(getattr(call.request, "device", ""))
        is_plan = not isinstance(call.request, DepthView | MotionCheck | ReachRequest)
        if device is None or not is_plan or not device.plans_motions():
            return
        board = session.cycle.board
        with self._lock:  # never held for long
            self._asked.append(_Plan(device, call, board.owner, board.now))

    def _update(self, session: Session) -> None:
        """Adopts new answers, and drops finished plans; the caller holds the lock."""
        for plan in [plan for plan in self._asked if plan.is_answered]:
            self._asked.remove(plan)
            if plan.answer is not None:
                self._plans[plan.device.id] = plan
                self._counts[plan.device.id] += 1
        for device, plan in tuple(self._plans.items()):
            if plan.is_over(session):
                del self._plans[device]
                self._counts[device] += 1
