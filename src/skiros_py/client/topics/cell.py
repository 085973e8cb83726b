"""The cell: robots, devices and signals, modules, alarms, and the simulation."""

# mypy: disable-error-code="empty-body"
# An operation is declared by its signature alone.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skiros_py.api import alarms, modules, robots, scenes
from skiros_py.client.operation import C, Topic, call, operation
from skiros_py.client.request import Call, path_of

_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


class Alarms(Topic[C]):
    """Conditions that stopped a robot or need the user."""

    @operation("GET /alarms")
    def list(self, *, active: bool | None = None, limit: int = 100, cursor: str | None = None) -> alarms.AlarmPage:
        """Lists alarms, oldest first: all, those that are active, or those that are over."""

    @operation("GET /alarms/{alarm}")
    def get(self, alarm: str) -> alarms.AlarmInfo:
        """Returns one alarm."""

    @operation("POST /alarms/{alarm}/acknowledge")
    def acknowledge(self, alarm: str) -> alarms.AlarmInfo:
        """Acknowledges an alarm."""

    @operation("POST /alarms/{alarm}/answer", once=True)
    def answer(self, alarm: str, answer: str, *, question: int | None = None) -> alarms.AlarmInfo:
        """Answers the question of an alarm.

        Args:
            alarm: Its id.
            answer: One of its choices.
            question: Id of the question that was seen, so that no other one is answered; None for the current one.
        """


class Station(Topic[C]):
    """All robots together."""

    @operation("POST /stop")
    def stop(self, reason: str = "") -> alarms.StopInfo:
        """Halts all robots in the next control cycle.

        Args:
            reason: Why, for the user.
        """

    @operation("GET /stop")
    def get_stop(self) -> alarms.StopInfo:
        """Returns whether the system is halted."""

    @operation("POST /reset")
    def reset(self) -> alarms.StopInfo:
        """Resets a halt after its cause has been checked, so that things can start again."""


class Robots(Topic[C]):
    """Robots: models and state."""

    @operation("GET /robots")
    def list(self) -> robots.Robots:
        """Lists the robots with their components."""

    @operation("GET /robots/{robot}")
    def get(self, robot: str) -> robots.RobotInfo:
        """Returns a robot with its components."""

    @operation("GET /robots/{robot}/state")
    def state(self, robot: str) -> robots.RobotReading:
        """Returns the current state of a robot."""

    @operation("GET /robots/{robot}/model")
    def model(self, robot: str) -> str:
        """Returns the model of a robot as URDF."""

    @operation("GET /robots/{robot}/model/meshes/{mesh}")
    def mesh(self, robot: str, mesh: str) -> bytes:
        """Returns a mesh of the model as binary STL.

        Args:
            robot: The robot.
            mesh: The last part of the file name in the model.
        """


class Devices(Topic[C]):
    """Devices of any kind: readings, planned motions, observations, opening and closing, jogging and teaching."""

    @operation("GET /devices")
    def list(self) -> robots.Devices:
        """Lists the devices with their values."""

    @operation("GET /devices/{device}")
    def get(self, device: str) -> robots.DeviceInfo:
        """Returns a device."""

    @operation("GET /devices/{device}/state")
    def state(self, device: str) -> robots.DeviceReading:
        """Reads a device."""

    @operation("GET /devices/{device}/motion")
    def motion(self, device: str) -> robots.DeviceMotion:
        """Returns the planned motion of a device."""

    @operation("GET /devices/{device}/observation")
    def observation(self, device: str) -> robots.Observation:
        """Returns the last observation by a camera, as points."""

    @operation("POST /devices/{device}/open")
    def open(self, device: str) -> robots.DeviceInfo:
        """Opens a device: its driver is connected, and modules may use it."""

    @operation("POST /devices/{device}/close")
    def close(self, device: str) -> robots.DeviceInfo:
        """Closes a device: no module may use it, and its driver may be disconnected."""

    @operation("POST /devices/{device}/jog", once=True)
    def jog(
        self, device: str, arguments: Mapping[str, Any] | None = None, *, module: str | None = None
    ) -> modules.ModuleRunInfo:
        """Moves a device by a small step, or home; follow the run with ``modules.get_run``.

        Args:
            device: The device.
            arguments: Parameters of the module, without the device.
            module: One of those that the kind of the device names for this; None for the first.
        """

    @operation("POST /devices/{device}/teach", once=True)
    def teach(
        self, device: str, arguments: Mapping[str, Any] | None = None, *, module: str | None = None
    ) -> modules.ModuleRunInfo:
        """Learns something from the current state of a device; see :meth:`jog`."""


class Signals(Topic[C]):
    """Signals of the cell: reading and setting."""

    @operation("GET /signals")
    def list(self) -> robots.CellSignals:
        """Lists the signals: of devices, computed ones, and inputs."""

    @operation("GET /signals/values", names="name")
    def read(self, *names: str) -> robots.SignalReadings:
        """Reads signals, all in the same control cycle."""

    @operation("PUT /signals/{name}/value")
    def set(self, name: str, value: robots.SignalValue) -> None:
        """Sets an input; it takes effect in the next control cycle."""


