"""Jobs as the API shows them: the queue's own data in the terms of the standard."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Any

from skiros_py.api.jobs import (
    ConditionActual,
    Job,
    JobState,
    JobStep,
    JobTransition,
    MaterialMoved,
    OrderedGoal,
    StateName,
)
from skiros_py.tasks.jobs import Intent, Transition
from skiros_py.tasks.jobs import Job as Known
from skiros_py.tasks.jobs import JobState as State
from skiros_py.tasks.jobs.store import Announcement as Announcement  # also for the server

STATES: dict[StateName, State] = {StateName(s.name.title().replace("_", "")): s for s in State}
"""The states of jobs by their names in the standard."""
_NAMES = {state: name for name, state in STATES.items()}


def state_name(state: State) -> StateName:
    """Returns the name of a state in the standard, which the API uses."""
    return _NAMES[state]


def is_open(job: Job) -> bool:
    """Returns whether a job is not over."""
    return State(job.state.number).is_open


_COMMANDS: dict[State, tuple[str, ...]] = {
    State.NOT_ALLOWED_TO_START: ("start", "abort", "cancel"),
    State.ALLOWED_TO_START: ("revoke-start", "abort", "cancel"),
    State.RUNNING: ("pause", "stop", "abort"),
    State.INTERRUPTED: ("resume", "stop", "abort"),
    State.ENDED: ("clear",),
    State.ABORTED: ("clear",),
}


def commands_of(job: Known) -> tuple[str, ...]:
    """Returns the commands that a job accepts in its state."""
    return _COMMANDS[job.state]


def job_view(job: Known, now: float) -> Job:
    """Returns a job as the API shows it.

    Args:
        job: The job.
        now: Wall time [s since 1970].
    """
    return Job.view_of(
        job,
        state=_state(job, now),
        outcome=None if job.outcome is None else job.outcome.value,
        order=OrderedGoal.model_validate(job.order, from_attributes=True),
        commands=commands_of(job),
        conditions=tuple(ConditionActual(**actual.model_dump()) for actual in job.actuals),
        materials=tuple(MaterialMoved(**material.model_dump()) for material in job.materials),
        late=_is_late(job, now),
    )


def announced_job(announcement: Announcement) -> dict[str, Any]:
    """Returns the data about a job that is sent to other systems."""
    job = job_view(announcement.job, announcement.wall)
    return {"trigger": announcement.trigger, "job": job.model_dump(mode="json", by_alias=True)}


def state_view(state: State, substates: tuple[str, ...] = ()) -> JobState:
    """Returns a state as the API shows it."""
    return JobState(number=state.value, text=_NAMES[state], substates=substates)


def steps_view(intents: Iterable[Intent]) -> tuple[JobStep, ...]:
    """Returns the steps of a job as the API shows them."""
    return tuple(JobStep(**intent.model_dump()) for intent in intents)


def transitions_view(transitions: Iterable[Transition]) -> tuple[JobTransition, ...]:
    """Returns a job's changes of state as the API shows them."""
    return tuple(
        JobTransition.view_of(one, at=datetime.fromtimestamp(one.wall, UTC), state=state_view(one.state))
        for one in transitions
    )


def _state(job: Known, now: float) -> JobState:
    return state_view(job.state, _substates(job, now))


def _substates(job: Known, now: float) -> tuple[str, ...]:
    match job.state:
        case State.NOT_ALLOWED_TO_START:
            return ("Ready",)
        case State.ALLOWED_TO_START:
            gate = job.order.not_before
            return ("Waiting",) if gate is not None and gate.timestamp() > now else ("Ready", "Queued")
        case State.RUNNING:
            return (_ACTIVITIES.get(job.detail, "Executing"),)
        case State.INTERRUPTED:
            return ("Held",) if job.choices or job.question is not None else ("Suspended",)
        case State.ENDED:
            return ("Completed", "Closed")
        case State.ABORTED:
            return ()


_ACTIVITIES = {"planning": "Planning", "waiting": "WaitingForPerson"}


def _is_late(job: Known, now: float) -> bool:
    return job.order.deadline is not None and (job.ended or now) > job.order.deadline.timestamp()
