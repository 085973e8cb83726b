"""Jobs on the kitting cell (fake robot): ordered, done in their order, commanded, kept over restarts and kills."""

import json
import os
import signal
import subprocess
import sys
from datetime import UTC, datetime, timedelta

import pytest

from skiros_py.errors import UnknownName, UsageError
from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import JobOrder, JobState, Outcome
from skiros_py.tasks.policy import Policy

STARTER = "InKit(Starter, kit_1)"
ALTERNATOR = "InKit(Alternator, kit_1)"
IMPOSSIBLE = "ObjectAtLocation(starter_1, kit_1_b) and ObjectAtLocation(starter_1, kit_1_c)"


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


@pytest.fixture
def session(data):
    with Session("kitting", Options(fake=True, data=data)) as session:
        yield session


def order(id_, goal=STARTER, **more):
    return JobOrder(id=id_, goal=(goal,), **more)


def states(session):
    return {job.id: (job.state, job.outcome) for job in session.jobs.store.page().jobs}


def step_until(session, reached, cycles=20_000):
    for _ in range(cycles):
        if reached():
            return
        session.cycle.step()
    raise AssertionError("it was never reached")


def test_a_finished_job_reports_the_result_of_each_condition(session):
    session.jobs.submit(order("a", f"{STARTER} and {ALTERNATOR}"))
    session.run_jobs()
    job = session.jobs.job("a")
    assert (job.state, job.outcome) == (JobState.ENDED, Outcome.SUCCEEDED)
    assert [(a.condition, a.reached) for a in job.actuals] == [(STARTER, True), (ALTERNATOR, True)]
    assert len(job.plan) == 8


def test_a_goal_that_already_holds_has_its_own_outcome(session):
    session.jobs.submit(order("a"))
    session.jobs.submit(order("b"))
    session.run_jobs()
    assert states(session)["b"] == (JobState.ENDED, Outcome.ALREADY_SATISFIED)


def test_a_job_without_a_plan_is_aborted_with_the_reasons(session):
    session.jobs.submit(order("a", IMPOSSIBLE))
    session.run_jobs()
    job = session.jobs.job("a")
    assert (job.state, job.outcome) == (JobState.ABORTED, Outcome.NO_PLAN)
    assert "starter_1" in job.reasons[0]


def test_jobs_start_by_priority_then_deadline_then_time_of_order(session):
    begun = []
    session.jobs.subscribe(lambda job: job.detail == "planning" and job.id not in begun and begun.append(job.id))
    soon, later = (datetime.now(UTC) + timedelta(hours=hours) for hours in (1, 2))
    for one in (
        order("last"),
        order("later", deadline=later),
        order("soon", deadline=soon),
        order("first", priority=1),
    ):
        session.jobs.submit(one)
    session.run_jobs()
    assert begun == ["first", "soon", "later", "last"]


def test_a_job_does_not_start_before_its_earliest_start_time(session):
    session.jobs.submit(order("a", not_before=datetime.now(UTC) + timedelta(hours=1)))
    session.run_jobs()
    assert session.jobs.job("a").state is JobState.ALLOWED_TO_START


def test_an_expiring_job_is_not_started_after_its_deadline(session):
    past = datetime.now(UTC) - timedelta(seconds=1)
    session.jobs.submit(order("a", deadline=past, expires=True))
    session.jobs.submit(order("b", deadline=past))
    session.run_jobs()
    assert states(session)["a"] == (JobState.ABORTED, Outcome.EXPIRED)
    assert session.jobs.job("b").outcome is Outcome.SUCCEEDED
    assert session.jobs.job("b").late


def test_ordering_the_same_job_twice_creates_one_job(session):
    first = session.jobs.submit(order("a"))
    assert session.jobs.submit(order("a")) == first
    assert len(session.jobs.store.page().jobs) == 1


def test_another_order_under_the_same_id_is_refused(session):
    session.jobs.submit(order("a"))
    with pytest.raises(UsageError, match="'a' is there already"):
        session.jobs.submit(order("a", ALTERNATOR))


