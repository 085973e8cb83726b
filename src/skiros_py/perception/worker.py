"""The perception ports, answered by one worker process that owns Open3D."""

from __future__ import annotations

from skiros_py.ports.pending import Pending
from skiros_py.ports.perception import LookRequest, LookResult, RegistrationRequest, RegistrationResult
from skiros_py.workers import Worker

LATENCY = 0.15
"""Declared time from an image to what it shows [s]."""


class _Perception:
    """What the worker process owns; building it takes the seconds that importing Open3D takes."""

    def __init__(self) -> None:
        from skiros_py.perception.detector import detect
        from skiros_py.perception.registration import register

        self._detect = detect
        self._register = register

    def detect(self, request: LookRequest) -> LookResult:
        return self._detect(request)

    def register(self, request: RegistrationRequest) -> RegistrationResult:
        return self._register(request)


def start_perception() -> Worker:
    """Starts the worker process and returns at once; Open3D is imported over there meanwhile.

    The caller closes it.
    """
    return Worker("perception", _Perception)


class Open3dPartDetector:
    """Finds and tells apart parts on a flat support; a :class:`skiros_py.ports.perception.PartDetector`.

    Args:
        worker: From :func:`start_perception`; shared with :class:`Open3dRegistrar`.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker = worker

    def detect(self, request: LookRequest) -> Pending[LookResult]:
        """Searches one image."""
        return self._worker.call("detect", request, latency=LATENCY)


class Open3dRegistrar:
    """Finds the exact pose of a known body near a guess; a :class:`skiros_py.ports.perception.Registrar`.

    Args:
        worker: From :func:`start_perception`; shared with :class:`Open3dPartDetector`.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker = worker

    def register(self, request: RegistrationRequest) -> Pending[RegistrationResult]:
        """Registers one body."""
        return self._worker.call("register", request, latency=LATENCY)
