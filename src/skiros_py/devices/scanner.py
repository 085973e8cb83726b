"""Laser scanners with several layers: distances to what stands around a robot that drives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import BASE_STILL
from skiros_py.geometry import Array
from skiros_py.ports.device import DeviceSignal, DeviceSpec, FakeRobot, Individual
from skiros_py.ports.kinematics import BASE_JOINTS
from skiros_py.ports.simulation import SimulatedRobot

_COLUMNS, _LAYERS = 61, 24  # rays across, and above each other
_TURNS = 3  # each scan has every third layer and rays a third of a step aside, so that three in a row have all of them
_LOWEST, _HIGHEST = math.radians(-18.0), math.radians(48.0)
_RATE = 10.0  # [1/s]
_NOISE = 0.01  # [m]
_NOTHING = 1000.0


@dataclass(frozen=True, slots=True)
class ScannerState:
    """The last scan.

    Attributes:
        number: Number of the scan, from 1; 0 before the first one.
        points: What was met, in the frame of the scanner [m].
        nearest: Distance of the nearest of them [m]; 1000 where nothing was met.
        clear: Ends of the rays that met nothing within its range, in its frame [m].
    """

    number: int = 0
    points: tuple[tuple[float, float, float], ...] = ()
    nearest: float = _NOTHING
    clear: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class ScannerSpec(DeviceSpec[ScannerState, None]):
    """A laser scanner that looks ahead, along the x axis of its frame; it scans while its robot moves.

    Attributes:
        id: Its element id.
        frame: URDF link of its frame.
        angle: Horizontal field of view [rad].
        reach: Greatest distance [m].
    """

    kind: ClassVar[str] = "scanner"
    device_class: ClassVar[str] = "sk:Scanner"
    state_type: ClassVar[type] = ScannerState
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("nearest", lambda state: state.nearest, "m", "distance of the nearest thing", "own"),
    )

    frame: str
    angle: float
    reach: float

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads its frame, its field of view and its range."""
        return cls(
            individual.id,
            individual.text("sk:frame"),
            individual.number("sk:horizontalFov", math.pi),
            individual.number("sk:maxDepth", 5.0),
        )

    def fake(self, robot: FakeRobot) -> _FakeScanner:  # noqa: ARG002 - there is nothing to see without physics
        """Returns a scanner that meets nothing."""
        return _FakeScanner()

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedScanner:
        """Returns a scanner that casts rays."""
        return SimulatedScanner(self, robot, rng)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Its frame."""
        return (self.frame,)


class _FakeScanner:
    braking_time = 0.0

    def command(self, target: None) -> None:
        pass

    def state(self) -> ScannerState:
        return ScannerState()


class SimulatedScanner:
    """Casts rays ten times a second while its robot moves; what they meet of the robot itself is left out.

    Args:
        spec: The scanner.
        robot: Its robot.
        rng: Source of the noise.
    """

    braking_time = 0.0

    def __init__(self, spec: ScannerSpec, robot: SimulatedRobot, rng: np.random.Generator) -> None:
        self._robot = robot
        self._link = robot.link(spec.frame)
        self._moving = robot.joints(BASE_JOINTS) if set(BASE_JOINTS) <= set(robot.joint_names) else None
        self._rng = rng
        self._wait = 1.0 / _RATE
        self._left = 0.0
        across = np.linspace(-spec.angle / 2.0, spec.angle / 2.0, _COLUMNS)
        step, layers = float(across[1] - across[0]) / _TURNS, np.linspace(_LOWEST, _HIGHEST, _LAYERS)
        self._ends = [
            spec.reach * _directions(layers[turn::_TURNS], across + step * (turn - _TURNS // 2))
            for turn in range(_TURNS)
        ]
        self._state = ScannerState()

    def command(self, target: None) -> None:
        """Does nothing: it is a sensor."""

    def state(self) -> ScannerState:
        """Returns the last scan; to be called once per cycle."""
        if self._moving is not None and sum(map(abs, self._moving.read().velocities)) < BASE_STILL:
            self._left = 0.0
            return self._state
        self._left -= self._robot.engine.period
        if self._left <= 0.0:
            self._left += self._wait
            self._state = self._scanned()
        return self._state

    def _scanned(self) -> ScannerState:
        pose, ends = self._link.pose(), self._ends[self._state.number % _TURNS]
        start = np.broadcast_to(np.asarray(pose.position), ends.shape)
        hits = self._robot.engine.cast_rays(start, pose.apply(ends))
        met = np.array([hit is not None and hit.body != self._robot.name for hit in hits])
        shares = np.array([hit.fraction for hit in hits if hit is not None and hit.body != self._robot.name])
        points = ends[met] * shares[:, None]
        ranges = np.linalg.norm(points, axis=1)
        points = points * (1.0 + self._rng.normal(0.0, _NOISE, len(points)) / np.maximum(ranges, 1e-6))[:, None]
        clear = ends[[hit is None for hit in hits]]
        met_at, clear_to = (tuple((x, y, z) for x, y, z in rows.tolist()) for rows in (points, clear))
        return ScannerState(self._state.number + 1, met_at, float(ranges.min(initial=_NOTHING)), clear_to)


def _directions(layers: Array, across: Array) -> Array:
    """Returns the unit vectors of rays at some angles above the horizon and across [rad], shape (n, 3)."""
    up, turn = (axis.ravel() for axis in np.meshgrid(layers, across, indexing="ij"))
    return np.column_stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])
