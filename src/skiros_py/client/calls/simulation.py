"""The simulation, independent of the world model."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.scenes import Bodies, Pace, SimulationState
from skiros_py.client.request import Call, nothing, path_of

_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def get_simulation() -> Call[SimulationState]:
    """Returns the state of the simulation."""
    return Call("GET", "/simulation", SimulationState)


def list_bodies() -> Call[Bodies]:
    """Returns the true poses of all bodies, which no robot has access to."""
    return Call("GET", "/simulation/bodies", Bodies)


def move_body(body: str, position: Sequence[float], orientation: Sequence[float] = _UPRIGHT) -> Call[None]:
    """Moves a body without informing any robot.

    Args:
        body: Its id.
        position: (x, y, z) in the map [m].
        orientation: Quaternion (x, y, z, w).
    """
    pose = {"position": list(position), "orientation": list(orientation)}
    return Call("PUT", path_of("simulation", "bodies", body, "pose"), nothing, json=pose)


def remove_body(body: str) -> Call[None]:
    """Removes a body without informing any robot."""
    return Call("DELETE", path_of("simulation", "bodies", body), nothing)


def reset_simulation(*, force: bool = False) -> Call[SimulationState]:
    """Restarts the simulation from the world model; with ``force``, running work is stopped first."""
    read = SimulationState
    return Call("POST", "/simulation/reset", read, query={"force": str(force).lower()}, repeatable=False)


def set_pace(pace: float) -> Call[Pace]:
    """Sets the ratio of simulated time to wall time."""
    return Call("PUT", "/simulation/pace", Pace, json={"pace": pace})


def get_picture(
    eye: Sequence[float] = (3.5, -3.5, 3.0),
    target: Sequence[float] = (0.5, 0.0, 0.3),
    *,
    width: int = 640,
    height: int = 480,
) -> Call[bytes]:
    """Renders the true scene as PNG.

    Args:
        eye: Camera position, in the map [m].
        target: Point the camera looks at [m].
        width: Image width [px].
        height: Image height [px].
    """
    query = {"eye": _point(eye), "target": _point(target), "width": width, "height": height}
    return Call("GET", "/simulation/picture", lambda r: r.content, query=query)


def _point(values: Sequence[float]) -> str:
    return ",".join(f"{value:.6f}" for value in values)
