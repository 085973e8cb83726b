"""Libraries with which the benchmark of arm motions compares; what is not installed is left out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import arm_model
from skiros_py.motion.pinocchio.collision import Checker
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import BASE_LINK, write_robot_urdf


def installed(name: str) -> Any:
    """Returns a module; None where it is not installed."""
    try:
        return import_module(name)
    except ModuleNotFoundError:
        return None


def trac_ik(robot: RobotSpec, seconds: float) -> Callable[[Array, Array], Array | None] | None:
    """Returns TRAC-IK for the arm of a robot, which is given a pose and a seed; None where it is not installed.

    Args:
        robot: The robot.
        seconds: Longest time for a pose [s].
    """
    library = installed("trac_ik")
    if library is None:
        return None
    arm = robot.of(ArmSpec)[0]
    with TemporaryDirectory() as directory:
        urdf = write_robot_urdf(robot.model, Path(directory))
        bare = Path(directory) / "bare.urdf"
        _kinematic_tree(urdf, arm).write(bare)
        solver = library.TracIK(
            base_link_name=BASE_LINK, tip_link_name=arm.tip, urdf_path=str(bare), timeout=seconds, epsilon=1e-5
        )
    return lambda target, seed: solver.ik(target[:3, 3], target[:3, :3], seed_jnt_values=seed)


def _kinematic_tree(urdf: Path, arm: ArmSpec) -> ET.ElementTree[Any]:
    """Returns links and joints alone: with inertias or joints without end, pytracik reads all limits as zero."""
    tree = ET.parse(urdf)  # noqa: S314 - our own file
    root = tree.getroot()
    for element in list(root):
        if element.tag == "material":
            root.remove(element)
        elif element.tag == "link":
            element[:] = []
        elif element.tag == "joint":
            unneeded = {"safety_controller", "calibration", "dynamics"}
            if element.get("name") not in arm.joints:
                element.set("type", "fixed")
                unneeded |= {"axis", "limit"}
            element[:] = [part for part in element if part.tag not in unneeded]
    return tree


def ssik_branches(robot: RobotSpec) -> Callable[[Array], list[Any]] | None:
    """Returns ssik's own solver for the arm of a robot, as ``ssik build`` writes it; None where there is none.

    It is given a pose, and returns all solutions within the limits.
    """
    arm = robot.of(ArmSpec)[0]
    chain = arm_model(robot, arm).chain
    if installed("ssik") is None or chain is None:
        return None
    limits = [(float(low), float(high)) for low, high in zip(chain.lower, chain.upper, strict=True)]
    solver = installed("ssik").Manipulator.from_transforms(chain.placements, chain.axes, limits=limits)
    emit = installed("ssik.core.codegen").emit_artifact
    module: dict[str, Any] = {}
    exec(emit(kb=solver.kinbody, plan=solver.dispatch_plan, module_name=arm.id).source, module)  # noqa: S102 - its API
    return module["solve"]  # type: ignore[no-any-return]


def ompl_rrt_connect(checker: Checker, limits: tuple[Array, Array], ends: tuple[Array, Array], seconds: float) -> bool:
    """Returns whether OMPL's RRT-Connect finds a path; OMPL must be installed.

    Args:
        checker: Checks postures.
        limits: Lowest and highest joint angles [rad].
        ends: Start and goal [rad].
        seconds: Time that it is given [s].
    """
    base, geometric, util = (installed(f"ompl.{name}") for name in ("base", "geometric", "util"))
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(1)
    count = len(limits[0])
    space, bounds = base.RealVectorStateSpace(count), base.RealVectorBounds(count)
    for joint, (lower, upper) in enumerate(zip(*limits, strict=True)):
        bounds.setLow(joint, float(lower))
        bounds.setHigh(joint, float(upper))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    posture = ends[0].copy()

    def valid(state: Any) -> bool:
        posture[:] = [state[joint] for joint in range(count)]
        return checker.clear(posture)

    setup.setStateValidityChecker(valid)
    setup.getSpaceInformation().setStateValidityCheckingResolution(0.036 / space.getMaximumExtent())
    states = [space.allocState() for _ in ends]
    for state, angles in zip(states, ends, strict=True):
        for joint, angle in enumerate(angles):
            state[joint] = float(angle)
    setup.setStartAndGoalStates(*states)
    planner = geometric.RRTConnect(setup.getSpaceInformation())
    planner.setRange(0.5)
    setup.setPlanner(planner)
    setup.setup()
    setup.solve(seconds)
    return bool(setup.haveExactSolutionPath())
