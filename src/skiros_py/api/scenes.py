"""Scenes on the wire: those that can be loaded, the current one, and the simulation of it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field

from skiros_py.api.wire import Answer, Page, Request
from skiros_py.api.world import Rotation

SCENE_NAME = r"^[a-z0-9][a-z0-9_-]{0,63}$"
"""Names under which scenes are saved: safe as names of files everywhere."""

Source = Literal["installed", "saved"]


class SceneEntry(Answer):
    """A scene that can be loaded, as far as a list tells of it."""

    name: str = Field(examples=["kitting"])
    """Its name."""
    source: Source
    """"saved" in this data directory, or "installed" with a package."""
    saved: datetime | None = None
    """When it was saved; null for an installed one."""


Scenes = Page[SceneEntry]
"""Scenes, by name."""


class SceneRobot(Answer):
    """A robot of a scene."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    label: str = Field(examples=["robot"])
    """Its label."""
    type: str = Field(examples=["sk:Robot"])
    """Its class."""


class Scene(Answer):
    """What a scene that can be loaded consists of."""

    name: str = Field(examples=["kitting"])
    """Its name."""
    source: Source
    """"saved" in this data directory, or "installed" with a package."""
    version: int = Field(examples=[2868123])
    """Tells versions of its file apart; as in the ETag."""
    title: str = Field(examples=["kitting"])
    """What it calls itself; its name where it does not."""
    elements: int = Field(examples=[22])
    """How many elements it has; skills are not counted."""
    robots: list[SceneRobot]
    """Its robots."""
    goals: list[str] = Field(examples=[["InKit(Starter, kit_1)"]])
    """The goals that go with it."""


class PresentScene(Answer):
    """The scene that robots act in now, as believed."""

    name: str = Field(examples=["kitting"])
    """The scene that was loaded or saved last; empty for an upload."""
    version: int = Field(examples=[17])
    """Version of the world, as in the ETag."""
    changed: bool | None = Field(examples=[True])
    """Whether it differs from the scene of that name; null where there is none any more."""
    elements: int = Field(examples=[22])
    """How many elements it has; skills are not counted."""
    learned: int
    """How many things the robots were taught; they stay when a scene is loaded."""
    robots: list[SceneRobot]
    """Its robots."""
    goals: list[str] = Field(examples=[["InKit(Starter, kit_1)"]])
    """The goals that go with it."""


class LoadScene(Request):
    """Which scene to load."""

    name: str = Field(min_length=1, max_length=64, examples=["kitting"])
    """Name of a saved or installed scene."""


class SaveScene(Request):
    """Under which name to save the present scene."""

    name: str = Field(pattern=SCENE_NAME, examples=["my_cell"])
    """Small letters, digits, '_' and '-', 64 at most."""


class SceneDifference(Answer):
    """What makes the present scene of another one."""

    name: str = Field(examples=["kitting"])
    """The other scene."""
    version: int = Field(examples=[17])
    """Version of the world that was compared."""
    total: int = Field(examples=[2])
    """How many edits there are; the rest is on further pages."""
    edits: list[dict[str, Any]]
    """The edits, as in the world's history."""
    lines: list[str] = Field(examples=[["~ starter_1 sk:in pallet_a -> sk:in kit_1_a"]])
    """The same for people: what came (+), went (-), became another (~)."""
    next: str | None = None
    """Cursor of the next page; null on the last one."""


_FAR = 1000.0
"""Greatest distance from the map's origin that makes sense for a cell [m]."""

Coordinate = Annotated[float, Field(ge=-_FAR, le=_FAR, allow_inf_nan=False)]
Position = tuple[Coordinate, Coordinate, Coordinate]
"""(x, y, z) in the map [m]."""


class SimulationState(Answer):
    """How the simulated, or pretended, world goes on."""

    driver: str
    """What is behind the robots: "pybullet", "fake", or a driver's name."""
    simulates: bool
    """Whether physics is simulated: only then are there bodies and pictures."""
    running: bool
    """Whether its time goes on; false while everything is halted."""
    halted: str = Field(examples=[""])
    """Reason of the halt; empty if nothing is halted."""
    resting: bool
    """Whether nothing is under way, so that a scene can be loaded or reset."""
    pace: float | None = Field(examples=[1.0])
    """Simulated seconds per second; null: in lockstep, as fast as possible."""
    time: float = Field(examples=[12.5])
    """Simulated time since the start [s]."""
    cycle: int = Field(examples=[2500])
    """Control cycles since the start."""
    period: float = Field(examples=[0.005])
    """Length of a control cycle [s]."""
    stuck: float = Field(examples=[0.004])
    """For how long the cycle has not come round [s]."""
    stale: list[str] = Field(examples=[[]])
    """What was changed so that only a reset brings it about, such as a robot's place."""


class SimulatedBody(Answer):
    """Where something really is in the simulation; robots never get to know it."""

    id: str = Field(examples=["starter_1"])
    """Id of the element."""
    type: str = Field(examples=["kitting:Starter"])
    """Its class."""
    position: list[float] = Field(examples=[[0.5, 0.25, 0.4]])
    """(x, y, z) in the map [m]."""
    orientation: list[float] = Field(examples=[[0.0, 0.0, 0.0, 1.0]])
    """Quaternion (x, y, z, w)."""
    place: str | None = Field(examples=["pallet_a"])
    """What it really is in, on, or held by; null for what never moves."""
    believed: bool
    """Whether there is an element of that id in the world model."""


class Bodies(Answer):
    """All bodies of the simulation."""

    time: float = Field(examples=[12.5])
    """Simulated time [s]."""
    items: list[SimulatedBody]
    """The bodies, by id."""


class BodyPose(Request):
    """Where to put a body."""

    position: Position = Field(examples=[[0.5, 0.25, 0.4]])
    """(x, y, z) in the map [m]."""
    orientation: Rotation = Field(default=(0.0, 0.0, 0.0, 1.0), examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion (x, y, z, w)."""


class NewPace(Request):
    """How fast to go on."""

    pace: float = Field(ge=0.05, le=20.0, allow_inf_nan=False, examples=[2.0])
    """Simulated seconds per second."""


class Pace(Answer):
    """How fast simulated time goes on."""

    pace: float = Field(examples=[2.0])
    """Simulated seconds per second."""
