"""Jobs outlive the process that took them."""

import os
import signal
import subprocess
import sys

import pytest

from skiros_py.errors import FileError, UnknownName
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore, Receipt


@pytest.fixture
def store(tmp_path):
    store = JobStore(tmp_path / "jobs.db")
    yield store
    store.close()


def job(id_="a", number=1, **changes):
    return Job(
        order=JobOrder(id=id_, goal=("InKit(Starter, kit_1)",)), number=number, state=JobState.RUNNING, **changes
    )


def entries(*steps):
    """Returns entries of a trace, one for each step."""
    return [{"time": 0.0, "what": "started", "text": "a step", "data": {}, "step": step} for step in steps]


def test_stored_jobs_are_there_after_reopening(tmp_path, store):
    kept = job(reasons=("no starter",), plan=("drive(…)",))
    store.keep(kept, Trigger.DISPATCH, "its turn")
    store.close()
    again = JobStore(tmp_path / "jobs.db")
    assert again.open() == (kept,)
    (moved,) = again.transitions("a")
    assert (moved.trigger, moved.state, moved.comment) == ("dispatch", JobState.RUNNING, "its turn")
    again.close()


def test_jobs_come_in_the_order_in_which_they_were_ordered(store):
    for name in "zma":
        store.add(job(name), Trigger.START)
    assert [kept.id for kept in store.open()] == ["z", "m", "a"]
    assert store.ids() == ("z", "m", "a")


def test_numbers_are_never_given_again(store):
    first = store.add(job("a"), Trigger.START)
    store.forget(first, "cleared")
    assert store.add(job("a"), Trigger.START).number > first.number


def test_a_job_that_cannot_be_stored_uses_no_number_and_leaves_nothing_behind(store):
    store.add(job("a"), Trigger.START, receipt=Receipt("mes", "k", "d"))
    with pytest.raises(FileError):
        store.add(job("b"), Trigger.START, receipt=Receipt("mes", "k", "other"))
    assert store.ids() == ("a",)
    assert store.last_announcement == 1
    assert store.add(job("c"), Trigger.START).number == 2


def test_an_intent_stays_open_until_it_is_settled(store):
    one = store.intend("a", "pick", {"Object": "starter_1"})
    two = store.intend("a", "drive", {"Location": "kit_1"})
    store.settle("a", one, "done")
    assert [(i.number, i.skill, i.ended) for i in store.intents("a")] == [(one, "pick", "done"), (two, "drive", None)]


def test_settling_an_unknown_intent_is_refused(store):
    with pytest.raises(UnknownName, match="step '7'"):
        store.settle("a", 7, "done")


def test_forgetting_a_job_forgets_all_of_it(store):
    store.keep(job(), Trigger.DISPATCH)
    store.intend("a", "pick", {})
    store.add_trace("a", entries(1))
    store.forget(job(), "cleared")
    assert (store.open(), store.transitions("a"), store.intents("a"), store.trace("a").entries) == ((), (), (), ())


def test_a_trace_is_kept_in_its_order(store):
    store.add_trace("a", entries(1, 2))
    store.add_trace("b", entries(9))
    store.add_trace("a", entries(3))
    assert [entry["step"] for entry in store.trace("a").entries] == [1, 2, 3]


def test_a_file_of_another_program_is_refused(tmp_path):
    (tmp_path / "jobs.db").write_bytes(b"x" * 4096)
    with pytest.raises(FileError, match="damaged, or not a list of jobs"):
        JobStore(tmp_path / "jobs.db")


def test_stored_jobs_survive_a_kill(tmp_path):
    """The writer is killed right after it says that it has kept the job."""
    code = (
        "import sys, time; from pathlib import Path\n"
        "from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger\n"
        "from skiros_py.tasks.jobs.store import JobStore\n"
        f"store = JobStore(Path({str(tmp_path / 'jobs.db')!r}))\n"
        "order = JobOrder(id='a', goal=('InKit(Starter, kit_1)',))\n"
        "store.add(Job(order=order, number=0, state=JobState.RUNNING), Trigger.START)\n"
        "store.intend('a', 'pick', {'Object': 'starter_1'})\n"
        "print('kept', flush=True); time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "kept\n"
        os.kill(writer.pid, signal.SIGKILL)
    store = JobStore(tmp_path / "jobs.db")
    assert [kept.id for kept in store.open()] == ["a"]
    assert [intent.ended for intent in store.intents("a")] == [None]
    store.close()
