"""Jobs on the wire (ISA-95 job control): what is ordered, commanded and read; and previews of their plans."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any

from pydantic import ConfigDict, Field

from skiros_py.api.goals import GoalOrder, Material, TemplateParameter
from skiros_py.api.wire import Answer, Items, Moment, Name, Page, Request, WantedMoment

COMMANDS = ("start", "revoke-start", "pause", "resume", "stop", "abort", "cancel", "clear")
"""What may be asked of a job: the last part of the address of each command."""

_PRIORITIES = 2**15


class StateName(enum.StrEnum):
    """The states of ISA-95 job control."""

    NOT_ALLOWED_TO_START = "NotAllowedToStart"
    ALLOWED_TO_START = "AllowedToStart"
    RUNNING = "Running"
    INTERRUPTED = "Interrupted"
    ENDED = "Ended"
    ABORTED = "Aborted"


class JobPolicy(Request):
    """What happens when something of the goal cannot be reached."""

    rest: bool = True
    """Do what can still be reached when a condition is given up."""
    ask: bool = False
    """Ask a person before a condition is given up."""
    attempts: int = Field(default=3, ge=1, le=1000)
    """How often a skill may fail on one target."""
    partial: bool = False
    """Begin although a part cannot be reached from the start."""


class JobOrder(GoalOrder):
    """A job order: a goal (or a goal template) and how it is to be done."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"goal": "InKit(Starter, kit_1)", "priority": 5, "description": "kit for order 4711"},
                {"goal": [{"condition": "InKit", "arguments": ["Starter", "kit_1"]}]},
            ]
        }
    )

    id: str | None = Field(default=None, min_length=1, max_length=200, examples=["line-1-kit-4711"])
    """Chosen by the caller; without one the server makes it (POST). No blanks, no '/'."""
    description: str = Field(default="", max_length=2000, examples=["kit for order 4711"])
    """For people."""
    priority: int = Field(default=0, ge=-_PRIORITIES, lt=_PRIORITIES)
    """The higher comes first."""
    not_before: WantedMoment | None = None
    """The start gate: it does not start earlier."""
    deadline: WantedMoment | None = None
    """When it should be done; of equal priority the earlier deadline comes first."""
    expires: bool = False
    """Whether it must not be begun after its deadline."""
    policy: JobPolicy = JobPolicy()
    """What happens when something cannot be reached."""


class JobState(Answer):
    """Where a job is."""

    number: int = Field(examples=[3])
    """Number of the state after the standard."""
    text: StateName = Field(examples=["Running"])
    """Its name."""
    substates: tuple[str, ...] = Field(examples=[["Executing"]])
    """More closely: Waiting, Ready, Queued; Planning, Executing, WaitingForPerson; Held, Suspended; Completed, Closed.
    """


class ConditionActual(Answer):
    """What became of one condition of the goal."""

    condition: str = Field(examples=["InKit(Starter, kit_1)"])
    """As ordered."""
    reached: bool
    """Whether it held at the end."""
    reason: str
    """Why not; empty where it did."""


class MaterialMoved(Answer):
    """A part that the job has moved (ISA-95: material actual)."""

    element: str = Field(examples=["starter_1"])
    """Id of the part."""
    class_: str = Field(alias="class", examples=["kitting:Starter"])
    """Its class."""
    label: str
    """What people call it."""
    origin: str = Field(examples=["pallet_a"])
    """Where it was when the job began."""
    place: str = Field(examples=["kit_1_a"])
    """Where the job left it; empty where it is no more."""


class OrderedGoal(Answer):
    """What was ordered."""

    goal: tuple[str, ...] = Field(examples=[["InKit(Starter, kit_1)"]])
    """Goal texts."""
    work_master: str
    """The goal template that they were made of; empty for none."""
    parameters: dict[str, str]
    """What the template was given."""
    materials: tuple[Material, ...]
    """The material that was ordered."""
    description: str
    """For people."""
    priority: int
    """The higher comes first."""
    not_before: Moment | None
    """The start gate."""
    deadline: Moment | None
    """When it should be done."""
    expires: bool
    """Whether it must not be begun after its deadline."""
    policy: JobPolicy
    """What happens when something cannot be reached."""


class Job(Answer):
    """A job as it is now."""

    id: str = Field(examples=["line-1-kit-4711"])
    """Its id."""
    number: int = Field(examples=[12])
    """Counts orders in the sequence in which they came."""
    version: int = Field(examples=[5])
    """Grows with every change of it; as in its ETag."""
    state: JobState
    """Where it is."""
    detail: str = Field(examples=["running"])
    """What it does or waits for, in words."""
    outcome: str | None = Field(examples=[None])
    """What came of it: succeeded, partially succeeded, goal already satisfied, stopped, aborted, failed, no plan,
    expired; null until it is over.
    """
    order: OrderedGoal
    """What was ordered."""
    commands: tuple[str, ...] = Field(examples=[["pause"]])
    """The commands that it takes in this state."""
    choices: tuple[str, ...]
    """The answers that it waits for from a person; empty for none."""
    question: int | None
    """Number of the question that they answer."""
    conditions: tuple[ConditionActual, ...]
    """What became of each condition."""
    materials: tuple[MaterialMoved, ...]
    """The parts that it has moved."""
    reasons: tuple[str, ...]
    """Why there is no plan, or why it was given up."""
    plan: tuple[str, ...]
    """The last plan, a line a step."""
    attempts: int
    """How often it was begun: once more after each restart of the server."""
    late: bool
    """Whether it is after its deadline, or was when it ended."""
    lateness: float | None
    """How long after its deadline it ended [s]; null where none or not over."""
    ordered: Moment | None
    """When it was ordered."""
    started: Moment | None
    """When it was begun."""
    ended: Moment | None
    """When it was over."""


