"""Previews on the wire: what would be done for a goal, without doing it."""

from __future__ import annotations

import enum
from typing import Any

from pydantic import Field

from skiros_py.api.jobs import PlannedStep
from skiros_py.api.wire import Answer, Moment


class PreviewState(enum.StrEnum):
    """How far a preview is."""

    PLANNING = "planning"
    """It is being planned."""
    PLANNED = "planned"
    """There is a plan."""
    NO_PLAN = "no plan"
    """There is none; causes and repairs say why, and what would help."""
    FAILED = "failed"
    """The planner broke, or the server ended the work."""


class Exchange(Answer):
    """A condition of the goal that is to be wanted otherwise."""

    condition: str = Field(description="As it was wanted.", examples=["ObjectAtLocation(Starter, kit_1_a)"])
    by: str = Field(description="What to want instead.", examples=["ObjectAtLocation(Starter, kit_1_d)"])


class Repair(Answer):
    """A smallest change after which there would be a plan."""

    id: int = Field(description="Its number in this preview.", examples=[0])
    text: str = Field(description="What to do, in words.", examples=["put starter_1 in pallet_a"])
    edits: tuple[str, ...] = Field(description="The changes to the world.")
    without: tuple[str, ...] = Field(description="The conditions to take out of the goal.")
    instead: tuple[Exchange, ...] = Field(description="The conditions to want otherwise.")
    elements: tuple[str, ...] = Field(description="Ids of the elements that its changes to the world name.")
    applicable: bool = Field(description="Whether there are changes to the world in it, which the server can make.")


class Preview(Answer):
    """A goal, planned and not done."""

    id: str = Field(description="Its id.", examples=["17"])
    state: PreviewState = Field(description="How far it is.")
    goal: tuple[str, ...] = Field(description="What was wanted, as texts.")
    conditions: tuple[str, ...] = Field(description="The conditions, as they were understood.")
    world: int = Field(description="Version of the world for which it was planned.", examples=[42])
    asked: Moment | None = Field(description="When it was asked for.")
    wall: float | None = Field(description="How long planning took [s]; null while it lasts.")
    planner: str = Field(description="Name of the planner; empty if none was needed.")
    steps: tuple[PlannedStep, ...] = Field(description="The plan; empty where there is none, or nothing to be done.")
    reasons: tuple[str, ...] = Field(description="Why there is no plan, or why planning failed, in sentences.")
    causes: tuple[dict[str, Any], ...] = Field(description="The same as data: kind, text, conditions, elements, ….")
    repairs: tuple[Repair, ...] = Field(description="What would help.")
    notes: tuple[str, ...] = Field(description="What went wrong with planners that were asked before.")


class PreviewPage(Answer):
    """The previews that are kept, the latest first."""

    items: tuple[Preview, ...] = Field(description="The previews.")


class AppliedRepair(Answer):
    """What became of a repair."""

    text: str = Field(description="What was done.", examples=["put starter_1 in pallet_a"])
    world: int = Field(description="Version of the world after it.", examples=[43])
