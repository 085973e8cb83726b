"""Where somebody stands in the log: found from an id, or told why not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.api.events import ResetInfo
from skiros_py.server.streams import find_position, missed, position_text
from skiros_py.station.events.log import EventLog, Kind


@pytest.fixture
def log():
    log = EventLog(10)
    for _ in range(30):
        log.append(Kind.JOB, "running")
    return log


@pytest.mark.parametrize("number", [20, 25, 30])
def test_a_position_whose_next_event_is_kept_is_found(log, number):
    assert find_position(log, position_text(log, number)) == number


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ("{epoch}-19", "gone"),
        ("{epoch}-31", "future"),
        ("{epoch}-999999999999999999", "future"),
        ("0000ffff-25", "restarted"),
        ("25", "unknown"),
        ("", "unknown"),
        ("{epoch}--25", "unknown"),
        ("{epoch}-٢٥", "unknown"),  # digits of another script
        ("x" * 5000, "unknown"),
    ],
)
def test_any_other_position_gets_a_reset_with_a_reason_and_the_next_position(log, given, code):
    gap = find_position(log, given.format(epoch=log.epoch))
    assert isinstance(gap, ResetInfo)
    assert (gap.code, gap.id) == (code, position_text(log, 30))
    assert len(gap.why) < 200


@given(text=st.text())
def test_no_text_as_a_position_raises_an_error(text):
    assert isinstance(find_position(EventLog(1), text), ResetInfo)


def test_a_reset_lists_the_resources_to_read_again(log):
    gap = missed(log, 3)
    assert gap is not None
    assert gap.why == "the events 4 to 20 are not kept any more"
    assert "/api/v1/jobs" in gap.read
