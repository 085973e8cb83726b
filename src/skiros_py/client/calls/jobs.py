"""Jobs: ordering, commanding, following."""

from __future__ import annotations

import re
import uuid
from collections.abc import Sequence
from datetime import datetime
from typing import TypeVar

from pydantic import BaseModel

from skiros_py.api.jobs import (
    Job,
    JobAnswer,
    JobCapabilities,
    JobComment,
    JobExplanation,
    JobOrder,
    JobPage,
    JobPlan,
    JobReport,
    JobResponse,
    JobResponses,
    JobTrace,
    JobTransitions,
    StateName,
)
from skiros_py.api.replays import Replay
from skiros_py.client.call import Call, if_match, path_of
from skiros_py.errors import UsageError

M = TypeVar("M", bound=BaseModel)

_ID = re.compile(r"[^\s/\x00-\x1f]{1,200}")


def order_job(
    order: JobOrder, *, start: bool = True, key: str | None = None, wait: float | None = None, again: bool = False
) -> Call[Job]:
    """Orders a job.

    Args:
        order: What is wanted; without an id the server makes one.
        start: False to keep it until somebody gives leave to start.
        key: Marks the request, so that it may be sent again; made where left out.
        wait: How long to wait until it is over or stands [s], up to 30 s; None for not at all.
        again: True if it is meant although there was a job of that id that was removed.
    """
    headers = {"Idempotency-Key": key or str(uuid.uuid4()), "Prefer": _prefer(wait)}
    return Call("POST", "/jobs", Job, query=_start(start, again), json=_plain(order), headers=headers)


def put_job(
    job: str,
    order: JobOrder,
    *,
    start: bool = True,
    seen: int | None = None,
    wait: float | None = None,
    again: bool = False,
) -> Call[Job]:
    """Orders a job under an id of one's own, or something else under the id of one that has not begun.

    Args:
        job: The id.
        order: What is wanted.
        start: False to keep it until somebody gives leave to start.
        seen: Version of the job that is there, to change its order.
        wait: How long to wait until it is over or stands [s], up to 30 s; None for not at all.
        again: True if it is meant although there was a job of that id that was removed.
    """
    headers = {**if_match(seen), "Prefer": _prefer(wait)}
    return Call("PUT", _path(job), Job, query=_start(start, again), json=_plain(order), headers=headers)


def list_jobs(
    *,
    states: Sequence[StateName | str] = (),
    since: datetime | None = None,
    limit: int = 100,
    cursor: str | None = None,
    newest_first: bool = False,
) -> Call[JobPage]:
    """Lists jobs, open or over, in the order in which they were ordered.

    Args:
        states: Those in these states only.
        since: Those only that changed since then.
        limit: How many at most.
        cursor: The ``next`` of the page before.
        newest_first: True to go back from the one that was ordered last.
    """
    return Call("GET", "/jobs", JobPage, query=_chosen(states, since, limit, cursor, newest_first))


def get_job(job: str) -> Call[Job]:
    """Looks at a job."""
    return Call("GET", _path(job), Job)


def get_job_response(job: str) -> Call[JobResponse]:
    """Says what a job has come to (ISA-95 job response)."""
    return Call("GET", _path(job, "response"), JobResponse)


def list_job_responses(
    *,
    states: Sequence[StateName | str] = (),
    since: datetime | None = None,
    limit: int = 100,
    cursor: str | None = None,
    newest_first: bool = False,
) -> Call[JobResponses]:
    """Says what jobs have come to, in the order in which they were ordered.

    Args:
        states: Those in these states only.
        since: Those only that changed since then.
        limit: How many at most, up to 100.
        cursor: The ``next`` of the page before.
        newest_first: True to go back from the one that was ordered last.
    """
    query = _chosen(states, since, limit, cursor, newest_first)
    return Call("GET", "/job-responses", JobResponses, query=query)


def get_capabilities() -> Call[JobCapabilities]:
    """Lists what an order may name: goal templates, classes of material, robots."""
    return Call("GET", "/capabilities", JobCapabilities)


