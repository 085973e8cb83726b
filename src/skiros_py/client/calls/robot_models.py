"""Models of robots, as they are drawn."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.client.call import Call


def get_robot_model(robot: str) -> Call[str]:
    """Tells what a robot looks like, as URDF."""
    return Call("GET", _path(robot), lambda r: r.text)


def get_robot_mesh(robot: str, mesh: str) -> Call[bytes]:
    """Gives a mesh that the model names, as binary STL.

    Args:
        robot: The robot.
        mesh: The last part of the file name in the model.
    """
    return Call("GET", f"{_path(robot)}/meshes/{quote(mesh, safe='')}", lambda r: r.content)


def _path(robot: str) -> str:
    return f"/robots/{quote(robot, safe='')}/model"
