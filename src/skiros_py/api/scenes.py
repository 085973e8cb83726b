"""Scenes on the wire: those that can be loaded, the current one, and the simulation of it."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from skiros_py.api.wire import Answer, Request

SCENE_NAME = r"^[a-z0-9][a-z0-9_-]{0,63}$"
"""Names under which scenes are saved: safe as names of files everywhere."""

Source = Literal["installed", "saved"]


class SceneEntry(Answer):
    """A scene that can be loaded, as far as a list tells of it."""

    name: str = Field(description="Its name.", examples=["kitting"])
    source: Source = Field(description='"saved" in this data directory, or "installed" with a package.')
    saved: datetime | None = Field(default=None, description="When it was saved; null for an installed one.")


class Scenes(Answer):
    """Scenes, by name."""

    items: list[SceneEntry] = Field(description="The scenes.")
    next: str | None = Field(default=None, description="Cursor of the next page; null on the last one.")


class SceneRobot(Answer):
    """A robot of a scene."""

    id: str = Field(description="Its id.", examples=["robot_1"])
    label: str = Field(description="What people call it.", examples=["robot"])
    type: str = Field(description="Its class.", examples=["sk:Robot"])


class Scene(Answer):
    """What a scene that can be loaded consists of."""

    name: str = Field(description="Its name.", examples=["kitting"])
    source: Source = Field(description='"saved" in this data directory, or "installed" with a package.')
    version: int = Field(description="Tells versions of its file apart; as in the ETag.", examples=[2868123])
    title: str = Field(description="What it calls itself; its name where it does not.", examples=["kitting"])
    elements: int = Field(description="How many elements it has; skills are not counted.", examples=[22])
    robots: list[SceneRobot] = Field(description="Its robots.")
    goals: list[str] = Field(description="The goals that go with it.", examples=[["InKit(Starter, kit_1)"]])


class PresentScene(Answer):
    """The scene that robots act in now, as believed."""

    name: str = Field(description="The scene that was loaded or saved last; empty for an upload.", examples=["kitting"])
    version: int = Field(description="Version of the world, as in the ETag.", examples=[17])
    changed: bool | None = Field(
        description="Whether it differs from the scene of that name; null where there is none any more.",
        examples=[True],
    )
    elements: int = Field(description="How many elements it has; skills are not counted.", examples=[22])
    learned: int = Field(description="How many things the robots were taught; they stay when a scene is loaded.")
    robots: list[SceneRobot] = Field(description="Its robots.")
    goals: list[str] = Field(description="The goals that go with it.", examples=[["InKit(Starter, kit_1)"]])


class LoadScene(Request):
    """Which scene to load."""

    name: str = Field(
        min_length=1, max_length=64, description="Name of a saved or installed scene.", examples=["kitting"]
    )


class SaveScene(Request):
    """Under which name to save the present scene."""

    name: str = Field(
        pattern=SCENE_NAME, description="Small letters, digits, '_' and '-', 64 at most.", examples=["my_cell"]
    )


class SceneDifference(Answer):
    """What makes the present scene of another one."""

    name: str = Field(description="The other scene.", examples=["kitting"])
    version: int = Field(description="Version of the world that was compared.", examples=[17])
    total: int = Field(description="How many edits there are; the rest is on further pages.", examples=[2])
    edits: list[dict[str, Any]] = Field(description="The edits, as in the world's history.")
    lines: list[str] = Field(
        description="The same for people: what came (+), went (-), became another (~).",
        examples=[["~ starter_1 sk:in pallet_a -> sk:in kit_1_a"]],
    )
    next: str | None = Field(default=None, description="Cursor of the next page; null on the last one.")


_FAR = 1000.0
"""Greatest distance from the map's origin that makes sense for a cell [m]."""

Coordinate = Annotated[float, Field(ge=-_FAR, le=_FAR, allow_inf_nan=False)]
Component = Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)]
Position = tuple[Coordinate, Coordinate, Coordinate]
"""(x, y, z) in the map [m]."""
Quaternion = tuple[Component, Component, Component, Component]
"""(x, y, z, w)."""


class SimulationState(Answer):
    """How the simulated, or pretended, world goes on."""

    driver: str = Field(description='What is behind the robots: "pybullet", "fake", or a driver\'s name.')
    simulates: bool = Field(description="Whether physics is simulated: only then are there bodies and pictures.")
    running: bool = Field(description="Whether its time goes on; false while everything is halted.")
    halted: str = Field(description="Why everything is halted; empty while it is not.", examples=[""])
    resting: bool = Field(description="Whether nothing is under way, so that a scene can be loaded or reset.")
    pace: float | None = Field(
        description="Simulated seconds per second; null: in lockstep, as fast as possible.", examples=[1.0]
    )
    time: float = Field(description="Simulated time since the start [s].", examples=[12.5])
    cycle: int = Field(description="Control cycles since the start.", examples=[2500])
    period: float = Field(description="Length of a control cycle [s].", examples=[0.005])
    stuck: float = Field(description="For how long the cycle has not come round [s].", examples=[0.004])
    stale: list[str] = Field(
        description="What was changed so that only a reset brings it about, such as a robot's place.", examples=[[]]
    )


class SimulatedBody(Answer):
    """Where something really is in the simulation; robots never get to know it."""

    id: str = Field(description="Id of the element.", examples=["starter_1"])
    type: str = Field(description="Its class.", examples=["kitting:Starter"])
    position: list[float] = Field(description="(x, y, z) in the map [m].", examples=[[0.5, 0.25, 0.4]])
    orientation: list[float] = Field(description="Quaternion (x, y, z, w).", examples=[[0.0, 0.0, 0.0, 1.0]])
    place: str | None = Field(
        description="What it really is in, on, or held by; null for what never moves.", examples=["pallet_a"]
    )
    believed: bool = Field(description="Whether there is an element of that id in the world model.")


class Bodies(Answer):
    """All bodies of the simulation."""

    time: float = Field(description="Simulated time [s].", examples=[12.5])
    items: list[SimulatedBody] = Field(description="The bodies, by id.")


class BodyPose(Request):
    """Where to put a body."""

    position: Position = Field(description="(x, y, z) in the map [m].", examples=[[0.5, 0.25, 0.4]])
    orientation: Quaternion = Field(
        default=(0.0, 0.0, 0.0, 1.0), description="Quaternion (x, y, z, w).", examples=[[0.0, 0.0, 0.0, 1.0]]
    )

    @field_validator("orientation")
    @classmethod
    def _of_unit_length(cls, value: Quaternion) -> Quaternion:
        if not 0.99 < math.hypot(*value) < 1.01:
            raise ValueError("a quaternion (x, y, z, w) of length 1, such as [0, 0, 0, 1]")
        return value


class NewPace(Request):
    """How fast to go on."""

    pace: float = Field(
        ge=0.05, le=20.0, allow_inf_nan=False, description="Simulated seconds per second.", examples=[2.0]
    )


class Pace(Answer):
    """How fast simulated time goes on."""

    pace: float = Field(description="Simulated seconds per second.", examples=[2.0])
