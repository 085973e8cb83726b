"""The planned motions of devices, for display: the answers of planners until executed or abandoned."""

from __future__ import annotations

import logging
import threading
from collections import Counter, deque
from dataclasses import dataclass
from functools import partial
from typing import Any

from skiros_py.api.robots import DeviceMotion
from skiros_py.errors import SkirosError
from skiros_py.execution.runtime import LibraryCall
from skiros_py.execution.task import Task
from skiros_py.ports.board import Commander
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import NoMotion
from skiros_py.station.requests import find
from skiros_py.station.session import Session

_log = logging.getLogger(__name__)

_KEPT = 64
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
        self._asked: deque[_Plan] = deque(maxlen=_KEPT)
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
        if device is None or not device.plans_motions():
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