class Modules(Topic[C]):
    """Skills and primitives, run individually, and their managers."""

    @operation("GET /managers")
    def managers(self) -> modules.Managers:
        """Lists the skill managers, with their skills and current runs."""

    @operation("PUT /managers/{agent}", once=True)
    def open_manager(self, agent: str) -> modules.ManagerInfo:
        """Opens the skill manager of a subsystem: its skills become available."""

    @operation("DELETE /managers/{agent}", once=True)
    def close_manager(self, agent: str, *, force: bool | None = None) -> None:
        """Closes the skill manager of a subsystem: its skills leave the world model."""

    @operation("GET /modules")
    def list(self) -> modules.Modules:
        """Lists every skill and primitive with the agents that can run it."""

    @operation("GET /modules/{agent}/{module}")
    def get(self, agent: str, module: str) -> modules.ModuleDetails:
        """Returns a module of a subsystem."""

    @operation("POST /modules/{agent}/{module}/panel")
    def panel(self, agent: str, module: str, arguments: Mapping[str, Any] | None = None) -> modules.PanelInfo:
        """Returns the arguments a module would be run with now, and which of its conditions hold; nothing is run."""

    @operation("POST /modules/{agent}/{module}/runs", once=True)
    def run(
        self,
        agent: str,
        module: str,
        arguments: Mapping[str, Any] | None = None,
        *,
        repeat: int = 1,
        breakpoints: Sequence[str] = (),
    ) -> modules.ModuleRunInfo:
        """Starts a single module; follow it with :meth:`get_run`."""

    @operation("POST /modules/{agent}/{module}/reset")
    def reset(self, agent: str, module: str) -> None:
        """Resets a module after a fault."""

    @operation("GET /module-runs")
    def runs(self, *, active: bool | None = None, limit: int | None = None) -> modules.ModuleRuns:
        """Lists the runs started through the API, newest first."""

    @operation("GET /module-runs/{run}")
    def get_run(self, run: str) -> modules.ModuleRunInfo:
        """Returns the progress or result of a run."""

    @operation("PUT /module-runs/{run}/breakpoints")
    def set_breakpoints(self, run: str, paths: Sequence[str]) -> modules.ModuleRunInfo:
        """Sets the nodes before which a run pauses, replacing earlier ones; the command "resume" continues it."""

    @call
    def command(self, run: str, command: modules.RunCommand) -> Call[modules.ModuleRunInfo]:
        """Pauses, resumes, single-steps (one cycle) or stops a run."""
        path = path_of("module-runs", run, command)
        return Call("POST", path, modules.ModuleRunInfo, repeatable=command != "step")

    @operation("GET /skills")
    def skills(self) -> modules.Skills:
        """Lists the currently available skills."""

    @operation("GET /skills/{name}")
    def skill(self, name: str) -> modules.SkillInfo:
        """Returns the description of a skill, without its implementation."""


class Plugins(Topic[C]):
    """Installed plug-ins and their faults."""

    @operation("GET /plugins")
    def list(self) -> modules.Plugins:
        """Lists all entry points installed on the server."""

    @operation("GET /plugins/faults")
    def faults(self) -> modules.PluginFaults:
        """Lists plug-ins that fail to load or do not fit the current scene."""


class Simulation(Topic[C]):
    """The simulation: the ground truth, as opposed to the world model."""

    @operation("GET /simulation")
    def get(self) -> scenes.SimulationState:
        """Returns the state of the simulation."""

    @operation("GET /simulation/bodies")
    def bodies(self) -> scenes.Bodies:
        """Returns the true poses of all bodies, which no robot has access to."""

    @operation("PUT /simulation/bodies/{element}/pose?check")
    def move_body(
        self, element: str, position: Sequence[float], orientation: Sequence[float] = _UPRIGHT, *, check: bool = False
    ) -> None:
        """Moves a body without informing any robot; refused if it would be inside another body.

        Args:
            element: Id of the body.
            position: (x, y, z) in the map [m].
            orientation: Quaternion (x, y, z, w).
            check: Only check whether it has room there.
        """

    @operation("DELETE /simulation/bodies/{element}")
    def remove_body(self, element: str) -> None:
        """Removes a body without informing any robot."""

    @operation("POST /simulation/reset?force", once=True)
    def reset(self, *, force: bool = False) -> scenes.SimulationState:
        """Restarts the simulation from the world model; with ``force``, running work is stopped first."""

    @operation("PUT /simulation/pace")
    def set_pace(self, pace: float) -> scenes.Pace:
        """Sets the ratio of simulated time to wall time."""

    @call
    def picture(
        self,
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
        return Call("GET", "/simulation/picture", bytes, query)


def _point(values: Sequence[float]) -> str:
    return ",".join(f"{value:.6f}" for value in values)
