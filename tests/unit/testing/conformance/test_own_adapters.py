"""The adapters that come with the platform keep the contracts that everybody's must keep."""

from __future__ import annotations

from functools import partial

import pytest

from skiros_py.motion.adapters import WorkerPlanner, arm_motion, base_paths
from skiros_py.motion.pinocchio.kinematics import kinematics_of
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.planners.program_planner import CommandPlanner
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import ArmPlanner, BasePlanner
from skiros_py.ports.values import Done, Pending
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing import FaultyCell
from skiros_py.testing.conformance import (
    ArmPlannerContract,
    BasePlannerContract,
    CellDriverContract,
    KinematicsContract,
    PendingContract,
    PlannerContract,
)


class TestFakeCell(CellDriverContract):
    inertia = False
    pictures = False

    def make(self, spec: CellSpec) -> CellDriver:
        return FakeCell(spec)


class TestFaultyCellWithoutFaults(CellDriverContract):
    inertia = False
    pictures = False

    def make(self, spec: CellSpec) -> CellDriver:
        return FaultyCell(FakeCell(spec))


@pytest.mark.physics
class TestSimulatedCell(CellDriverContract):
    def make(self, spec: CellSpec) -> CellDriver:
        return SimulatedCell(spec, seed=1)


class TestArmMotion(ArmPlannerContract):
    def make(self, robot: RobotSpec) -> ArmPlanner:
        return WorkerPlanner("motion", partial(arm_motion, robot))


class TestPinocchioKinematics(KinematicsContract):
    def make(self, robot: RobotSpec) -> Kinematics:
        return kinematics_of(robot.model)


class TestBasePaths(BasePlannerContract):
    def make(self) -> BasePlanner:
        return WorkerPlanner("base paths", base_paths)


class TestFastDownward(PlannerContract):
    def make(self) -> Planner:
        return FastDownward()


class TestKairos(PlannerContract):
    def make(self) -> Planner:
        return Kairos()


class TestPyperplanByCommandLine(PlannerContract):
    def make(self) -> Planner:
        return CommandPlanner(
            "pyperplan",
            "pyperplan -s gbf -H hff {domain} {problem}",
            plan="{problem}.soln",
            no_plan="No solution could be found",
        )


class TestDone(PendingContract):
    def make(self) -> Pending[str]:
        return Done("here", latency=0.1)