class AcceptedJob(Job):
    """A job, in answer to an order or a command that was taken."""

    return_status: int = Field(default=1, examples=[1])
    """ISA-95 return status: bit 0, without fault."""


class WorkMaster(Answer):
    """A goal template that orders may name."""

    id: str = Field(examples=["fill kit"])
    """Its name."""
    version: int = Field(examples=[3])
    """Its version."""
    description: str
    """For people."""
    parameters: tuple[TemplateParameter, ...]
    """What an order fills in."""


class JobCapabilities(Answer):
    """What may be ordered here (ISA-95: capabilities of a job order receiver)."""

    work_masters: tuple[WorkMaster, ...]
    """The goal templates, by name."""
    material_class_ids: tuple[str, ...] = Field(examples=[["kitting:Starter"]])
    """Classes of what robots can handle, as orders name them."""
    equipment_ids: tuple[str, ...] = Field(examples=[["robot_1"]])
    """The robots."""
    max_downloadable_job_orders: int = Field(examples=[50000])
    """So many jobs may be open at the same time."""
    open_job_orders: int = Field(examples=[12])
    """So many are open now."""


JobPage = Page[Job]
"""Some of the jobs, in the order in which they were ordered."""


class JobComment(Request):
    """Why a command is given."""

    comment: str = Field(default="", max_length=2000, examples=["line 1 is blocked"])
    """For the record."""


class JobAnswer(Request):
    """The answer to what a job waits for."""

    answer: Name = Field(examples=["retry"])
    """One of its choices."""
    question: int | None = None
    """Number of the question that is answered; a later one is then left alone."""


class JobStep(Answer):
    """One skill that was run for a job (ISA-95: job response data)."""

    number: int = Field(examples=[1])
    """Counts the steps that were begun."""
    skill: str = Field(examples=["pick"])
    """Its name."""
    arguments: dict[str, str] = Field(examples=[{"Object": "starter_1"}])
    """With what, by parameter."""
    ended: str | None
    """How it ended: "done", "failed: …", "stopped"; null while unknown."""


class JobTransition(Answer):
    """One change of state."""

    at: Moment
    """When."""
    trigger: str = Field(examples=["dispatch"])
    """What led to it."""
    state: JobState
    """The state that it led to."""
    comment: str
    """Why, and who wanted it."""


class JobTransitions(Answer):
    """The changes of state of a job, in order."""

    transitions: tuple[JobTransition, ...]
    """Oldest first."""


class StateEntry(Answer):
    """A state or substate of a job."""

    number: int | None = Field(examples=[5])
    """Its number after the standard; null for a substate."""
    text: str = Field(examples=["Ended"])
    """Its name."""


class JobResponse(Answer):
    """What a job has come to (ISA-95: job response)."""

    job_response_id: str
    """Its id: that of the job."""
    job_order_id: str
    """Id of the order."""
    description: str
    """That of the order."""
    start_time: Moment | None
    """When it was really begun."""
    end_time: Moment | None
    """When it was really over."""
    job_state: tuple[StateEntry, ...]
    """The state, then its substates."""
    outcome: str | None = Field(examples=["succeeded"])
    """What came of it."""
    conditions: tuple[ConditionActual, ...]
    """What became of each condition of the goal."""
    material_actuals: tuple[MaterialMoved, ...]
    """Which part was brought from where to where."""
    job_response_data: tuple[JobStep, ...]
    """The skills that were run, in order."""
    reasons: tuple[str, ...]
    """Why there was no plan, or why it was given up."""
    lateness: float | None
    """How long after its deadline it ended [s]."""
    transitions: tuple[JobTransition, ...]
    """Its states, in order."""


JobResponses = Page[JobResponse]
"""Some of the job responses, in the order in which the jobs were ordered."""


class PlannedStep(Answer):
    """One step of a plan."""

    text: str = Field(examples=["drive(Base=base_1, Robot=robot_1, Location=kit_1)"])
    """As text."""
    skill: str = Field(examples=["drive"])
    """The skill."""
    arguments: dict[str, str]
    """With what, by parameter."""
    after: tuple[int, ...]
    """Indices, from 0, of the steps that must have ended before."""
    start: float | None
    """When it shall start, from the start of the plan [s]; null if unknown."""


