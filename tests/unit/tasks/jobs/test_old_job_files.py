"""Files of jobs that an earlier version of the program wrote are brought up to date, and lose nothing."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.tasks.jobs.job import JobState, Trigger
from skiros_py.tasks.jobs.schema import SCHEMA
from skiros_py.tasks.jobs.store import JobStore

TABLES = """
CREATE TABLE jobs (id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, data TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE transitions (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX transitions_by_job ON transitions (job);
CREATE TABLE intents (job TEXT NOT NULL, number INTEGER NOT NULL, data TEXT NOT NULL, PRIMARY KEY (job, number))
    WITHOUT ROWID;
CREATE TABLE trace (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX trace_by_job ON trace (job);
CREATE TABLE numbers (last INTEGER NOT NULL);
INSERT INTO numbers VALUES (0);
PRAGMA application_id = 1936419439;
PRAGMA user_version = 1;
"""
"""As they were in version 1."""

ORDER = (
    '{"id":"%s","goal":["InKit(Starter, kit_1)"],"description":"","priority":0,"not_before":null,"deadline":null,'
    '"expires":false,"policy":{"rest":true,"ask":false,"attempts":3,"partial":false}}'
)
JOB = (
    '{"order":%s,"number":%d,"state":%d,"detail":"queued","choices":[],"question":null,"outcome":%s,"actuals":[],'
    '"reasons":[],"plan":["drive(pallet_a)"],"attempts":1,"version":4,"ordered":10.5,"started":11.25,"ended":%s}'
)


def write(path: Path) -> None:
    """Writes a file as version 1 left it: one job over, one cut off, one that waits; two were cleared."""
    jobs = (("over", 3, 5, '"succeeded"', "20.75"), ("cut", 4, 3, "null", "null"), ("waits", 5, 2, "null", "null"))
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(TABLES)
        for id_, number, state, outcome, ended in jobs:
            data = JOB % (ORDER % id_, number, state, outcome, ended)
            connection.execute("INSERT INTO jobs VALUES (?, ?, ?)", (id_, number, data))
        connection.execute("UPDATE numbers SET last = 5")
        intent = json.dumps({"number": 1, "skill": "pick", "arguments": {"Object": "starter_1"}, "ended": None})
        connection.execute("INSERT INTO intents VALUES ('cut', 1, ?)", (intent,))
        moved = json.dumps({"wall": 11.25, "trigger": "dispatch", "state": 3, "comment": "its turn"})
        connection.execute("INSERT INTO transitions VALUES ('cut', ?)", (moved,))
        connection.commit()


@pytest.fixture
def store(tmp_path):
    write(tmp_path / "jobs.db")
    store = JobStore(tmp_path / "jobs.db")
    yield store
    store.close()


def test_the_application_id_of_job_files_is_unchanged():
    assert f"application_id = {SCHEMA.application};" in TABLES


def test_an_upgraded_file_has_all_jobs_with_their_states(store):
    assert [job.id for job in store.open()] == ["cut", "waits"]
    assert [job.id for job in store.page(states={JobState.ENDED}).jobs] == ["over"]
    assert store.job("over").ended == 20.75
    assert store.job("waits").order.materials == ()


def test_an_upgraded_file_has_the_intents_and_transitions_of_its_jobs(store):
    assert [(intent.skill, intent.ended) for intent in store.intents("cut")] == [("pick", None)]
    assert [each.comment for each in store.transitions("cut")] == ["its turn"]


def test_an_upgraded_file_has_the_times_of_the_last_changes(store):
    assert [job.id for job in store.page(since=20.0).jobs] == ["over"]


def test_a_job_added_to_an_upgraded_file_has_the_next_number_and_the_first_announcement(store):
    waiting = store.job("waits")
    order = waiting.order.model_copy(update={"id": "new"})
    assert store.add(waiting.model_copy(update={"order": order}), Trigger.START).number == 6
    assert store.last_announcement == 1


def damage(store: JobStore, table: str, which: str) -> None:
    """Makes records unreadable."""
    with store._database.transaction() as connection:
        connection.execute(f"UPDATE {table} SET data = '{{' WHERE {which}")


def test_unreadable_jobs_are_named_and_hide_no_others(store):
    damage(store, "jobs", "id IN ('over', 'waits')")
    assert [job.id for job in store.open()] == ["cut"]
    assert list(store.unreadable) == ["job waits"]
    seen, after = [], 0
    while after is not None:
        page = store.page(after=after, limit=1)
        seen += [job.id for job in page.jobs]
        after = page.next
    assert seen == ["cut"]
    assert list(store.unreadable) == ["job waits", "job over"]
    with pytest.raises(FileError, match="job waits cannot be read: Invalid JSON"):
        store.job("waits")
    assert store.ids() == ("over", "cut", "waits")


@pytest.mark.parametrize(
    ("table", "name"), [("intents", "step 1 of job cut"), ("transitions", "a state change of job cut")]
)
def test_an_unreadable_record_of_a_job_is_named_and_hides_no_others(store, table, name):
    damage(store, table, "job = 'cut'")
    store.intend("cut", "place", {})
    store.keep(store.job("cut"), Trigger.HOLD)
    assert [intent.skill for intent in store.intents("cut")] == ["pick", "place"][table == "intents" :]
    assert [each.trigger for each in store.transitions("cut")] == ["dispatch", "hold"][table == "transitions" :]
    assert list(store.unreadable) == [name]


def test_an_unreadable_announcement_is_named_and_hides_no_others(store):
    for trigger in (Trigger.HOLD, Trigger.RESUME):
        store.keep(store.job("cut"), trigger)
    damage(store, "announcements", "number = 1")
    assert [each.trigger for each in store.announcements(0, 9)] == ["resume"]
    assert list(store.unreadable) == ["announcement 1"]
