"""Tasks: goals and sequences that robots execute, for jobs or started directly."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, StrictBool, StrictInt, model_validator

from skiros_py.api.jobs import JobPolicy, PlannedStep
from skiros_py.api.wire import Answer, Moment, Name, Page, Request, Sentence, Told

_MOST_STEPS = 100
GoalText = Annotated[str, Field(min_length=1, max_length=10_000)]
Word = Annotated[str, Field(min_length=1, max_length=300)]


class WantedStep(Request):
    """A requested step: a skill with its arguments."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"skill": "drive", "arguments": {"Location": "pallet_a"}}]}
    )

    skill: Word = Field(examples=["drive"])
    """Name of the skill."""
    arguments: dict[Word, Word] = Field(default_factory=dict, max_length=50, examples=[{"Location": "pallet_a"}])
    """Element ids by parameter key; omitted ones are inferred when the step starts."""


class NewTask(Request):
    """A goal, or steps without planning, started immediately and independently of the job queue."""

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
    """Conditions that must hold together."""
    steps: list[WantedStep] | None = Field(None, min_length=1, max_length=_MOST_STEPS)
    """Steps, executed in this order without planning."""
    sequence: Name | None = Field(None, examples=["kit-round"])
    """Id of a document of kind `sequence`, whose steps are executed."""
    iterate: StrictInt | None = Field(1, ge=1, le=1_000_000)
    """For steps: number of rounds; null to repeat until it is stopped."""
    anyway: StrictBool = False
    """For steps: whether to execute steps that are expected to fail."""
    policy: JobPolicy = JobPolicy()
    """How to proceed if part of the goal cannot be reached."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if sum(one is not None for one in (self.goal, self.steps, self.sequence)) != 1:
            raise ValueError("give one of goal, steps and sequence")
        return self


class TaskStep(Answer):
    """A started step."""

    number: int = Field(examples=[1])
    """Number of the step in the task, from 1."""
    skill: str = Field(examples=["drive"])
    """The skill."""
    arguments: dict[str, str] = Field(examples=[{"Location": "pallet_a"}])
    """Arguments by parameter."""
    agent: str = Field(examples=["base_1"])
    """Id of the subsystem that executes it."""
    start: float = Field(examples=[3.2])
    """When it started [s, run time]."""
    end: float | None = Field(examples=[17.2])
    """When it ended [s, run time]; null while it runs."""
    ended: str | None = Field(examples=["ended"])
    """ended, failed or cancelled; null while it runs."""
    text: Sentence = Field(examples=["drive pallet_a: done"])
    """Its result, in a sentence."""


class TaskQuestion(Answer):
    """A question of a task to a person."""

    id: int = Field(examples=[1])
    """Number of the question."""
    text: Sentence = Field(examples=["starter_1 cannot be picked. What shall become of it?"])
    """The question."""
    options: tuple[str, ...] = Field(examples=[["retry", "done by hand", "skip", "abort"]])
    """The possible answers."""


class TaskReport(Answer):
    """Result of a task."""

    outcome: str = Field(examples=["reached"])
    """reached, held already, partly reached, not reached, no plan or stopped."""
    reached: bool
    """Whether every condition holds and it was not cancelled."""
    simulated: float = Field(examples=[158.6])
    """Duration [s, run time]."""
    wall: float = Field(examples=[12.0])
    """Duration [s, wall time]."""
    conditions: tuple[dict[str, Any], ...]
    """Outcome of each condition."""
    no_plan: tuple[Sentence, ...]
    """Why there was no initial plan."""
    fault: Sentence = Field(examples=[""])
    """Why it was cancelled or failed; empty if it was not."""


class TaskInfo(Told):
    """A running or finished task."""

    name: str = Field(examples=["task 1"])
    """Its name; that of a job is the job's id."""
    status: str = Field(examples=["running"])
    """planning, running, paused, waiting (for a person) or ended."""
    job: str = Field(examples=[""])
    """Id of its job; empty if it has none."""
    by: str = Field(examples=["anna"])
    """Who started it; empty for a job's task."""
    begun: Moment
    """When it was started."""
    goal: tuple[str, ...] = Field(examples=[["InKit(Starter, kit_1)"]])
    """Its conditions; empty for a sequence."""
    plan: tuple[PlannedStep, ...]
    """The current plan, or the last one."""
    steps: tuple[TaskStep, ...]
    """The started steps, oldest first; if there are very many, the last ones."""
    question: TaskQuestion | None
    """Its open question to a person; null if there is none."""
    report: TaskReport | None
    """Its outcome; null until it is over."""


Tasks = Page[TaskInfo]
"""Tasks, newest first."""


class TaskTrace(Page[dict[str, Any]]):
    """Trace of a task, oldest entry first; each with time [s], what, text, step, skill, data."""

    forgotten: int = Field(examples=[0])
    """Number of earlier entries that are no longer stored."""
