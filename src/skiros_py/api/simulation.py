"""The simulation on the wire: what only a simulated world can be asked for, apart from what robots believe."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, field_validator

from skiros_py.api.wire import Answer, Request

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
