"""Tasks: what the robots pursue, of jobs and beside them."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.jobs import JobPolicy, PlannedStep
from skiros_py.api.wire import Answer, Items, Moment, Name, Request

_MOST_STEPS = 100
GoalText = Annotated[str, Field(min_length=1, max_length=10_000)]
Word = Annotated[str, Field(min_length=1, max_length=300)]


class WantedStep(Request):
    """One step that somebody wants: a skill with its arguments."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]}
    )

    skill: Word = Field(examples=["drive"])
    """Name of the skill."""
    arguments: dict[Word, Word] = Field(default_factory=dict, max_length=50, examples=[{"Location": "pallet_a"}])
    """Element ids by parameter key; what is left out is inferred when the step starts."""


class NewTask(Request):
    """A goal, or steps without planning, to be started at once, apart from the queue of jobs."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"goal": ["InKit(Starter, kit_1)"]},
                {"steps": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]},
                {"sequence": "kit-round", "iterate": None},
            ]
        }
    )

    goal: list[GoalText] | None = Field(None, min_length=1, max_length=100, examples=[["InKit(Starter, kit_1)"]])
    """Conditions that shall hold together."""
    steps: list[WantedStep] | None = Field(None, min_length=1, max_length=_MOST_STEPS)
    """Steps to be run in this order, without planning."""
    sequence: Name | None = Field(None, examples=["kit-round"])
    """Id of a document of kind `sequence`, whose steps are run."""
    iterate: int | None = Field(1, ge=1, le=1_000_000)
    """Steps: how often; null for until it is stopped."""
    anyway: bool = False
    """Steps: true to run what cannot work as far as anybody knows."""
    policy: JobPolicy = JobPolicy()
    """How to proceed if part of the goal cannot be reached."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if sum(one is not None for one in (self.goal, self.steps, self.sequence)) != 1:
            raise ValueError("give one of goal, steps and sequence")
        return self


class TaskStep(Answer):
    """One step that was started."""

    number: int = Field(examples=[1])
    """Counts the steps of the task."""
    skill: str = Field(examples=["drive"])
    """The skill."""
    arguments: dict[str, str] = Field(examples=[{"Location": "pallet_a"}])
    """Arguments by parameter."""
    agent: str = Field(examples=["base_1"])
    """Id of the subsystem that does it."""
    start: float = Field(examples=[3.2])
    """Run time [s]."""
    end: float | None = Field(examples=[17.2])
    """Run time [s]; null while it runs."""
    ended: str | None = Field(examples=["ended"])
    """ended, failed or cancelled; null while it runs."""
    text: str = Field(examples=["drive pallet_a: done"])
    """What came of it, in a sentence."""


class TaskQuestion(Answer):
    """What a task waits for a person to answer."""

    id: int = Field(examples=[1])
    """Number of the question."""
    text: str = Field(examples=["starter_1 cannot be picked. What shall become of it?"])
    """The question."""
    options: tuple[str, ...] = Field(examples=[["retry", "done by hand", "skip", "abort"]])
    """The answers."""


class TaskReport(Answer):
    """What came of a task."""

    outcome: str = Field(examples=["reached"])
    """reached, held already, partly reached, not reached, no plan or stopped."""
    reached: bool
    """True when every condition holds and nothing ended it before its time."""
    simulated: float = Field(examples=[158.6])
    """Run time used [s]."""
    wall: float = Field(examples=[12.0])
    """Wall time used [s]."""
    conditions: tuple[dict[str, Any], ...]
    """Outcome of each condition."""
    no_plan: tuple[str, ...]
    """Why there was no plan from the start."""
    fault: str = Field(examples=[""])
    """Why it ended before its time; empty in good times."""


class TaskInfo(Answer):
    """A task, under way or over."""

    name: str = Field(examples=["task 1"])
    """Its name; that of a job is the job's id."""
    status: str = Field(examples=["running"])
    """planning, running, paused, waiting (for a person) or ended."""
    job: str = Field(examples=[""])
    """Id of the job that it is of; empty for none."""
    by: str = Field(examples=["anna"])
    """Who began it; empty where a job did."""
    begun: Moment
    """When."""
    goal: tuple[str, ...] = Field(examples=[["InKit(Starter, kit_1)"]])
    """Its conditions; none for a sequence."""
    plan: tuple[PlannedStep, ...]
    """The present plan, or the last one."""
    steps: tuple[TaskStep, ...]
    """What was started, oldest first; of very many the last."""
    question: TaskQuestion | None
    """What it asks a person; null while it does not."""
    report: TaskReport | None
    """Its outcome; null until it is over."""


Tasks = Items[TaskInfo]
"""Tasks, the youngest first."""


class TaskTrace(Answer):
    """What happened in a task."""

    entries: tuple[dict[str, Any], ...]
    """Oldest first: time [s], what, text, step, skill, data."""
    forgotten: int = Field(examples=[0])
    """How many entries before these are kept no more."""
