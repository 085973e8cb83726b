"""Devices of any kind, what they say, and the signals of the cell."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from skiros_py.api.wire import Answer, Request

Number = Annotated[float, Field(allow_inf_nan=False)]
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


class CellSignal(SignalInfo):
    """A signal of the cell: of a device, computed, or set from outside."""

    name: str = Field(description="Its name, as conditions and expressions use it.", examples=["gripper_1.force"])
    length: int | None = Field(description="Number of values of a computed vector; null for any other.", examples=[3])
    source: str = Field(description="Device or provider that gives it.", examples=["gripper_1"])
    input: bool = Field(description="Whether it can be set.", examples=[False])


class SignalReading(Answer):
    """The value of a signal in one cycle."""

    value: SignalValue | None = Field(description="The value; null where it has none.", examples=[30.0])
    reason: str = Field(description="Why it has no value; empty where it has one.", examples=[""])


class SignalReadings(Answer):
    """Values of signals in one control cycle."""

    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    signals: dict[str, SignalReading] = Field(description="The values by the names of the signals.")


class SetSignal(Request):
    """A new value of a signal."""

    value: bool | Number | tuple[Number, ...] = Field(description="The value, in its unit.", examples=[0.3])
