"""Alarms come, are seen, and go; what is active is never forgotten."""

import pytest

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.errors import UnknownName, WrongState
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.events.log import EventLog
from skiros_py.station.requests import Author

ANNA = Author("anna", "anna")


@pytest.fixture
def log():
    return EventLog(10_000)


@pytest.fixture
def alarms(log):
    ticks = iter(range(1_700_000_000, 1_800_000_000))
    return Alarms(log, lambda: pytest.fail("there is no session"), lambda: float(next(ticks)))


def told(log):
    return [(event.type, event.subject) for event in log.since(0, 10_000)]


def test_an_alarm_is_raised_acknowledged_and_cleared(alarms, log):
    alarm = alarms.raise_(AlarmKind.MANAGER, "arm_1 is lost", "arm_1", severity=Severity.HIGH)
    assert (alarm.state, alarm.active) == ("unacknowledged", True)
    assert alarms.acknowledge(alarm.id, ANNA).state == "acknowledged"
    alarms.clear(AlarmKind.MANAGER, "arm_1")
    gone = alarms.get(alarm.id)
    assert (gone.state, gone.active, gone.by) == ("normal", False, "anna")
    assert told(log) == [(what, alarm.id) for what in ("raised", "acknowledged", "cleared")]


def test_an_alarm_cleared_before_its_acknowledgement_is_in_state_returned(alarms):
    alarm = alarms.raise_(AlarmKind.HALTED, "halted")
    alarms.clear(AlarmKind.HALTED)
    assert alarms.get(alarm.id).state == "returned"
    assert alarms.acknowledge(alarm.id, ANNA).state == "normal"


def test_raising_an_active_alarm_again_updates_its_text(alarms, log):
    first = alarms.raise_(AlarmKind.JOB, "held: one", "a", choices=("retry",))
    same = alarms.raise_(AlarmKind.JOB, "held: one", "a", choices=("retry",))
    other = alarms.raise_(AlarmKind.JOB, "held: two", "a", choices=("abort",))
    assert same == first
    assert (other.id, other.since, other.choices) == (first.id, first.since, ("abort",))
    assert [what for what, _ in told(log)] == ["raised", "changed"]
    assert alarms.active == (other,)


def test_raising_a_cleared_alarm_again_creates_a_new_alarm(alarms):
    first = alarms.raise_(AlarmKind.HALTED, "halted")
    alarms.clear(AlarmKind.HALTED)
    second = alarms.raise_(AlarmKind.HALTED, "halted")
    assert first.id != second.id
    assert len(alarms.all(limit=10_000).items) == 2


def test_acknowledging_twice_changes_nothing(alarms, log):
    alarm = alarms.raise_(AlarmKind.HALTED, "halted")
    once = alarms.acknowledge(alarm.id, ANNA)
    assert alarms.acknowledge(alarm.id, Author("ben", "ben")) == once
    assert len(told(log)) == 2


def test_a_momentary_alarm_ends_when_it_is_acknowledged(alarms):
    alarm = alarms.raise_(AlarmKind.TASK, "the planner broke", "a", lasts=False)
    assert not alarms.acknowledge(alarm.id, ANNA).active
    assert alarms.active == ()


def test_all_active_alarms_and_the_last_thousand_others_are_kept(alarms):
    kept = [alarms.raise_(AlarmKind.QUESTION, "?", str(n)) for n in range(1500)]
    for n in range(1500):
        alarms.raise_(AlarmKind.HALTED, str(n))
        alarms.clear(AlarmKind.HALTED)
    assert [alarm.id for alarm in alarms.active] == [alarm.id for alarm in kept]
    assert len(alarms.all(limit=10_000).items) == 2500


def test_an_answer_must_be_one_of_the_choices_of_an_active_alarm(alarms):
    asks = alarms.raise_(AlarmKind.QUESTION, "refill?", "q", choices=("done", "skip"), question=1)
    plain = alarms.raise_(AlarmKind.HALTED, "halted")
    assert alarms.require_choice(asks.id, "done") == asks
    with pytest.raises(UnknownName, match="done, skip"):
        alarms.require_choice(asks.id, "maybe")
    assert alarms.require_choice(asks.id, "done", question=1) == asks
    with pytest.raises(WrongState, match="question 7"):
        alarms.require_choice(asks.id, "done", question=7)
    with pytest.raises(WrongState, match="asks nothing"):
        alarms.require_choice(plain.id, "done")
    alarms.clear(AlarmKind.QUESTION, "q")
    with pytest.raises(WrongState, match="over"):
        alarms.require_choice(asks.id, "done")


def test_an_unknown_alarm_is_refused_with_the_known_alarms(alarms):
    alarm = alarms.raise_(AlarmKind.HALTED, "halted")
    with pytest.raises(UnknownName, match=alarm.id):
        alarms.get("1")


def test_clearing_by_kind_leaves_other_kinds(alarms):
    alarms.raise_(AlarmKind.JOB, "held", "a")
    alarms.raise_(AlarmKind.JOB, "held", "b")
    other = alarms.raise_(AlarmKind.PLUGIN, "broken", "p")
    alarms.clear_all(AlarmKind.JOB, AlarmKind.HALTED)
    assert alarms.active == (other,)


def test_an_alarm_is_serialised_with_all_its_fields(alarms):
    alarm = alarms.raise_(AlarmKind.JOB, "held", "a", choices=("retry",), job="a", question=3)
    plain = alarm.model_dump(mode="json")
    assert (plain["since"], plain["until"]) == ("2023-11-14T22:13:20Z", None)
    assert (plain["choices"], plain["job"], plain["question"]) == (["retry"], "a", 3)
