"""How late a job was is said when it is over."""

from datetime import UTC, datetime

import pytest

from skiros_py.tasks.jobs.job import Job, JobOrder, JobState

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)


def job(deadline: datetime | None, after_noon: float | None) -> Job:
    ended = None if after_noon is None else NOON.timestamp() + after_noon
    state = JobState.RUNNING if ended is None else JobState.ENDED
    return Job(order=JobOrder(id="a", goal=("x",), deadline=deadline), number=1, state=state, ended=ended)


@pytest.mark.parametrize(
    ("deadline", "after_noon", "late"),
    [(NOON, 90.0, 90.0), (NOON, -90.0, 0.0), (NOON, None, None), (None, 90.0, None)],
    ids=["after its deadline", "in time", "still open", "no deadline"],
)
def test_lateness_is_the_time_from_deadline_to_end(deadline, after_noon, late):
    assert job(deadline, after_noon).lateness == late
