"""Previews of goals and jobs: plans made without running them, and repairs where there is none."""

from __future__ import annotations

import enum
from typing import Any

from pydantic import Field

from skiros_py.api.jobs import PlannedStep
from skiros_py.api.wire import Answer, Moment, Page, Sentence, Told


class PreviewState(enum.StrEnum):
    """State of a preview."""

    PLANNING = "planning"
    """It is being planned."""
    PLANNED = "planned"
    """There is a plan."""
    NO_PLAN = "no plan"
    """There is no plan; causes and repairs say why, and what would help."""
    FAILED = "failed"
    """Planning failed, or was ended by the server."""


class Exchange(Answer):
    """A condition of the goal to be replaced."""

    condition: str = Field(examples=["ObjectAtLocation(Starter, kit_1_a)"])
    """The condition."""
    by: str = Field(examples=["ObjectAtLocation(Starter, kit_1_d)"])
    """Its replacement."""


class Repair(Answer):
    """A minimal change after which there would be a plan."""

    id: int = Field(examples=[0])
    """Its number in this preview."""
    text: Sentence = Field(examples=["put starter_1 in pallet_a"])
    """Description."""
    edits: tuple[Sentence, ...]
    """The changes to the world."""
    without: tuple[str, ...]
    """Conditions to remove from the goal."""
    instead: tuple[Exchange, ...]
    """Conditions to replace."""
    elements: tuple[str, ...]
    """Ids of the elements in its changes of the world."""
    applicable: bool
    """Whether it has changes of the world, which the server can apply."""


class Preview(Told):
    """A goal that is planned but not executed."""

    id: str = Field(examples=["17"])
    """Its id."""
    state: PreviewState
    """Its state."""
    goal: tuple[str, ...]
    """The goal texts."""
    conditions: tuple[str, ...]
    """The parsed conditions."""
    world: int = Field(examples=[42])
    """Version of the world for which it was planned."""
    asked: Moment | None
    """When it was requested."""
    wall: float | None
    """How long planning took [s]; null while it lasts."""
    planner: str
    """Name of the planner; empty if none was needed."""
    steps: tuple[PlannedStep, ...]
    """The plan; empty if there is none, or nothing needs to be done."""
    seconds: float | None
    """Expected time until all steps have succeeded [s]; null if unknown."""
    chance: float | None
    """Probability that all steps succeed at the first attempt; null if nothing was learned about them."""
    reasons: tuple[Sentence, ...]
    """Why there is no plan, or why planning failed."""
    causes: tuple[dict[str, Any], ...]
    """The same as data: kind, text, conditions, elements, …."""
    repairs: tuple[Repair, ...]
    """What would help."""
    notes: tuple[str, ...]
    """Faults of planners that were tried before."""


PreviewPage = Page[Preview]
"""The stored previews, newest first."""


class AppliedRepair(Told):
    """Result of a repair."""

    text: Sentence = Field(examples=["put starter_1 in pallet_a"])
    """Description of the change."""
    world: int = Field(examples=[43])
    """Version of the world after it."""
