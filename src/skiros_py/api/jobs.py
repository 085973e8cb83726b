"""Jobs on the wire (ISA-95 job control): what is ordered, commanded and read; and previews of their plans."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any

from pydantic import ConfigDict, Field

from skiros_py.api.goals import GoalOrder, Material, TemplateParameter
from skiros_py.api.wire import Answer, Moment, Name, Request, WantedMoment

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

    rest: bool = Field(default=True, description="Do what can still be reached when a condition is given up.")
    ask: bool = Field(default=False, description="Ask a person before a condition is given up.")
    attempts: int = Field(default=3, ge=1, le=1000, description="How often a skill may fail on one target.")
    partial: bool = Field(default=False, description="Begin although a part cannot be reached from the start.")


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

    id: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="Chosen by the caller; without one the server makes it (POST). No blanks, no '/'.",
        examples=["line-1-kit-4711"],
    )
    description: str = Field(default="", max_length=2000, description="For people.", examples=["kit for order 4711"])
    priority: int = Field(default=0, ge=-_PRIORITIES, lt=_PRIORITIES, description="The higher comes first.")
    not_before: WantedMoment | None = Field(default=None, description="The start gate: it does not start earlier.")
    deadline: WantedMoment | None = Field(
        default=None, description="When it should be done; of equal priority the earlier deadline comes first."
    )
    expires: bool = Field(default=False, description="Whether it must not be begun after its deadline.")
    policy: JobPolicy = Field(default=JobPolicy(), description="What happens when something cannot be reached.")


class JobState(Answer):
    """Where a job is."""

    number: int = Field(description="Number of the state after the standard.", examples=[3])
    text: StateName = Field(description="Its name.", examples=["Running"])
    substates: tuple[str, ...] = Field(
        description="More closely: Waiting, Ready, Queued; Planning, Executing, WaitingForPerson; Held, Suspended;"
        " Completed, Closed.",
        examples=[["Executing"]],
    )


class ConditionActual(Answer):
    """What became of one condition of the goal."""

    condition: str = Field(description="As ordered.", examples=["InKit(Starter, kit_1)"])
    reached: bool = Field(description="Whether it held at the end.")
    reason: str = Field(description="Why not; empty where it did.")


class MaterialMoved(Answer):
    """A part that the job has moved (ISA-95: material actual)."""

    element: str = Field(description="Id of the part.", examples=["starter_1"])
    class_: str = Field(alias="class", description="Its class.", examples=["kitting:Starter"])
    label: str = Field(description="What people call it.")
    origin: str = Field(description="Where it was when the job began.", examples=["pallet_a"])
    place: str = Field(description="Where the job left it; empty where it is no more.", examples=["kit_1_a"])


class OrderedGoal(Answer):
    """What was ordered."""

    goal: tuple[str, ...] = Field(description="Goal texts.", examples=[["InKit(Starter, kit_1)"]])
    work_master: str = Field(description="The goal template that they were made of; empty for none.")
    parameters: dict[str, str] = Field(description="What the template was given.")
    materials: tuple[Material, ...] = Field(description="The material that was ordered.")
    description: str = Field(description="For people.")
    priority: int = Field(description="The higher comes first.")
    not_before: Moment | None = Field(description="The start gate.")
    deadline: Moment | None = Field(description="When it should be done.")
    expires: bool = Field(description="Whether it must not be begun after its deadline.")
    policy: JobPolicy = Field(description="What happens when something cannot be reached.")


class Job(Answer):
    """A job as it is now."""

    id: str = Field(description="Its id.", examples=["line-1-kit-4711"])
    number: int = Field(description="Counts orders in the sequence in which they came.", examples=[12])
    version: int = Field(description="Grows with every change of it; as in its ETag.", examples=[5])
    state: JobState = Field(description="Where it is.")
    detail: str = Field(description="What it does or waits for, in words.", examples=["running"])
    outcome: str | None = Field(
        description="What came of it: succeeded, partially succeeded, goal already satisfied, stopped, aborted, failed,"
        " no plan, expired; null until it is over.",
        examples=[None],
    )
    order: OrderedGoal = Field(description="What was ordered.")
    commands: tuple[str, ...] = Field(description="The commands that it takes in this state.", examples=[["pause"]])
    choices: tuple[str, ...] = Field(description="The answers that it waits for from a person; empty for none.")
    question: int | None = Field(description="Number of the question that they answer.")
    conditions: tuple[ConditionActual, ...] = Field(description="What became of each condition.")
    materials: tuple[MaterialMoved, ...] = Field(description="The parts that it has moved.")
    reasons: tuple[str, ...] = Field(description="Why there is no plan, or why it was given up.")
    plan: tuple[str, ...] = Field(description="The last plan, a line a step.")
    attempts: int = Field(description="How often it was begun: once more after each restart of the server.")
    late: bool = Field(description="Whether it is after its deadline, or was when it ended.")
    lateness: float | None = Field(description="How long after its deadline it ended [s]; null where none or not over.")
    ordered: Moment | None = Field(description="When it was ordered.")
    started: Moment | None = Field(description="When it was begun.")
    ended: Moment | None = Field(description="When it was over.")


class AcceptedJob(Job):
    """A job, in answer to an order or a command that was taken."""

    return_status: int = Field(default=1, description="ISA-95 return status: bit 0, without fault.", examples=[1])


class WorkMaster(Answer):
    """A goal template that orders may name."""

    id: str = Field(description="Its name.", examples=["fill kit"])
    version: int = Field(description="Its version.", examples=[3])
    description: str = Field(description="For people.")
    parameters: tuple[TemplateParameter, ...] = Field(description="What an order fills in.")


class JobCapabilities(Answer):
    """What may be ordered here (ISA-95: capabilities of a job order receiver)."""

    work_masters: tuple[WorkMaster, ...] = Field(description="The goal templates, by name.")
    material_class_ids: tuple[str, ...] = Field(
        description="Classes of what robots can handle, as orders name them.", examples=[["kitting:Starter"]]
    )
    equipment_ids: tuple[str, ...] = Field(description="The robots.", examples=[["robot_1"]])
    max_downloadable_job_orders: int = Field(description="So many jobs may be open at the same time.", examples=[50000])
    open_job_orders: int = Field(description="So many are open now.", examples=[12])


class JobPage(Answer):
    """Some of the jobs, in the order in which they were ordered."""

    items: tuple[Job, ...] = Field(description="The jobs.")
    next: str | None = Field(description="The cursor of what comes next; null at the end.")


class JobComment(Request):
    """Why a command is given."""

    comment: str = Field(default="", max_length=2000, description="For the record.", examples=["line 1 is blocked"])


class JobAnswer(Request):
    """The answer to what a job waits for."""

    answer: Name = Field(description="One of its choices.", examples=["retry"])
    question: int | None = Field(
        default=None, description="Number of the question that is answered; a later one is then left alone."
    )


class JobStep(Answer):
    """One skill that was run for a job (ISA-95: job response data)."""

    number: int = Field(description="Counts the steps that were begun.", examples=[1])
    skill: str = Field(description="Its name.", examples=["pick"])
    arguments: dict[str, str] = Field(description="With what, by parameter.", examples=[{"Object": "starter_1"}])
    ended: str | None = Field(description='How it ended: "done", "failed: …", "stopped"; null while unknown.')


class JobTransition(Answer):
    """One change of state."""

    at: Moment = Field(description="When.")
    trigger: str = Field(description="What led to it.", examples=["dispatch"])
    state: JobState = Field(description="The state that it led to.")
    comment: str = Field(description="Why, and who wanted it.")


class JobTransitions(Answer):
    """The changes of state of a job, in order."""

    transitions: tuple[JobTransition, ...] = Field(description="Oldest first.")


class StateEntry(Answer):
    """A state or substate of a job."""

    number: int | None = Field(description="Its number after the standard; null for a substate.", examples=[5])
    text: str = Field(description="Its name.", examples=["Ended"])


class JobResponse(Answer):
    """What a job has come to (ISA-95: job response)."""

    job_response_id: str = Field(description="Its id: that of the job.")
    job_order_id: str = Field(description="Id of the order.")
    description: str = Field(description="That of the order.")
    start_time: Moment | None = Field(description="When it was really begun.")
    end_time: Moment | None = Field(description="When it was really over.")
    job_state: tuple[StateEntry, ...] = Field(description="The state, then its substates.")
    outcome: str | None = Field(description="What came of it.", examples=["succeeded"])
    conditions: tuple[ConditionActual, ...] = Field(description="What became of each condition of the goal.")
    material_actuals: tuple[MaterialMoved, ...] = Field(description="Which part was brought from where to where.")
    job_response_data: tuple[JobStep, ...] = Field(description="The skills that were run, in order.")
    reasons: tuple[str, ...] = Field(description="Why there was no plan, or why it was given up.")
    lateness: float | None = Field(description="How long after its deadline it ended [s].")
    transitions: tuple[JobTransition, ...] = Field(description="Its states, in order.")


class JobResponses(Answer):
    """Some of the job responses, in the order in which the jobs were ordered."""

    items: tuple[JobResponse, ...] = Field(description="The responses.")
    next: str | None = Field(description="The cursor of what comes next; null at the end.")


class PlannedStep(Answer):
    """One step of a plan."""

    text: str = Field(description="As text.", examples=["drive(Base=base_1, Robot=robot_1, Location=kit_1)"])
    skill: str = Field(description="The skill.", examples=["drive"])
    arguments: dict[str, str] = Field(description="With what, by parameter.")
    after: tuple[int, ...] = Field(description="Indices, from 0, of the steps that must have ended before.")
    start: float | None = Field(description="When it shall start, from the start of the plan [s]; null if unknown.")


class JobPlan(Answer):
    """The last plan of a job."""

    steps: tuple[PlannedStep, ...] = Field(description="In order; empty where there is none (yet).")


class JobTrace(Answer):
    """What happened for a job."""

    entries: tuple[dict[str, Any], ...] = Field(description="Oldest first; each with time [s], what, text and data.")
    next: str | None = Field(description="The cursor of what comes next; null at the end.")


class JobReport(Answer):
    """What came of a job, as `skiros run` reports a goal."""

    id: str = Field(description="The job.")
    outcome: str | None = Field(description="What came of it; null until it is over.")
    reached: bool = Field(description="Whether every condition holds.")
    conditions: tuple[ConditionActual, ...] = Field(description="What became of each condition.")
    steps: tuple[dict[str, Any], ...] = Field(
        description="The skills that were run: skill, arguments, agent, start and end in run time [s], reason."
    )
    no_plan: tuple[str, ...] = Field(description="Why there was no plan.")
    seconds: float | None = Field(description="Wall time from its start to its end, or until now [s].")


class JobExplanation(Answer):
    """Why there is no plan, and what would help."""

    reasons: tuple[str, ...] = Field(description="Why, in sentences; empty where there is a plan.")
    causes: tuple[dict[str, Any], ...] = Field(description="The same as data: kind, text, conditions, elements, ….")
    repairs: tuple[dict[str, Any], ...] = Field(description="Smallest changes that would help: text, edits, …")
    conditions: tuple[ConditionActual, ...] = Field(description="The conditions that were not reached.")


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
