"""Devices of any kind: what they are, what they say."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from skiros_py.api.wire import Answer

SignalValue = bool | float | tuple[float, ...]
"""A truth value, a number, or numbers."""


class SignalInfo(Answer):
    """A value that a device offers in each cycle."""

    name: str = Field(description="Its name, as conditions use it.", examples=["force"])
    unit: str = Field(description="Its unit; empty for truth values and pure numbers.", examples=["N"])
    frame: str = Field(description='"map", "own" for the frame of the device; empty where none matters.', examples=[""])
    help: str = Field(description="Its meaning.", examples=["force per finger"])


class DeviceInfo(Answer):
    """One device."""

    id: str = Field(description="Its id.", examples=["gripper_1"])
    kind: str = Field(description="Its kind.", examples=["gripper"])
    robot: str | None = Field(description="The robot that it belongs to; null for none.", examples=["robot_1"])
    description: dict[str, Any] = Field(
        description="What is known of it, by the names that its kind uses.", examples=[{"max_gap": 0.08}]
    )
    signals: tuple[SignalInfo, ...] = Field(description="The values that it offers.")
    open: bool = Field(description="Whether it may be used; false after it was closed.", examples=[True])
    commanded: bool = Field(description="Whether it takes commands; false for a sensor.", examples=[True])
    jog: str = Field(description="Module that moves it by a little; empty for none.", examples=["gripper_control"])
    teach: str = Field(description="Module that teaches a pose with it; empty for none.", examples=[""])


class DeviceReading(Answer):
    """A device at one moment."""

    id: str = Field(description="Its id.", examples=["gripper_1"])
    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    still: bool = Field(description="Whether it stands, so that a stop need not wait for it.", examples=[True])
    state: dict[str, Any] | None = Field(
        description="What it says, by the names that its kind uses; null for one that is only asked, a camera.",
        examples=[{"gap": 0.051, "force": 30.0, "still": True}],
    )
    signals: dict[str, SignalValue] = Field(
        description="The values that it offers, by name.", examples=[{"gap": 0.051, "force": 30.0}]
    )