def get_job_plan(job: str) -> Call[JobPlan]:
    """Shows the last plan of a job."""
    return Call("GET", _path(job, "plan"), JobPlan)


def get_job_trace(job: str, *, limit: int = 1000, cursor: str | None = None) -> Call[JobTrace]:
    """Lists what happened for a job."""
    return Call("GET", _path(job, "trace"), JobTrace, query={"limit": limit, "cursor": cursor})


def get_job_report(job: str) -> Call[JobReport]:
    """Reports what came of a job, as ``skiros run`` does."""
    return Call("GET", _path(job, "report"), JobReport)


def get_job_replay(job: str, start: float = 0.0, end: float | None = None) -> Call[Replay]:
    """Shows what a job looked like, all of it or from one run time to another [s]."""
    return Call("GET", _path(job, "replay"), Replay, query={"start": start, "end": end})


def get_job_recording(job: str) -> Call[bytes]:
    """Downloads the recording of a job: an MCAP file."""
    return Call("GET", _path(job, "recording"), lambda r: r.content)


def get_job_transitions(job: str) -> Call[JobTransitions]:
    """Lists the changes of state of a job."""
    return Call("GET", _path(job, "transitions"), JobTransitions)


def get_job_explanation(job: str) -> Call[JobExplanation]:
    """Says why there is no plan for a job, and what would help."""
    return Call("GET", _path(job, "explanation"), JobExplanation)


def start_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Gives a job leave to start."""
    return _command(job, "start", comment, seen)


def revoke_start_of_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Takes back the leave to start."""
    return _command(job, "revoke-start", comment, seen)


def pause_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Lets a job stand for a while."""
    return _command(job, "pause", comment, seen)


def resume_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Goes on with a job that stands."""
    return _command(job, "resume", comment, seen)


def stop_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Ends a job in good order."""
    return _command(job, "stop", comment, seen)


def abort_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Gives a job up."""
    return _command(job, "abort", comment, seen)


def cancel_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Removes a job that has not begun."""
    return _command(job, "cancel", comment, seen)


def clear_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Removes a job that is over, with all that is known of it."""
    return _command(job, "clear", comment, seen)


def remove_job(job: str, comment: str = "", *, seen: int | None = None) -> Call[Job]:
    """Removes a job that has not begun, or is over."""
    query = {"comment": comment or None}
    return Call("DELETE", _path(job), Job, query, headers=if_match(seen))


def answer_job(job: str, answer: str, *, question: int | None = None) -> Call[Job]:
    """Answers what a job waits for.

    Args:
        job: Its id.
        answer: One of its choices.
        question: Number of the question that is answered; a later one is then left alone.
    """
    body = JobAnswer(answer=answer, question=question)
    return Call("POST", _path(job, "answer"), Job, json=_plain(body), repeatable=question is not None)


def _command(job: str, command: str, comment: str, seen: int | None) -> Call[Job]:
    body = _plain(JobComment(comment=comment))
    return Call("POST", _path(job, command), Job, json=body, headers=if_match(seen))


def _plain(model: BaseModel) -> object:
    return model.model_dump(mode="json", by_alias=True, exclude_defaults=True)


def _path(job: str, *parts: str) -> str:
    if not _ID.fullmatch(job):
        raise UsageError(f"{job[:80]!r} can be no id of a job: that has 1 to 200 characters, without blanks and '/'")
    return path_of("jobs", job, *parts)


def _start(start: bool, again: bool) -> dict[str, str | None]:
    return {"start": None if start else "false", "again": "true" if again else None}


def _chosen(
    states: Sequence[StateName | str], since: datetime | None, limit: int, cursor: str | None, newest_first: bool
) -> dict[str, list[str] | str | int | None]:
    return {
        "state": [str(state) for state in states] or None,
        "since": None if since is None else since.isoformat(),
        "limit": limit,
        "cursor": cursor,
        "newest_first": "true" if newest_first else None,
    }


def _prefer(wait: float | None) -> str | None:
    return None if wait is None else f"wait={max(0, round(wait))}"
