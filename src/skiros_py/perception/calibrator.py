"""The calibration port, answered by a worker process that owns OpenCV."""

from __future__ import annotations

from skiros_py.ports.adapters import Adapter
from skiros_py.ports.calibration import CalibrationRequest, CalibrationResult, CameraCalibrator
from skiros_py.ports.values import Pending
from skiros_py.system import require_extra
from skiros_py.workers import Worker

_LATENCY = 2.0
"""Declared time of a calibration [s]."""


class _Calibration:
    def __init__(self) -> None:
        from skiros_py.perception.markers import calibrate

        self.calibrate = calibrate


class OpenCvCalibrator:
    """A :class:`skiros_py.ports.calibration.CameraCalibrator`. Its process starts with the first calibration."""

    def __init__(self) -> None:
        self._worker: Worker | None = None

    def calibrate(self, request: CalibrationRequest) -> Pending[CalibrationResult]:
        """Finds one camera.

        Raises:
            MissingExtra: OpenCV is not installed.
        """
        require_extra("calibration", "calibrating a camera")
        if self._worker is None:
            self._worker = Worker("calibration", _Calibration)
        return self._worker.call("calibrate", request, latency=_LATENCY)

    def close(self) -> None:
        """Ends the worker process."""
        if self._worker is not None:
            self._worker.close()


CALIBRATION = Adapter((CameraCalibrator,), lambda _request: OpenCvCalibrator())
"""Shared by all cameras."""
