"""Tasks: what the robots pursue, of jobs and beside them; and sequences of steps that a person edits and runs."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.jobs import JobPolicy, PlannedStep
from skiros_py.api.wire import Answer, Moment, Name, Request

_MOST_STEPS = 100
GoalText = Annotated[str, Field(min_length=1, max_length=10_000)]
Word = Annotated[str, Field(min_length=1, max_length=300)]


class WantedStep(Request):
    """One step that somebody wants: a skill with its arguments."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]}
    )

    skill: Word = Field(description="Name of the skill.", examples=["drive"])
    arguments: dict[Word, Word] = Field(
        default_factory=dict,
        max_length=50,
        description="Element ids by parameter key; what is left out is inferred when the step starts.",
        examples=[{"Location": "pallet_a"}],
    )


class NewTask(Request):
    """What shall be done at once, apart from the queue of jobs: a goal, or steps as they are."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"goal": ["InKit(Starter, kit_1)"]},
                {"steps": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]},
            ]
        }
    )

    goal: list[GoalText] | None = Field(
        None,
        min_length=1,
        max_length=100,
        description="Conditions that shall hold together.",
        examples=[["InKit(Starter, kit_1)"]],
    )
    steps: list[WantedStep] | None = Field(
        None, min_length=1, max_length=_MOST_STEPS, description="Steps to be run in this order, without planning."
    )
    iterate: int | None = Field(1, ge=1, le=1_000_000, description="Steps: how often; null for until it is stopped.")
    anyway: bool = Field(False, description="Steps: true to run what cannot work as far as anybody knows.")
    policy: JobPolicy = Field(default=JobPolicy(), description="What happens when something cannot be reached.")

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if (self.goal is None) == (self.steps is None):
            raise ValueError("give either goal or steps")
        return self


class TaskStep(Answer):
    """One step that was started."""

    number: int = Field(description="Counts the steps of the task.", examples=[1])
    skill: str = Field(description="The skill.", examples=["drive"])
    arguments: dict[str, str] = Field(description="With what, by parameter.", examples=[{"Location": "pallet_a"}])
    agent: str = Field(description="Id of the subsystem that does it.", examples=["base_1"])
    start: float = Field(description="Run time [s].", examples=[3.2])
    end: float | None = Field(description="Run time [s]; null while it runs.", examples=[17.2])
    ended: str | None = Field(description="ended, failed or broken off; null while it runs.", examples=["ended"])
    text: str = Field(description="What came of it, in a sentence.", examples=["drive pallet_a: done"])


class TaskQuestion(Answer):
    """What a task waits for a person to answer."""

    id: int = Field(description="Number of the question.", examples=[1])
    text: str = Field(description="The question.", examples=["starter_1 cannot be picked. What shall become of it?"])
    options: tuple[str, ...] = Field(description="The answers.", examples=[["retry", "done by hand", "skip", "abort"]])


class TaskReport(Answer):
    """What came of a task."""

    outcome: str = Field(
        description="reached, held already, partly reached, not reached, no plan or stopped.", examples=["reached"]
    )
    reached: bool = Field(description="True when every condition holds and nothing ended it before its time.")
    simulated: float = Field(description="Run time used [s].", examples=[158.6])
    wall: float = Field(description="Wall time used [s].", examples=[12.0])
    conditions: tuple[dict[str, Any], ...] = Field(description="What became of each condition.")
    no_plan: tuple[str, ...] = Field(description="Why there was no plan from the start.")
    fault: str = Field(description="Why it ended before its time; empty in good times.", examples=[""])


class TaskInfo(Answer):
    """A task, under way or over."""

    name: str = Field(description="Its name; that of a job is the job's id.", examples=["task 1"])
    status: str = Field(description="planning, running, paused, waiting (for a person) or ended.", examples=["running"])
    job: str = Field(description="Id of the job that it is of; empty for none.", examples=[""])
    by: str = Field(description="Who began it; empty where a job did.", examples=["anna"])
    begun: Moment = Field(description="When.")
    goal: tuple[str, ...] = Field(
        description="Its conditions; none for a sequence.", examples=[["InKit(Starter, kit_1)"]]
    )
    plan: tuple[PlannedStep, ...] = Field(description="The present plan, or the last one.")
    steps: tuple[TaskStep, ...] = Field(description="What was started, oldest first; of very many the last.")
    question: TaskQuestion | None = Field(description="What it asks a person; null while it does not.")
    report: TaskReport | None = Field(description="What came of it; null until it is over.")


class Tasks(Answer):
    """Tasks, the youngest first."""

    items: tuple[TaskInfo, ...] = Field(description="The tasks, without their steps.")


class TaskTrace(Answer):
    """What happened in a task."""

    entries: tuple[dict[str, Any], ...] = Field(description="Oldest first: time [s], what, text, step, skill, data.")
    forgotten: int = Field(description="How many entries before these are kept no more.", examples=[0])


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