def test_an_unparsable_goal_is_refused_and_not_stored(session):
    with pytest.raises(UnknownName, match="condition 'InnKit'"):
        session.jobs.submit(order("a", "InnKit(Starter, kit_1)"))
    assert not session.jobs.store.page().jobs


def test_a_job_that_is_not_allowed_to_start_does_not_start(session):
    session.jobs.submit(order("a"), start=False)
    session.run_jobs()
    assert states(session)["a"] == (JobState.NOT_ALLOWED_TO_START, None)
    session.jobs.start("a")
    session.jobs.revoke_start("a")
    session.run_jobs()
    assert states(session)["a"] == (JobState.NOT_ALLOWED_TO_START, None)
    session.jobs.start("a")
    session.run_jobs()
    assert states(session)["a"] == (JobState.ENDED, Outcome.SUCCEEDED)


def test_a_paused_job_stands_still_and_continues_after_resume(session):
    session.jobs.submit(order("a"))
    step_until(session, lambda: session.jobs.job("a").detail == "running")
    session.jobs.pause("a", "somebody walks by")
    assert session.jobs.job("a").state is JobState.INTERRUPTED
    for _ in range(3000):
        session.cycle.step()
    assert session.jobs.job("a").state is JobState.INTERRUPTED
    session.jobs.resume("a")
    session.run_jobs()
    assert states(session)["a"] == (JobState.ENDED, Outcome.SUCCEEDED)


@pytest.mark.parametrize(
    ("command", "state", "outcome"),
    [("stop", JobState.ENDED, Outcome.STOPPED), ("abort", JobState.ABORTED, Outcome.ABORTED)],
)
def test_a_running_job_can_be_ended_and_ending_it_again_changes_nothing(session, command, state, outcome):
    session.jobs.submit(order("a"))
    step_until(session, lambda: session.jobs.job("a").detail == "running")
    getattr(session.jobs, command)("a", "enough")
    getattr(session.jobs, command)("a", "enough")
    session.run_jobs()
    assert states(session)["a"] == (state, outcome)
    assert not session.tasks.active


def test_a_queued_job_can_be_cancelled_and_a_finished_one_cleared(session):
    session.jobs.submit(order("a"))
    session.jobs.cancel("a")
    session.jobs.submit(order("b"))
    with pytest.raises(UsageError, match="not over"):
        session.jobs.clear("b")
    session.run_jobs()
    with pytest.raises(UsageError, match="has begun"):
        session.jobs.cancel("b")
    session.jobs.clear("b")
    assert not session.jobs.store.page().jobs


def test_jobs_and_their_details_survive_a_restart(data):
    with Session("kitting", Options(fake=True, data=data)) as session:
        session.jobs.submit(order("a"))
        session.run_jobs()
        before = session.jobs.job("a")
    with Session("kitting", Options(fake=True, data=data)) as session:
        assert session.jobs.job("a") == before
        assert session.world.placement("starter_1").place.startswith("kit_1_")


_KILLED = """
import json, sys
from pathlib import Path
from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import JobOrder
with Session("kitting", Options(fake=True, data=Path(sys.argv[1]), pace=2.0)) as session:
    session.jobs.submit(JobOrder(id="a", goal=("InKit(Starter, kit_1)",)))
    session.jobs.submit(JobOrder(id="b", goal=("InKit(Alternator, kit_1)",)))
    session.monitor.subscribe(lambda e: e.kind == "skill" and print(json.dumps([e.module, e.status.value]), flush=True))
    session.run_jobs()
"""


