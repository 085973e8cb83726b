"""What robots were taught."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Learned(BaseModel):
    """Something that a robot was taught, and keeps beyond this scene."""

    model_config = ConfigDict(frozen=True, populate_by_name=True)

    id: str = Field(description="Its id.", examples=["learned:taught_grasp_1"])
    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="Its class.", examples=["sk:TaughtGrasp"]
    )
    label: str = Field(description="What people call it.")
    about: str | None = Field(description="The class of things that it is about.", examples=["kitting:Starter"])
    properties: dict[str, Any] = Field(description="What it says: values by property.")
    version: int = Field(description="Number of the change that touched it last; its ETag.", examples=[17])


class LearnedPage(BaseModel):
    """Some of what was learned, in the order of ids."""

    model_config = ConfigDict(frozen=True)

    items: list[Learned] = Field(description="What was learned.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")
