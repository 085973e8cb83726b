"""The live state of the robots: built at most once per tick regardless of the number of clients, and never stored."""

from __future__ import annotations

from typing import Any

from skiros_py.geometry import Pose
from skiros_py.station.events.log import as_text
from skiros_py.station.robots.asked import Motions, Observations
from skiros_py.station.robots.devices import device_state
from skiros_py.station.session import Session

_RATE = 20.0
"""Maximum rate at which the state is built [Hz]."""


class LiveState:
    """The current state of the robots, for many streams.

    Args:
        observations: The last observations of the cameras.
        motions: The planned motions of devices.
    """

    def __init__(self, observations: Observations, motions: Motions) -> None:
        self._observations = observations
        self._motions = motions
        self._session: Session | None = None
        self._tick = -1
        self._text = ""
        self.built = 0

    def open(self, session: Session) -> None:
        """Shows this session from now on."""
        for robot in session.spec.robots:
            session.runtime.context.frames.kinematics(robot)  # loaded now, not at the first request of a client
        self._session = session
        session.on_close(self._leave)

    def _leave(self) -> None:
        self._session = None

    def state(self, session: Session) -> dict[str, Any]:
        """Returns the current state of the robots as plain data; does not block; callable from any thread."""
        return _live_state(session) | {"observations": self._observations.numbers(), "motions": self._motions.numbers()}

    def text(self, now: float) -> str:
        """Returns the state as JSON in one line; empty while there is no session.

        Args:
            now: Any steady clock [s]; within one tick the same text is returned.
        """
        session, tick = self._session, int(now * _RATE)
        if session is None:
            return ""
        if tick != self._tick or not self._text:
            self._tick, self._text = tick, as_text(self.state(session))
            self.built += 1
        return self._text


def _live_state(session: Session) -> dict[str, Any]:
    cycle = session.cycle
    snapshot = cycle.board.snapshot
    frames = session.runtime.context.frames.at(snapshot)
    platforms = frames.platforms()
    return {
        "time": snapshot.time,
        "cycle": snapshot.cycle,
        "pace": cycle.pace,
        "halted": cycle.halted,
        "standing": cycle.board.still,
        "devices": {name: device_state(session, snapshot, name) for name in cycle.board.devices},
        "platforms": {name: _pose(pose) for name, pose in platforms.items()},
        "frames": {name: _pose(pose) for name, pose in frames.devices().items() if name not in platforms},
        "joints": frames.joint_positions(),
        "modules": [
            {"agent": agent, "module": name, "status": running.status}
            for agent in session.managers
            if (manager := session.managers.get(agent)) is not None  # they come and go meanwhile
            for name, running in manager.running.items()
        ],
        "tasks": [{"name": task.name, "status": task.status} for task in session.tasks.active],
    }


def _pose(pose: Pose) -> dict[str, tuple[float, ...]]:
    return {"position": pose.position, "orientation": pose.orientation}