class JobPlan(Answer):
    """The last plan of a job."""

    steps: tuple[PlannedStep, ...]
    """In order; empty where there is none (yet)."""


class JobTrace(Answer):
    """What happened for a job."""

    entries: tuple[dict[str, Any], ...]
    """Oldest first; each with time [s], what, text and data."""
    next: str | None
    """The cursor of what comes next; null at the end."""


class JobReport(Answer):
    """What came of a job, as `skiros run` reports a goal."""

    id: str
    """The job."""
    outcome: str | None
    """What came of it; null until it is over."""
    reached: bool
    """Whether every condition holds."""
    conditions: tuple[ConditionActual, ...]
    """What became of each condition."""
    steps: tuple[dict[str, Any], ...]
    """The skills that were run: skill, arguments, agent, start and end in run time [s], reason."""
    no_plan: tuple[str, ...]
    """Why there was no plan."""
    seconds: float | None
    """Wall time from its start to its end, or until now [s]."""


class JobExplanation(Answer):
    """Why there is no plan, and what would help."""

    reasons: tuple[str, ...]
    """Why, in sentences; empty where there is a plan."""
    causes: tuple[dict[str, Any], ...]
    """The same as data: kind, text, conditions, elements, …."""
    repairs: tuple[dict[str, Any], ...]
    """Smallest changes that would help: text, edits, …"""
    conditions: tuple[ConditionActual, ...]
    """The conditions that were not reached."""


def order_from(
    goals: tuple[str, ...] = (),
    *,
    template: str = "",
    parameters: Mapping[str, str] | None = None,
    materials: tuple[str, ...] = (),
    **fields: Any,
) -> JobOrder:
    """Makes an order of what somebody types.

    Args:
        goals: Goal texts that must hold together.
        template: Name of a goal template, instead.
        parameters: What it is given.
        materials: Each as :func:`material_from` reads it.
        **fields: Further fields of :class:`JobOrder`.

    Raises:
        pydantic.ValidationError: Something is wrong.
    """
    given = {name: value for name, value in fields.items() if value is not None}
    wanted: dict[str, Any] = {"goal": goals[0] if len(goals) == 1 else goals} if goals else {}
    return JobOrder(
        **wanted,
        work_master=template,
        parameters=dict(parameters or {}),
        materials=tuple(map(material_from, materials)),
        **given,
    )


def material_from(text: str) -> Material:
    """Reads material written as ``CLASS``, ``3*CLASS``, ``CLASS=ID`` or any of them with ``@LOCATION`` at the end.

    Raises:
        pydantic.ValidationError: Something is wrong.
    """
    rest, _, location = text.partition("@")
    number, star, named = rest.partition("*")
    class_, _, id_ = (named if star else rest).partition("=")
    return Material.model_validate(
        {"class": class_.strip(), "quantity": number if star else 1, "id": id_.strip(), "location": location.strip()}
    )


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

    condition: str = Field(examples=["ObjectAtLocation(Starter, kit_1_a)"])
    """As it was wanted."""
    by: str = Field(examples=["ObjectAtLocation(Starter, kit_1_d)"])
    """What to want instead."""


class Repair(Answer):
    """A smallest change after which there would be a plan."""

    id: int = Field(examples=[0])
    """Its number in this preview."""
    text: str = Field(examples=["put starter_1 in pallet_a"])
    """What to do, in words."""
    edits: tuple[str, ...]
    """The changes to the world."""
    without: tuple[str, ...]
    """The conditions to take out of the goal."""
    instead: tuple[Exchange, ...]
    """The conditions to want otherwise."""
    elements: tuple[str, ...]
    """Ids of the elements that its changes to the world name."""
    applicable: bool
    """Whether there are changes to the world in it, which the server can make."""


class Preview(Answer):
    """A goal, planned and not done."""

    id: str = Field(examples=["17"])
    """Its id."""
    state: PreviewState
    """How far it is."""
    goal: tuple[str, ...]
    """What was wanted, as texts."""
    conditions: tuple[str, ...]
    """The conditions, as they were understood."""
    world: int = Field(examples=[42])
    """Version of the world for which it was planned."""
    asked: Moment | None
    """When it was asked for."""
    wall: float | None
    """How long planning took [s]; null while it lasts."""
    planner: str
    """Name of the planner; empty if none was needed."""
    steps: tuple[PlannedStep, ...]
    """The plan; empty where there is none, or nothing to be done."""
    reasons: tuple[str, ...]
    """Why there is no plan, or why planning failed, in sentences."""
    causes: tuple[dict[str, Any], ...]
    """The same as data: kind, text, conditions, elements, …."""
    repairs: tuple[Repair, ...]
    """What would help."""
    notes: tuple[str, ...]
    """What went wrong with planners that were asked before."""


PreviewPage = Items[Preview]
"""The previews that are kept, the latest first."""


class AppliedRepair(Answer):
    """What became of a repair."""

    text: str = Field(examples=["put starter_1 in pallet_a"])
    """What was done."""
    world: int = Field(examples=[43])
    """Version of the world after it."""
