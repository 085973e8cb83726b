"""Sequences: steps that a person puts together, changes and runs, over and over if wanted."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.tasks import GoalText, WantedStep
from skiros_py.api.wire import Answer, Name, Request

_MOST_STEPS = 100


class CheckedStep(Answer):
    """A step, with what is known of it before it runs."""

    skill: str = Field(description="Name of the skill.", examples=["drive"])
    arguments: dict[str, str] = Field(description="Element ids by parameter key, as given.")
    agent: str = Field(description="Who would do it; empty where nobody is found.", examples=["base_1"])
    works: bool = Field(description="True when nothing speaks against it.")
    problems: tuple[str, ...] = Field(description="What will not hold when its turn comes, a sentence each.")


class SequenceSummary(Answer):
    """A sequence."""

    id: str = Field(description="Its id.", examples=["kit-round"])
    title: str = Field(description="Its name for people.", examples=["One round to the kit"])
    version: int = Field(description="Grows with every change; the same as the ETag.", examples=[3])
    count: int = Field(description="How many steps it has.", examples=[4])


class SequenceInfo(SequenceSummary):
    """A sequence with its steps, each checked as things are now and as the steps before it leave them."""

    works: bool = Field(description="True when it can be run: it has steps, and nothing speaks against any.")
    steps: tuple[CheckedStep, ...] = Field(description="The steps, in order.")


class Sequences(Answer):
    """The sequences of a server."""

    items: tuple[SequenceSummary, ...] = Field(description="By id.")


class NewSequence(Request):
    """A sequence from scratch, or from a plan: at most one of steps, goal, job, task, preview."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"title": "One drive", "steps": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]},
                {"goal": ["InKit(Starter, kit_1)"]},
            ]
        }
    )

    id: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$")] | None = Field(
        None, description="Chosen by the caller; else the server makes one.", examples=["kit-round"]
    )
    title: str = Field("", max_length=200, description="Its name for people.", examples=["One round to the kit"])
    steps: list[WantedStep] | None = Field(None, max_length=_MOST_STEPS, description="The steps.")
    goal: list[GoalText] | None = Field(
        None, min_length=1, max_length=100, description="Conditions: the steps are those of a plan for them."
    )
    job: Name | None = Field(None, description="Id of a job: the steps are those of its last plan.")
    task: Name | None = Field(None, description="Name of a task: the steps are those of its last plan.")
    preview: Name | None = Field(None, description="Id of a preview: the steps are those of its plan.")

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if sum(one is not None for one in (self.steps, self.goal, self.job, self.task, self.preview)) > 1:
            raise ValueError("give at most one of steps, goal, job, task and preview")
        return self


class InsertStep(WantedStep):
    """A step, and before which other one it comes."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"skill": "drive", "arguments": {"Location": "kit_1"}, "at": 0}]}
    )

    at: int | None = Field(None, ge=0, le=_MOST_STEPS, description="Index, from 0; the end where left out.")


class MoveStep(Request):
    """Where a step shall be."""

    to: int = Field(ge=0, lt=_MOST_STEPS, description="Its index afterwards, from 0.", examples=[0])


class RunSequence(Request):
    """How a sequence is run."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"iterate": 1}, {"iterate": None}]})

    iterate: int | None = Field(1, ge=1, le=1_000_000, description="How often; null for until it is stopped.")
    anyway: bool = Field(False, description="True to run what cannot work as far as anybody knows.")