def run_until(data, module, status="started"):
    """Runs jobs in a process of their own and kills it when a skill has got so far."""
    with subprocess.Popen([sys.executable, "-c", _KILLED, str(data)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if json.loads(line) == [module, status]:
                os.kill(process.pid, signal.SIGKILL)
                break


def test_after_a_kill_during_a_motion_the_job_waits_for_a_person(data):
    run_until(data, "pick")
    with Session("kitting", Options(fake=True, data=data)) as session:
        job = session.jobs.job("a")
        assert job.state is JobState.INTERRUPTED
        assert "pick" in job.detail
        assert job.choices == ("retry", "done by hand", "abort")
        assert session.jobs.job("b").state is JobState.ALLOWED_TO_START


def test_after_a_kill_a_retry_succeeds_and_repeats_nothing(data):
    run_until(data, "pick")
    with Session("kitting", Options(fake=True, data=data)) as session:
        session.jobs.answer("a", "retry", by="ann")
        session.run_jobs()
        assert {job.outcome for job in session.jobs.store.page().jobs} == {Outcome.SUCCEEDED}
        done = [i for i in session.jobs.intents("a") if i.ended == "done"]
        assert [i.skill for i in done] == ["drive", "pick", "drive", "place"]


def test_after_a_kill_steps_done_by_a_person_are_not_repeated(data):
    run_until(data, "pick")
    with Session("kitting", Options(fake=True, data=data)) as session:
        session.jobs.answer("a", "done by hand", by="ann")
        session.run_jobs()
        assert session.jobs.job("a").outcome is Outcome.SUCCEEDED
        assert [(i.skill, i.ended) for i in session.jobs.intents("a") if i.skill == "pick"] == [
            ("pick", "done by hand, says ann")
        ]


def test_after_a_kill_a_job_can_be_aborted(data):
    run_until(data, "drive")
    with Session("kitting", Options(fake=True, data=data)) as session:
        session.jobs.answer("a", "abort", by="ann")
        assert states(session)["a"] == (JobState.ABORTED, Outcome.ABORTED)


def test_an_answer_that_was_not_offered_is_refused(data):
    run_until(data, "drive")
    with (
        Session("kitting", Options(fake=True, data=data)) as session,
        pytest.raises(UnknownName, match="answer 'later'"),
    ):
        session.jobs.answer("a", "later", by="ann")


def test_two_jobs_that_need_the_same_robot_run_one_after_the_other(session):
    session.jobs.submit(order("a", STARTER, policy=Policy(rest=False)))
    session.jobs.submit(order("b", ALTERNATOR))
    session.run_jobs()
    first, second = (session.jobs.job(name) for name in "ab")
    assert first.ended <= second.started
    assert (first.outcome, second.outcome) == (Outcome.SUCCEEDED, Outcome.SUCCEEDED)


def test_the_trace_of_a_job_can_be_read_as_sentences(session):
    session.jobs.submit(order("a"))
    session.run_jobs()
    texts = " ".join(entry["text"] for entry in session.jobs.trace("a"))
    assert "drive" in texts
    assert "pick" in texts


def test_after_a_halt_a_job_waits_for_a_person(session):
    session.jobs.submit(order("a"))
    step_until(session, lambda: session.jobs.job("a").detail == "running")
    session.cycle.stop_all("somebody hit the button")
    session.cycle.step()
    assert session.jobs.job("a").state is JobState.INTERRUPTED
    assert "somebody hit the button" in session.jobs.job("a").detail
    session.reset()
    session.jobs.answer("a", "retry", by="ann")
    session.run_jobs()
    assert states(session)["a"] == (JobState.ENDED, Outcome.SUCCEEDED)


def test_a_job_that_needs_a_person_is_held_with_choices_and_goes_on_with_the_answer(session):
    """Nobody can reach a part whose shelf nobody may work at: its driving pose is gone when the plan is made."""
    policy = Policy(ask=True, partial=True)
    session.jobs.submit(order("a", f"{STARTER} and not ObjectAtLocation(compressor_1, pallet_b)", policy=policy))
    with session.world.transaction("test", "nobody fits the compressor any more") as tx:
        tx.set("compressor_1", "sk:graspWidth", 0.5)
    step_until(session, lambda: session.jobs.job("a").choices)
    job = session.jobs.job("a")
    assert job.state is JobState.INTERRUPTED
    assert set(job.choices) >= {"retry", "done by hand", "skip", "abort"}
    session.jobs.answer("a", "skip", by="ann")
    session.run_jobs()
    job = session.jobs.job("a")
    assert (job.state, job.outcome) == (JobState.ENDED, Outcome.PARTIALLY_SUCCEEDED)
    assert [a.reached for a in job.actuals] == [True, False]
    assert job.actuals[1].reason
