"""What modules ask motion and perception libraries, as a stream: for those who look on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.listeners import Listeners
from skiros_py.ports.motion import (
    ArmPlanner,
    BasePath,
    BasePathRequest,
    BasePlanner,
    MotionPlan,
    MotionRequest,
    NoMotion,
)
from skiros_py.ports.pending import Pending
from skiros_py.ports.perception import (
    LookRequest,
    LookResult,
    PartDetector,
    Registrar,
    RegistrationRequest,
    RegistrationResult,
)
from skiros_py.skills.context import Libraries

Request = LookRequest | RegistrationRequest | MotionRequest | BasePathRequest


@dataclass(frozen=True, slots=True, eq=False)
class LibraryCall:
    """One thing that a module asked a library.

    Attributes:
        request: What was asked.
        answer: On its way, or there: what the port says of such a request.
    """

    request: Request
    answer: Pending[Any]


class LibraryMonitor:
    """Hands what is asked of libraries to whoever listens, in order.

    Args:
        libraries: The libraries.

    Attributes:
        libraries: The same libraries for modules, observed.
    """

    def __init__(self, libraries: Libraries) -> None:
        self._listeners = Listeners[[LibraryCall]]("what libraries are asked")
        arms, bases = libraries.arm_planner, libraries.base_planner
        parts, kits = libraries.detector, libraries.registrar
        self.libraries = Libraries(
            None if arms is None else _ObservedArmPlanner(arms, self._listeners.notify),
            None if bases is None else _ObservedBasePlanner(bases, self._listeners.notify),
            None if parts is None else _ObservedDetector(parts, self._listeners.notify),
            None if kits is None else _ObservedRegistrar(kits, self._listeners.notify),
        )

    def subscribe(self, listener: Callable[[LibraryCall], None]) -> Callable[[], None]:
        """Calls the listener in the control thread with each thing that is asked; it must be quick.

        Returns:
            How to end that.
        """
        return self._listeners.add(listener)


_Tell = Callable[[LibraryCall], None]


class _ObservedArmPlanner:
    def __init__(self, planner: ArmPlanner, tell: _Tell) -> None:
        self._planner = planner
        self._tell = tell

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        answer = self._planner.plan(request)
        self._tell(LibraryCall(request, answer))
        return answer

    def frame_pose(self, arm: str, positions: tuple[float, ...], frame: str) -> Pending[Pose]:
        return self._planner.frame_pose(arm, positions, frame)


class _ObservedBasePlanner:
    def __init__(self, planner: BasePlanner, tell: _Tell) -> None:
        self._planner = planner
        self._tell = tell

    def plan(self, request: BasePathRequest) -> Pending[BasePath | NoMotion]:
        answer = self._planner.plan(request)
        self._tell(LibraryCall(request, answer))
        return answer


class _ObservedDetector:
    def __init__(self, detector: PartDetector, tell: _Tell) -> None:
        self._detector = detector
        self._tell = tell

    def detect(self, request: LookRequest) -> Pending[LookResult]:
        answer = self._detector.detect(request)
        self._tell(LibraryCall(request, answer))
        return answer


class _ObservedRegistrar:
    def __init__(self, registrar: Registrar, tell: _Tell) -> None:
        self._registrar = registrar
        self._tell = tell

    def register(self, request: RegistrationRequest) -> Pending[RegistrationResult]:
        answer = self._registrar.register(request)
        self._tell(LibraryCall(request, answer))
        return answer
