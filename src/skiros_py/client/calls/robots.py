"""Robots: what they are, where they are, and moving them by hand."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.looks import Look, RobotMotion
from skiros_py.api.modules import ModuleRunInfo
from skiros_py.api.robots import Jog, RobotInfo, RobotReading, Teach
from skiros_py.client.call import Call


def list_robots() -> Call[list[RobotInfo]]:
    """Lists the robots with what each is made of."""
    return Call("GET", "/robots", list[RobotInfo])


def get_robot(robot: str) -> Call[RobotInfo]:
    """Tells what a robot is made of."""
    return Call("GET", _path(robot), RobotInfo)


def get_robot_state(robot: str) -> Call[RobotReading]:
    """Tells where a robot is at this moment."""
    return Call("GET", f"{_path(robot)}/state", RobotReading)


def get_robot_motion(robot: str) -> Call[RobotMotion]:
    """Tells where a robot is about to go."""
    return Call("GET", f"{_path(robot)}/motion", RobotMotion)


def get_look(robot: str, camera: str) -> Call[Look]:
    """Tells what a camera saw last."""
    path = f"{_path(robot)}/cameras/{quote(camera, safe='')}/look"
    return Call("GET", path, Look)


def jog_robot(robot: str, jog: Jog) -> Call[ModuleRunInfo]:
    """Moves joints, tool, base or fingers by a little."""
    return _start(f"{_path(robot)}/jog", jog.model_dump(mode="json", exclude_none=True))


def teach_robot(robot: str, lesson: Teach) -> Call[ModuleRunInfo]:
    """Has a robot learn from how it stands now."""
    return _start(f"{_path(robot)}/teach", lesson.model_dump(mode="json"))


def home_robot(robot: str, arm: str | None = None) -> Call[ModuleRunInfo]:
    """Brings one arm or all home."""
    return _start(f"{_path(robot)}/home", {} if arm is None else {"arm": arm})


def _start(path: str, body: object) -> Call[ModuleRunInfo]:
    return Call("POST", path, ModuleRunInfo, json=body, repeatable=False)


def _path(robot: str) -> str:
    return f"/robots/{quote(robot, safe='')}"
