"""Whether a server is alive and ready."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer


class Health(Answer):
    """Whether the server is alive."""

    alive: bool = Field(description="True while the control cycle goes round.", examples=[True])
    why: str = Field(default="", description="What is wrong; empty in good times.")


class Readiness(Answer):
    """Whether orders can be fulfilled."""

    ready: bool = Field(description="True while the station is open and what is ordered can be kept.", examples=[True])
    halted: bool = Field(default=False, description="True while everything is halted: orders are kept and wait.")
    why: str = Field(default="", description="What is wrong; empty in good times.")
