"""Claims about the arm planner as a port in a worker process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose
from skiros_py.motion.adapters import WorkerPlanner, arm_motion
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import ArmPlanner, MotionPlan


@pytest.fixture(scope="module")
def planner(robot: RobotSpec) -> Iterator[ArmPlanner]:
    planner = WorkerPlanner("motion", partial(arm_motion, robot), latency=0.07)
    yield planner
    planner.close()


def test_plans_come_from_the_worker_with_the_declared_latency(
    planner: ArmPlanner, motion: ArmMotion, bench: SimpleNamespace
) -> None:
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5, seed=3)

    call = planner.plan(request)

    assert call.latency == 0.07
    plan, here = call.result(), motion.plan(request)
    assert isinstance(plan, MotionPlan)
    assert isinstance(here, MotionPlan)
    assert np.array_equal(plan.legs[-1].positions, here.legs[-1].positions)


def test_faults_of_the_worker_reach_the_caller(planner: ArmPlanner, bench: SimpleNamespace) -> None:
    with pytest.raises(UnknownName, match="leg"):
        planner.plan(replace(bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5), device="leg")).result()
