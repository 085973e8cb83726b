"""What a job looked like, to be shown again."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from skiros_py.api.view import WorldView
from skiros_py.api.wire import Answer


class ReplayDevice(Answer):
    """A device, moment by moment."""

    states: tuple[dict[str, Any], ...] = Field(description="What it said, as `GET /devices/{id}/state` has it.")
    poses: tuple[tuple[float, ...], ...] | None = Field(
        description="Its frame in the map: x, y, z [m] and a quaternion x, y, z, w; null where it has none of its own."
    )


class ReplayFrames(Answer):
    """Where the devices were, at the same moments each."""

    times: tuple[float, ...] = Field(
        description="The moments, ascending [s, run time]; none while nothing moves, apart from the first and the last."
    )
    arms: dict[str, tuple[tuple[float, ...], ...]] = Field(description="Joint angles [rad] by arm, moment by moment.")
    grippers: dict[str, tuple[float, ...]] = Field(description="Distance between the fingers [m] by gripper.")
    bases: dict[str, tuple[tuple[float, float, float], ...]] = Field(description="x [m], y [m], heading [rad] by base.")
    devices: dict[str, ReplayDevice] = Field(default_factory=dict, description="Devices of all other kinds, by id.")


class ReplayChange(Answer):
    """What looked different from a moment on."""

    time: float = Field(description="When [s, run time].", examples=[23.1])
    author: str = Field(description="Who changed it; empty where it is the world as it was found.", examples=["pick"])
    anew: bool = Field(
        default=False,
        description="True where the view is of the whole world, and what is not in it is gone: the job was held, or"
        " cut off by a restart, and goes on.",
    )
    view: WorldView = Field(
        description="The elements that look different, and those that are gone; of the shapes those that did not come"
        " before."
    )


class Replay(Answer):
    """A job from its first step to its end."""

    job: str = Field(description="Id of the job.", examples=["kit-17"])
    start: float = Field(description="When it began [s, run time].", examples=[0.3])
    end: float = Field(description="When it ended; while it runs, how far it is kept [s, run time].", examples=[158.6])
    complete: bool = Field(
        description="Whether it is over and all of it is there; else it still runs or is held, or something is"
        " missing: it was cut off, or is too much to be kept."
    )
    shifts: tuple[tuple[float, float], ...] = Field(
        default=(),
        description="Run time begins again with the server: from the first number on [s], all times in here are later"
        " by the second [s] than run time was.",
    )
    beginning: WorldView = Field(description="The world at the beginning, or at the start of the range asked for.")
    frames: ReplayFrames = Field(
        description="Where the robots were; of a range also the last frame before it and the first one after it."
    )
    changes: tuple[ReplayChange, ...] = Field(description="What changed after that, in order.")
