"""Stopping on the wire."""

from __future__ import annotations

from datetime import datetime

from pydantic import Field

from skiros_py.api.wire import Answer, Request


class StopRequest(Request):
    """Why everything shall stop; may be left out."""

    reason: str = Field(
        default="", max_length=1000, description="Why, for a person.", examples=["a person is in the cell"]
    )


class StopInfo(Answer):
    """Whether everything is halted."""

    halted: bool = Field(description="Whether nothing may move until somebody resets it.", examples=[True])
    why: str = Field(default="", description="Why; empty where nothing is.", examples=["a person is in the cell"])
    by: str = Field(
        default="",
        description="Who wanted it; empty where it was the watchdog or a module.",
        examples=["panel at the door"],
    )
    since: datetime | None = Field(
        default=None, description="Since when; null while nothing is halted.", examples=["2026-11-20T09:30:00.125Z"]
    )
    standing: bool | None = Field(
        description="Whether all arms and bases stand; null if unknown: the control thread does not run.",
        examples=[True],
    )
    obeyed: bool = Field(
        description="Whether the control thread has come round since. If not, do not rely on it: press the button of"
        " the machine.",
        examples=[True],
    )
