"""Scenes on the wire: those that can be loaded, the current one, and the simulation of it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, StrictFloat

from skiros_py.api.view import OfCycle
from skiros_py.api.wire import Answer, Page, Request
from skiros_py.api.world import Rotation

SCENE_NAME = r"^[a-z0-9][a-z0-9_-]{0,63}$"
"""Pattern of names of saved scenes: valid file names on all systems."""

Source = Literal["installed", "saved"]


class SceneEntry(Answer):
    """A loadable scene in a list."""

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


class SceneContent(Answer):
    """What a scene is about."""

    name: str = Field(examples=["kitting"])
    """Its name; of the current one the scene that was loaded or saved last, empty for an upload."""
    version: int = Field(examples=[17])
    """Its ETag: the checksum of its file, or the version of the world."""
    elements: int = Field(examples=[22])
    """Number of its elements, without skills."""
    robots: list[SceneRobot]
    """Its robots."""
    goals: list[str] = Field(examples=[["InKit(Starter, kit_1)"]])
    """Goals stored with it."""


class Scene(SceneContent):
    """A loadable scene."""

    source: Source
    """"saved" in this data directory, or "installed" with a package."""
    title: str = Field(examples=["kitting"])
    """Its title; its name if it has none."""


class CurrentScene(SceneContent):
    """The current scene, as believed."""

    changed: bool | None = Field(examples=[True])
    """Whether it differs from the scene of that name; null if that no longer exists."""
    learned: int
    """Number of learned concepts; they persist when a scene is loaded."""


class LoadScene(Request):
    """The scene to load."""

    name: str = Field(min_length=1, max_length=64, examples=["kitting"])
    """Name of a saved or installed scene."""


class SaveScene(Request):
    """The name under which the current scene is saved."""

    name: str = Field(pattern=SCENE_NAME, examples=["my_cell"])
    """Up to 64 lower-case letters, digits, '_' and '-'."""


class SceneDifference(Page[dict[str, Any]]):
    """Edits that turn another scene into the current one, as in the world's history."""

    name: str = Field(examples=["kitting"])
    """The other scene."""
    version: int = Field(examples=[17])
    """Version of the compared world."""
    total: int = Field(examples=[2])
    """Total number of edits, on all pages."""
    lines: list[str] = Field(examples=[["~ starter_1 sk:in pallet_a -> sk:in kit_1_a"]])
    """The edits as text: added (+), removed (-), changed (~)."""


_FAR = 1000.0
"""Maximum coordinate of a body in the map [m]."""

Coordinate = Annotated[float, Field(ge=-_FAR, le=_FAR, allow_inf_nan=False)]
Position = tuple[Coordinate, Coordinate, Coordinate]
"""(x, y, z) in the map [m]."""


class SimulationState(OfCycle):
    """State of the simulation, or of the fake driver, by simulated time since the start."""

    driver: str
    """Name of the driver: "pybullet", "fake", …."""
    simulates: bool
    """Whether physics is simulated; otherwise there are no bodies and images."""
    running: bool
    """Whether its time advances; false while everything is halted."""
    halted: str = Field(examples=[""])
    """Reason of the halt; empty if nothing is halted."""
    resting: bool
    """Whether nothing runs, so that a scene can be loaded or reset."""
    pace: float | None = Field(examples=[1.0])
    """Simulated time per wall time; null in lockstep, as fast as possible."""
    period: float = Field(examples=[0.005])
    """Length of a control cycle [s]."""
    stuck: float = Field(examples=[0.004])
    """Time since the control cycle last completed [s, wall time]."""
    stale: list[str] = Field(examples=[[]])
    """Changes that take effect only after a reset, such as another place of a robot."""


class SimulatedBody(Answer):
    """The true pose of a body in the simulation, which robots do not know."""

    id: str = Field(examples=["starter_1"])
    """Id of the element."""
    type: str = Field(examples=["kitting:Starter"])
    """Its class."""
    position: list[float] = Field(examples=[[0.5, 0.25, 0.4]])
    """(x, y, z) in the map [m]."""
    orientation: list[float] = Field(examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion (x, y, z, w), in the map."""
    place: str | None = Field(examples=["pallet_a"])
    """Id of the element that it is really in, on, or held by; null for bodies that never move."""
    believed: bool
    """Whether the world model has an element of that id."""


class Bodies(Page[SimulatedBody]):
    """All bodies of the simulation, by id."""

    time: float = Field(examples=[12.5])
    """Simulated time [s]."""


class BodyPose(Request):
    """The new pose of a body."""

    position: Position = Field(examples=[[0.5, 0.25, 0.4]])
    """(x, y, z) in the map [m]."""
    orientation: Rotation = Field(default=(0.0, 0.0, 0.0, 1.0), examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion (x, y, z, w), in the map; the identity if omitted."""


class NewPace(Request):
    """The new pace."""

    pace: StrictFloat = Field(ge=0.05, le=20.0, allow_inf_nan=False, examples=[2.0])
    """Simulated time per wall time."""


class Pace(Answer):
    """The pace of the simulation."""

    pace: float = Field(examples=[2.0])
    """Simulated time per wall time."""
