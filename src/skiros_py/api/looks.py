"""What the robots saw and what they are about to do: for pictures, the latest only."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.state import PoseInfo
from skiros_py.api.wire import Answer


class Seen(Answer):
    """One thing that was recognised, or not."""

    type: str | None = Field(description="Its class; null for what fits no known shape.", examples=["kitting:Starter"])
    pose: PoseInfo = Field(description="Where it is in the map.")
    size: tuple[float, float, float] = Field(description="Length, width, height of the box around it [m].")
    cost: float = Field(description="Mean misfit of the shape [m]; smaller is better.", examples=[0.0011])
    margin: float = Field(description="By how much the next best shape fits worse [m].", examples=[0.004])


class Look(Answer):
    """The last picture that a camera took for somebody, as points."""

    number: int = Field(description="Counts the looks of this camera; 0 when there was none yet.", examples=[3])
    camera: str = Field(description="The camera.", examples=["camera_1"])
    time: float = Field(description="When it was taken [s, run time].", examples=[21.4])
    pose: PoseInfo | None = Field(description="Where the camera was in the map; z looks forward. Null for no look yet.")
    points: str = Field(description="What it saw: x, y, z in the map [m] as little-endian 32-bit floats, in base64.")
    colours: str = Field(description="Red, green, blue of each point (0 to 255) as bytes, in base64; empty for none.")
    seen: tuple[Seen, ...] = Field(description="What was made out in it.")
    purpose: str = Field(description="What the look was for: parts, or a kit's exact pose.", examples=["parts"])


class Waypoint(Answer):
    """A point on a base's way."""

    x: float = Field(description="In the map [m].", examples=[1.2])
    y: float = Field(description="In the map [m].", examples=[0.4])
    heading: float = Field(description="Heading in the map [rad].", examples=[1.57])


class ArmWay(Answer):
    """Where an arm's tool is about to go."""

    arm: str = Field(description="The arm.", examples=["arm_1"])
    points: tuple[tuple[float, float, float], ...] = Field(description="The tip's positions in the map [m].")


class RobotMotion(Answer):
    """What a robot is about to do, or did last."""

    number: int = Field(description="Counts the plans of this robot; 0 when there was none yet.", examples=[7])
    base: tuple[Waypoint, ...] = Field(description="The base's way; empty where it stands.")
    arms: tuple[ArmWay, ...] = Field(description="The arms' ways; empty where they stand.")
