"""What the sentences of jobs are made of is stored, and sent, with them."""

from __future__ import annotations

from skiros_py.messages import Message
from skiros_py.station.events.log import EventLog, Kind
from skiros_py.station.jobs.views import job_view
from skiros_py.tasks.jobs.job import Actual, Job, JobOrder, JobState

WHY = Message("{thing} is {kind}", thing="ball_1", kind=Message("a {kind}", kind="Ball"))


def ended() -> Job:
    order = JobOrder(id="kit-1", goal=("In(ball_1, box_a)",))
    actual = Actual(condition="In(ball_1, box_a)", reached=False, reason=WHY)
    return Job(order=order, number=1, state=JobState.ENDED).but(actuals=(actual,), reasons=(WHY,), detail="planning")


def test_the_sentences_of_a_job_are_messages_after_a_restart() -> None:
    job = Job.model_validate_json(ended().model_dump_json())
    assert job == ended()
    assert isinstance(job.reasons[0], Message)
    assert job.reasons[0].data == WHY.data
    assert isinstance(job.actuals[0].reason, Message)


def test_a_job_as_sent_has_english_sentences_and_what_they_are_made_of() -> None:
    sent = job_view(ended(), 0.0).model_dump(mode="json", by_alias=True)
    assert sent["reasons"] == ["ball_1 is a Ball"]
    assert sent["texts"] == {"ball_1 is a Ball": WHY.data}


def test_an_event_says_what_its_sentences_are_made_of() -> None:
    event = EventLog(10).append(Kind.TASK, "failed", data={"text": WHY, "step": 1})
    assert event.data == {"text": "ball_1 is a Ball", "step": 1, "texts": {"ball_1 is a Ball": WHY.data}}
