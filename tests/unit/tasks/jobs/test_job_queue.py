"""The queue gives what a look at all jobs would give, whatever was ordered, updated and withdrawn before."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.tasks.jobs.job import Job, JobOrder, JobState
from skiros_py.tasks.jobs.queue import JobQueue

TIMES = st.one_of(st.none(), st.integers(1, 20).map(lambda t: datetime.fromtimestamp(t, UTC)))
ORDERS = st.builds(
    lambda id_, priority, gate, deadline: JobOrder(
        id=id_, goal=("x",), priority=priority, not_before=gate, deadline=deadline
    ),
    st.sampled_from("abcdef"),
    st.integers(-1, 1),
    TIMES,
    TIMES,
)
STATES = st.sampled_from([JobState.ALLOWED_TO_START] * 3 + [JobState.NOT_ALLOWED_TO_START, JobState.RUNNING])
STEPS = st.one_of(
    st.tuples(st.just("put"), ORDERS, STATES), st.tuples(st.just("remove"), st.sampled_from("abcdef"), st.none())
)


def by_looking_at_all(jobs: dict[str, Job], now: float) -> str | None:
    def gate(job: Job) -> float:
        return -math.inf if job.order.not_before is None else job.order.not_before.timestamp()

    def rank(job: Job) -> tuple[int, float, int]:
        deadline = job.order.deadline
        return -job.order.priority, math.inf if deadline is None else deadline.timestamp(), job.number

    ready = [job for job in jobs.values() if job.state is JobState.ALLOWED_TO_START and gate(job) <= now]
    return min(ready, key=rank).id if ready else None


@given(st.lists(st.tuples(STEPS, st.integers(0, 21)), max_size=40))
def test_the_queue_and_a_full_search_choose_the_same_next_job_even_if_the_clock_jumps(steps):
    queue, jobs = JobQueue(), {}
    for number, ((what, subject, state), now) in enumerate(steps):
        if what == "remove":
            jobs.pop(subject, None)
            queue.remove(subject)
        else:
            known = jobs.get(subject.id)
            new = Job(order=subject, number=number, state=state)
            jobs[subject.id] = known.but(order=subject, state=state) if known else new
            queue.put(jobs[subject.id])
        assert queue.next(float(now)) == by_looking_at_all(jobs, now)


def test_toggling_the_permission_to_start_does_not_grow_the_queue():
    job = Job(order=JobOrder(id="a", goal=("x",)), number=1, state=JobState.ALLOWED_TO_START)
    queue = JobQueue([job])
    for _ in range(1000):
        job = job.but(state=JobState.NOT_ALLOWED_TO_START)
        queue.put(job)
        job = job.but(state=JobState.ALLOWED_TO_START)
        queue.put(job)
    assert len(queue._ready) + len(queue._gated) == 1
    assert queue.next(0.0) == "a"
