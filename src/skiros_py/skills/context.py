"""What a primitive may reach: parameters come apart, everything else is here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skiros_py.robot.cell import CellSpec
from skiros_py.robot.devices import DeviceBoard
from skiros_py.robot.motion import ArmPlanner, BasePlanner
from skiros_py.robot.perception import PartDetector, Registrar
from skiros_py.world.world import World

__all__ = ["Libraries", "RunContext"]


@dataclass(frozen=True, slots=True)
class Libraries:
    """Adapters to motion and perception libraries; None where the cell (a fake) has no use for them."""

    arm_planner: ArmPlanner | None = None
    base_planner: BasePlanner | None = None
    detector: PartDetector | None = None
    registrar: Registrar | None = None


@dataclass(frozen=True, slots=True)
class RunContext:
    """One run: its world, devices, libraries, random numbers.

    Attributes:
        world: The live world model.
        board: Snapshot and commands of the present cycle.
        libraries: Motion and perception.
        cell: The cell's description (limits, joints, footprint) as brought up.
        rng: Random numbers of this run; every random choice comes from here.
        lockstep: True when simulated time waits for workers.
        report: Takes (module, progress code, text).
    """

    world: World
    board: DeviceBoard
    libraries: Libraries
    cell: CellSpec
    rng: np.random.Generator
    lockstep: bool
    report: Callable[[str, int, str], None]

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        return self.board.snapshot.time
