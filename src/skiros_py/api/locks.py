"""Locks: who alone may edit an element, and until when."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from skiros_py.api.values import ElementId


class Lock(BaseModel):
    """Somebody's right to be the only person or job that edits an element."""

    model_config = ConfigDict(frozen=True)

    element: str = Field(description="Id of the element; its pieces are locked with it.", examples=["kit_1"])
    owner: str = Field(description="Who has it.", examples=["ann"])
    until: datetime = Field(description="When it ends by itself (UTC).")
    seconds: float = Field(description="In how long that is [s].", examples=[59.2])


class LockList(BaseModel):
    """The locks in force, by element."""

    model_config = ConfigDict(frozen=True)

    items: list[Lock] = Field(description="The locks.")


class LockOrder(BaseModel):
    """What is to be locked."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", json_schema_extra={"examples": [{"elements": ["kit_1"], "seconds": 60.0}]}
    )

    elements: Annotated[list[ElementId], Field(min_length=1, max_length=1000)] = Field(
        description="Ids of the elements: all are locked, or none.", examples=[["kit_1"]]
    )
    seconds: Annotated[float, Field(gt=0.0, le=86400.0, allow_inf_nan=False)] = Field(
        default=60.0, description="After how long the locks end by themselves [s]; at most a day."
    )
