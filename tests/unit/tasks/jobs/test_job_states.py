"""The states of a job follow ISA-95 job control."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import UsageError
from skiros_py.tasks.jobs.job import JobState, Trigger, allowed, next_state

S, T = JobState, Trigger

STANDARD = [
    (S.NOT_ALLOWED_TO_START, T.START, S.ALLOWED_TO_START),
    (S.NOT_ALLOWED_TO_START, T.UPDATE, S.NOT_ALLOWED_TO_START),
    (S.NOT_ALLOWED_TO_START, T.ABORT, S.ABORTED),
    (S.ALLOWED_TO_START, T.REVOKE_START, S.NOT_ALLOWED_TO_START),
    (S.ALLOWED_TO_START, T.UPDATE, S.ALLOWED_TO_START),
    (S.ALLOWED_TO_START, T.DISPATCH, S.RUNNING),
    (S.ALLOWED_TO_START, T.ABORT, S.ABORTED),
    (S.RUNNING, T.PAUSE, S.INTERRUPTED),
    (S.RUNNING, T.STOP, S.ENDED),
    (S.RUNNING, T.ABORT, S.ABORTED),
    (S.RUNNING, T.FINISH, S.ENDED),
    (S.INTERRUPTED, T.RESUME, S.RUNNING),
    (S.INTERRUPTED, T.STOP, S.ENDED),
    (S.INTERRUPTED, T.ABORT, S.ABORTED),
]
"""The rows of the standard's table (OPC 10031-4, 6.2), as read there."""


@pytest.mark.parametrize(("state", "trigger", "follows"), STANDARD, ids=lambda value: getattr(value, "name", value))
def test_state_transitions_match_the_table_of_the_standard(state, trigger, follows):
    assert next_state(state, trigger) is follows


def test_state_numbers_match_the_standard():
    assert [state.value for state in JobState] == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("state", [S.ENDED, S.ABORTED])
@pytest.mark.parametrize("trigger", list(Trigger))
def test_an_ended_job_has_no_further_transitions(state, trigger):
    with pytest.raises(UsageError, match="it is over"):
        next_state(state, trigger)


def test_a_refused_command_lists_the_possible_commands():
    def refused(state):
        with pytest.raises(UsageError) as error:
            next_state(state, T.START)
        return str(error.value).partition("; it takes ")[2]

    assert refused(S.ALLOWED_TO_START) == "revoke start, update, abort, cancel"
    assert refused(S.RUNNING) == "pause, stop, abort"
    assert refused(S.INTERRUPTED) == "resume, stop, abort"
    assert refused(S.ENDED) == "clear: it is over"


@given(st.lists(st.sampled_from(list(Trigger)), max_size=30))
def test_a_started_job_never_waits_for_its_start_again(triggers):
    state, begun = S.NOT_ALLOWED_TO_START, False
    for trigger in triggers:
        if trigger in allowed(state):
            state = next_state(state, trigger)
            begun = begun or state.has_begun
            assert not (begun and state in (S.NOT_ALLOWED_TO_START, S.ALLOWED_TO_START))
