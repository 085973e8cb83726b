"""Jobs as the API shows them, in the terms of the standard: state, response, plan, report, explanation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from skiros_py.api import jobs as api
from skiros_py.api.jobs import StateName
from skiros_py.planning.plan import Plan
from skiros_py.tasks.jobs.job import Job, JobState, Transition
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import Announcement as Announcement  # also for the server
from skiros_py.tasks.jobs.store import Page
from skiros_py.tasks.trace import TraceEventKind

Trace = Sequence[Mapping[str, Any]]

STATES: dict[StateName, JobState] = {StateName(s.name.title().replace("_", "")): s for s in JobState}
"""The states of jobs by their names in the standard."""
_NAMES = {state: name for name, state in STATES.items()}


def state_name(state: JobState) -> StateName:
    """Returns the name of a state in the standard, which the API uses."""
    return _NAMES[state]


def is_open(job: api.Job) -> bool:
    """Returns whether a job is not over."""
    return JobState(job.state.number).is_open


_COMMANDS: Mapping[JobState, tuple[str, ...]] = {
    JobState.NOT_ALLOWED_TO_START: ("start", "abort", "cancel"),
    JobState.ALLOWED_TO_START: ("revoke-start", "abort", "cancel"),
    JobState.RUNNING: ("pause", "stop", "abort"),
    JobState.INTERRUPTED: ("resume", "stop", "abort"),
    JobState.ENDED: ("clear",),
    JobState.ABORTED: ("clear",),
}
"""The commands that a job accepts in its state."""


def next_cursor(page: Page) -> str | None:
    """Returns what to ask with for the jobs after a page; None after the last one."""
    return None if page.next is None else str(page.next)


def job_view(job: Job, now: float) -> api.Job:
    """Returns a job as the API shows it.

    Args:
        job: The job.
        now: Wall time [s since 1970].
    """
    return api.Job.view_of(
        job,
        state=job_state(job, now),
        order=api.OrderedGoal.model_validate(job.order, from_attributes=True),
        commands=_COMMANDS[job.state],
        conditions=job.actuals,
        late=job.order.deadline is not None and (job.ended or now) > job.order.deadline.timestamp(),
    )


def job_state(job: Job, now: float) -> api.JobState:
    """Returns the state of a job, with its substates; the arguments are those of :func:`job_view`."""
    return state_view(job.state, _substates(job, now))


def announced_job(announcement: Announcement) -> dict[str, Any]:
    """Returns the data about a job that is sent to other systems."""
    job = job_view(announcement.job, announcement.wall)
    return {"trigger": announcement.trigger, "job": job.model_dump(mode="json", by_alias=True)}


def state_view(state: JobState, substates: tuple[str, ...] = ()) -> api.JobState:
    """Returns a state as the API shows it."""
    return api.JobState(number=state.value, text=_NAMES[state], substates=substates)


def transitions_view(transitions: Iterable[Transition]) -> tuple[api.JobTransition, ...]:
    """Returns a job's changes of state as the API shows them."""
    return tuple(api.JobTransition.view_of(one, at=one.wall, state=state_view(one.state)) for one in transitions)


def _substates(job: Job, now: float) -> tuple[str, ...]:
    match job.state:
        case JobState.NOT_ALLOWED_TO_START:
            return ("Ready",)
        case JobState.ALLOWED_TO_START:
            gate = job.order.not_before
            return ("Waiting",) if gate is not None and gate.timestamp() > now else ("Ready", "Queued")
        case JobState.RUNNING:
            return (_ACTIVITIES.get(job.detail, "Executing"),)
        case JobState.INTERRUPTED:
            return ("Held",) if job.choices or job.question is not None else ("Suspended",)
        case JobState.ENDED:
            return ("Completed", "Closed")
        case JobState.ABORTED:
            return ()


_ENDS = (TraceEventKind.ENDED.value, TraceEventKind.FAILED.value, TraceEventKind.CANCELLED.value)
_ACTIVITIES = {"planning": "Planning", "waiting": "WaitingForPerson"}


