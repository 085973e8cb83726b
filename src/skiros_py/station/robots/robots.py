"""Robots as the API shows them, and modules started on one of them by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from skiros_py.api.robots import (
    ArmDescription,
    ArmReading,
    BaseDescription,
    CameraDescription,
    GripperDescription,
    Jog,
    JointDescription,
    RobotInfo,
    RobotReading,
)
from skiros_py.api.view import BaseInfo, GripperInfo, PoseInfo
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec, GripperState
from skiros_py.devices.mobile_base import BaseSpec, BaseState
from skiros_py.errors import UnknownName, UsageError, WrongState
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.frames import FrameTree
from skiros_py.ports.kinematics import BASE_JOINTS, JointRange, Kinematics
from skiros_py.ports.values import Snapshot
from skiros_py.skills.surroundings import owner
from skiros_py.station.modules.runs import ModuleRun, ModuleRuns, Wish
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.world.vocabulary import HELD_BY

_UNLIMITED = JointRange(None, None, None)

# ---------------------------------------------------------------------- description


def robot_of(session: Session, id_: str) -> RobotSpec:
    """Returns a robot.

    Raises:
        UnknownName: There is none with this id.
    """
    by_id = {robot.id: robot for robot in session.spec.robots}
    if id_ not in by_id:
        raise UnknownName("robot", id_, by_id)
    return by_id[id_]


def info(session: Session, robot: RobotSpec) -> RobotInfo:
    """Describes a robot; callable in any thread."""
    model, view = session.runtime.context.frames.kinematics(robot), session.world.snapshot()
    return RobotInfo(
        id=robot.id,
        label=view.element(robot.id).label if view.has(robot.id) else "",
        model=robot.model,
        base=_base(robot, model),
        carrier=None if robot.carrier is None else robot.carrier.id,
        place=_pose(robot.place) if robot.carrier is None else None,
        footprint=robot.outline,
        arms=tuple(_arm(arm, model) for arm in robot.of(ArmSpec)),
        grippers=tuple(
            GripperDescription(id=g.id, arm=g.arm, joints=g.joints, max_gap=g.max_gap, max_force=g.max_force)
            for g in robot.of(GripperSpec)
        ),
        cameras=tuple(
            CameraDescription(id=c.id, frame=c.frame, width=c.width, height=c.height, vertical_fov=c.vertical_fov)
            for c in robot.of(CameraSpec)
        ),
        agents=_agents(session, robot),
    )


def _base(robot: RobotSpec, model: Kinematics | None) -> BaseDescription | None:
    for base in robot.of(BaseSpec):
        return BaseDescription(
            id=base.id,
            joints=tuple(name for name in BASE_JOINTS if model is not None and name in model.joints),
            max_linear=base.max_linear,
            max_angular=base.max_angular,
            footprint=base.footprint,
        )
    return None


def _arm(arm: ArmSpec, model: Kinematics | None) -> ArmDescription:
    return ArmDescription(id=arm.id, joints=tuple(_joint(n, model) for n in arm.joints), home=arm.home, tip=arm.tip)


def _joint(name: str, model: Kinematics | None) -> JointDescription:
    joint = _UNLIMITED if model is None else model.joints.get(name, _UNLIMITED)
    return JointDescription(name=name, lower=joint.lower, upper=joint.upper, velocity=joint.velocity)


def _agents(session: Session, robot: RobotSpec) -> tuple[str, ...]:
    view = session.world.snapshot()
    return tuple(a for a in sorted(session.managers) if view.has(a) and owner(view, a) == robot.id)


# ---------------------------------------------------------------------- state


def reading(session: Session, robot: RobotSpec) -> RobotReading:
    """Returns the present state of a robot; does not block; callable from any thread."""
    snapshot, view = session.cycle.board.snapshot, session.world.snapshot()
    placement = view.placement(robot.id) if view.has(robot.id) else None
    grippers = {g.id: snapshot.state(g.id, GripperState) for g in robot.of(GripperSpec)}
    return RobotReading(
        id=robot.id,
        time=snapshot.time,
        cycle=snapshot.cycle,
        halted=session.cycle.halted,
        at=placement.place if placement else "",
        base=_base_reading(robot, snapshot),
        pose=_pose(robot.pose(snapshot)),
        arms={arm.id: _arm_reading(arm.id, session.runtime.context.frames.at(snapshot)) for arm in robot.of(ArmSpec)},
        grippers={
            id_: GripperInfo(
                gap=g.gap, force=g.force, still=g.still, holds=next(iter(view.subjects(HELD_BY, id_)), None)
            )
            for id_, g in grippers.items()
        },
    )


def _base_reading(robot: RobotSpec, snapshot: Snapshot) -> BaseInfo | None:
    for base in robot.of(BaseSpec):
        now = snapshot.state(base.id, BaseState)
        return BaseInfo(pose=_pose(robot.pose(snapshot)), linear=now.linear, angular=now.angular, still=now.still)
    return None


def _arm_reading(arm: str, frames: FrameTree) -> ArmReading:
    state, tool = frames.snapshot.state(arm, ArmState), frames.device(arm)
    return ArmReading(
        positions=state.positions,
        velocities=state.velocities,
        still=state.still,
        tool=_pose(tool) if tool is not None else None,
    )


def _pose(pose: Pose) -> PoseInfo:
    return PoseInfo(position=pose.position, orientation=pose.orientation)


# ---------------------------------------------------------------------- manual operation


def jog(robot: RobotSpec, wanted: Jog) -> tuple[str, dict[str, Any]]:
    """Returns the primitive that executes a jog request, and its arguments.

    Raises:
        UnknownName: The robot has no such arm or gripper.
        UsageError: It has several, and the request does not name one; or the step is too large.
    """
    if wanted.joints is not None:
        arm = _one("arm", wanted.joints.arm, [arm.id for arm in robot.of(ArmSpec)])
        joints = next(one.joints for one in robot.of(ArmSpec) if one.id == arm)
        if len(wanted.joints.deltas) != len(joints):
            raise UsageError(f"deltas: one number for each joint of {arm}: {', '.join(joints)}")
        return "jog_joints", {"arm": arm, "deltas": list(wanted.joints.deltas)}
    if wanted.tool is not None:
        tool = wanted.tool
        _require_short("translation", tool.translation, 0.1, "m")
        _require_short("rotation", tool.rotation, 0.35, "rad")
        arm = _one("arm", tool.arm, [arm.id for arm in robot.of(ArmSpec)])
        return "jog_tool", {"arm": arm, **tool.model_dump(mode="json", exclude={"arm"}, exclude_none=True)}
    if wanted.base is not None:
        _require_short("dx, dy", (wanted.base.dx, wanted.base.dy), 0.2, "m")
        return "jog_base", {
            "base": _one("base", None, [] if robot.carrier is None else [robot.carrier.id]),
            "robot": robot.id,
            **wanted.base.model_dump(),
        }
    assert wanted.gripper is not None
    gripper = _one("gripper", wanted.gripper.gripper, [gripper.id for gripper in robot.of(GripperSpec)])
    return "gripper_control", {"gripper": gripper, "gap": wanted.gripper.width}


def _one(kind: str, wanted: str | None, there: list[str]) -> str:
    if wanted is None and len(there) == 1:
        return there[0]
    if wanted is None:
        raise UsageError(f"{kind}: say which: {', '.join(there) or 'there is none'}")
    if wanted not in there:
        raise UnknownName(kind, wanted, there, where="of this robot")
    return wanted


def _require_short(what: str, way: tuple[float, ...], most: float, unit: str) -> None:
    length = math.hypot(*way)
    if length > most + 1e-9:
        raise UsageError(f"{what}: one step is at most {most:g} {unit} long, not {length:.3g} {unit}")


def start_by_hand(
    session: Session, runs: ModuleRuns, robot: RobotSpec, module: str, arguments: Mapping[str, Any], by: str
) -> ModuleRun:
    """Starts a module on an idle robot; to be called in the control thread.

    Raises:
        UsageError: The robot has no such module, or the arguments are not valid.
        WrongState: The robot is busy, or everything is halted.
    """
    able = [agent for agent in _agents(session, robot) if module in session.managers[agent].modules]
    if not able:
        raise UsageError(f"{robot.id} has no module {module}: it is a primitive of skiros-primitives")
    busy = _at_work(session, robot)
    if busy:
        raise WrongState(
            f"{robot.id} is at work ({busy}): wait, or pause or stop that; nobody jogs what moves by itself"
        )
    devices = [value for value in arguments.values() if value in able]
    agent = devices[0] if devices else able[0]
    return runs.start(session, Wish(agent, module, arguments, by, at_once=True))


def _at_work(session: Session, robot: RobotSpec) -> str:
    """Returns the activity of a robot; empty if it waits for a person, or is paused between two steps."""
    agents = _agents(session, robot)
    running = [f"{name} of {agent}" for agent in agents for name in session.managers[agent].running]
    tasks = [task.name for task in session.tasks.active if _may_move(task, agents)]
    return ", ".join([*running, *tasks])


def _may_move(task: TaskHandle, agents: tuple[str, ...]) -> bool:
    if task.status not in ("planning", "running"):
        return False
    return task.plan is None or any(set(step.arguments.values()) & set(agents) for step in task.plan.steps)
