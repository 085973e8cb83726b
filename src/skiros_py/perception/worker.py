"""The perception ports, answered by one worker process that owns Open3D."""

from __future__ import annotations

from skiros_py.ports.adapters import Adapter
from skiros_py.ports.perception import (
    DetectionRequest,
    DetectionResult,
    HeldRegistrar,
    HeldRequest,
    HeldResult,
    PartDetector,
    Registrar,
    RegistrationRequest,
    RegistrationResult,
)
from skiros_py.ports.values import Pending
from skiros_py.workers import Worker

LATENCY = 0.15
"""Declared time from an image to what it shows [s]."""


class _Perception:
    """What the worker process owns; building it takes the seconds that importing Open3D takes."""

    def __init__(self) -> None:
        from skiros_py.perception.detector import detect
        from skiros_py.perception.held import sits
        from skiros_py.perception.registration import register

        self.detect = detect
        self.register = register
        self.sits = sits


class Open3dPerception:
    """Finds parts on a flat support, the exact pose of a known body near a guess, and how a part sits in a gripper.

    A :class:`skiros_py.ports.perception.PartDetector`, :class:`skiros_py.ports.perception.Registrar` and
    :class:`skiros_py.ports.perception.HeldRegistrar`. Its process starts at once and imports Open3D meanwhile.
    """

    def __init__(self) -> None:
        self._worker = Worker("perception", _Perception)

    def detect(self, request: DetectionRequest) -> Pending[DetectionResult]:
        """Searches one image."""
        return self._worker.call("detect", request, latency=LATENCY)

    def register(self, request: RegistrationRequest) -> Pending[RegistrationResult]:
        """Registers one body."""
        return self._worker.call("register", request, latency=LATENCY)

    def sits(self, request: HeldRequest) -> Pending[HeldResult]:
        """Finds how one part sits in a gripper."""
        return self._worker.call("sits", request, latency=LATENCY)

    def close(self) -> None:
        """Ends the worker process."""
        self._worker.close()


PERCEPTION = Adapter((PartDetector, Registrar, HeldRegistrar), lambda _request: Open3dPerception())
"""Shared by all cameras; answers in the order of asking."""