# ---------------------------------------------------------------------- results, from stored data


def response_of(jobs: JobManager, job: Job, now: float) -> api.JobResponse:
    """Returns the job response of the standard.

    Args:
        jobs: The queue.
        job: The job.
        now: Wall time [s since 1970].
    """
    view = job_view(job, now)
    state = view.state
    return api.JobResponse.view_of(
        view,
        job_response_id=job.id,
        job_order_id=job.id,
        description=view.order.description,
        start_time=view.started,
        end_time=view.ended,
        job_state=(
            api.StateEntry(number=state.number, text=state.text),
            *(api.StateEntry(number=None, text=text) for text in state.substates),
        ),
        material_actuals=view.materials,
        job_response_data=jobs.intents(job.id),
        lateness=job.lateness,
        transitions=transitions_view(jobs.transitions(job.id)),
    )


def planned_steps(plan: Plan) -> tuple[api.PlannedStep, ...]:
    """Returns the steps of a plan as the API shows them."""
    return _steps(plan.as_json())


def plan_of(job: Job, trace: Trace) -> api.JobPlan:
    """Returns the last plan of a job from its trace; if the trace contains none, the plan stored with the job."""
    entry = _last(trace, TraceEventKind.PLANNED)
    if entry is not None:
        return api.JobPlan(items=_steps(entry["data"]))
    bare = {"steps": job.plan, "after": [[index - 1] if index else [] for index in range(len(job.plan))]}
    return api.JobPlan(items=_steps(bare))


def report_of(job: Job, trace: Trace, now: float) -> api.JobReport:
    """Returns the result of a job in the form of the report of a run of one goal."""
    ended = job.ended or now
    return api.JobReport.view_of(
        job,
        outcome=None if job.outcome is None else job.outcome.value,
        reached=bool(job.actuals) and all(condition.reached for condition in job.actuals),
        conditions=job.actuals,
        steps=tuple(_step(entry) for entry in trace if entry["what"] in _ENDS),
        no_plan=job.reasons,
        seconds=None if job.started is None else max(0.0, ended - job.started),
    )


def explanation_of(job: Job, trace: Trace) -> api.JobExplanation:
    """Returns why there is no plan for a job; empty if there is one, or planning has not started."""
    refused = _last(trace, TraceEventKind.NO_PLAN)
    planned = _last(trace, TraceEventKind.PLANNED)
    missing = tuple(condition for condition in job.actuals if not condition.reached)
    if refused is None or (planned is not None and trace.index(planned) > trace.index(refused)):
        return api.JobExplanation.view_of(job, causes=(), repairs=(), conditions=missing)
    return api.JobExplanation(**{"causes": (), "repairs": (), **refused["data"], "conditions": missing})


def _last(trace: Trace, what: TraceEventKind) -> Mapping[str, Any] | None:
    return next((entry for entry in reversed(trace) if entry["what"] == what.value), None)


def _steps(plan: Mapping[str, Any]) -> tuple[api.PlannedStep, ...]:
    """Returns the steps of a plan stored as plain data; fields that older traces lack are left empty."""
    texts, starts = plan["steps"], plan.get("starts", ())
    calls = plan.get("calls") or [{"skill": text.partition("(")[0], "arguments": {}} for text in texts]
    return tuple(
        api.PlannedStep(
            text=text,
            skill=calls[index]["skill"],
            arguments=calls[index]["arguments"],
            after=tuple(plan["after"][index]),
            start=starts[index] if starts else None,
        )
        for index, text in enumerate(texts)
    )


def _step(entry: Mapping[str, Any]) -> dict[str, Any]:
    data = entry["data"]
    return {
        "skill": entry["skill"],
        "arguments": entry["arguments"],
        "agent": entry["agent"],
        "start": data.get("start"),
        "end": entry["time"],
        "reason": data.get("reason", ""),
    }
