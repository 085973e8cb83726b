"""The results of a job, from its stored data: response, plan, report, explanation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skiros_py.api.jobs import (
    ConditionActual,
    JobExplanation,
    JobPlan,
    JobReport,
    JobResponse,
    PlannedStep,
    StateEntry,
)
from skiros_py.planning.plan import Plan
from skiros_py.station.jobs.views import job_view, steps_view, transitions_view
from skiros_py.tasks.jobs import Job, JobManager
from skiros_py.tasks.trace import TraceEventKind

Trace = Sequence[Mapping[str, Any]]

_ENDS = (TraceEventKind.ENDED.value, TraceEventKind.FAILED.value, TraceEventKind.CANCELLED.value)


def response_of(jobs: JobManager, job: Job, now: float) -> JobResponse:
    """Returns the job response of the standard.

    Args:
        jobs: The queue.
        job: The job.
        now: Wall time [s since 1970].
    """
    view = job_view(job, now)
    state = view.state
    return JobResponse.view_of(
        view,
        job_response_id=job.id,
        job_order_id=job.id,
        description=view.order.description,
        start_time=view.started,
        end_time=view.ended,
        job_state=(
            StateEntry(number=state.number, text=state.text),
            *(StateEntry(number=None, text=text) for text in state.substates),
        ),
        material_actuals=view.materials,
        job_response_data=steps_view(jobs.intents(job.id)),
        lateness=job.lateness,
        transitions=transitions_view(jobs.transitions(job.id)),
    )


def planned_steps(plan: Plan) -> tuple[PlannedStep, ...]:
    """Returns the steps of a plan as the API shows them."""
    return _steps(plan.as_json())


def plan_of(job: Job, trace: Trace) -> JobPlan:
    """Returns the last plan of a job from its trace; if the trace contains none, the plan stored with the job."""
    entry = _last(trace, TraceEventKind.PLANNED)
    if entry is not None:
        return JobPlan(steps=_steps(entry["data"]))
    bare = {"steps": job.plan, "after": [[index - 1] if index else [] for index in range(len(job.plan))]}
    return JobPlan(steps=_steps(bare))


def report_of(job: Job, trace: Trace, now: float) -> JobReport:
    """Returns the result of a job in the form of the report of a run of one goal."""
    conditions = _conditions(job)
    ended = job.ended or now
    return JobReport(
        id=job.id,
        outcome=None if job.outcome is None else job.outcome.value,
        reached=bool(conditions) and all(condition.reached for condition in conditions),
        conditions=conditions,
        steps=tuple(_step(entry) for entry in trace if entry["what"] in _ENDS),
        no_plan=job.reasons,
        seconds=None if job.started is None else max(0.0, ended - job.started),
    )


def explanation_of(job: Job, trace: Trace) -> JobExplanation:
    """Returns why there is no plan for a job; empty if there is one, or planning has not started."""
    refused = _last(trace, TraceEventKind.NO_PLAN)
    planned = _last(trace, TraceEventKind.PLANNED)
    missing = tuple(condition for condition in _conditions(job) if not condition.reached)
    if refused is None or (planned is not None and trace.index(planned) > trace.index(refused)):
        return JobExplanation(reasons=job.reasons, causes=(), repairs=(), conditions=missing)
    data = refused["data"]
    return JobExplanation(
        reasons=tuple(data["reasons"]),
        causes=tuple(data.get("causes", ())),
        repairs=tuple(data.get("repairs", ())),
        conditions=missing,
    )


def _last(trace: Trace, what: TraceEventKind) -> Mapping[str, Any] | None:
    return next((entry for entry in reversed(trace) if entry["what"] == what.value), None)


def _conditions(job: Job) -> tuple[ConditionActual, ...]:
    return tuple(ConditionActual(**actual.model_dump()) for actual in job.actuals)


def _steps(plan: Mapping[str, Any]) -> tuple[PlannedStep, ...]:
    """Returns the steps of a plan stored as plain data; fields that older traces lack are left empty."""
    texts, starts = plan["steps"], plan.get("starts", ())
    calls = plan.get("calls") or [{"skill": text.partition("(")[0], "arguments": {}} for text in texts]
    return tuple(
        PlannedStep(
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
