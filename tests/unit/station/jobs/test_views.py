"""Jobs as the API shows them: what a job waits for is data, whatever its words are."""

from __future__ import annotations

import pytest

from skiros_py.station.jobs.views import job_view
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState


@pytest.mark.parametrize(
    ("changes", "substates"),
    [
        ({"detail": "is it so?", "question": 3}, ("Held",)),
        ({"detail": "the program ended", "choices": ("retry", "abort")}, ("Held",)),
        ({"detail": "held: an old word", "choices": ()}, ("Suspended",)),
        ({"detail": "paused"}, ("Suspended",)),
    ],
)
def test_a_job_is_held_because_of_its_choices_and_not_because_of_its_detail_text(
    changes: dict[str, object], substates: tuple[str, ...]
) -> None:
    job = Job(order=JobOrder(id="kit", goal=("A(x)",)), number=1, state=JobState.INTERRUPTED)

    assert job_view(job.but(**changes), 0.0).state.substates == substates


def test_times_of_a_job_are_shown_in_utc() -> None:
    job = Job(order=JobOrder(id="kit", goal=("A(x)",)), number=1, state=JobState.RUNNING, ordered=1.5, started=2.0)

    shown = job_view(job, 3.0).model_dump(mode="json")

    assert (shown["ordered"], shown["started"], shown["ended"]) == (
        "1970-01-01T00:00:01.500000Z",
        "1970-01-01T00:00:02Z",
        None,
    )
