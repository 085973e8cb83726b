"""Scenes on the wire: those that can be loaded, and the present one."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

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
