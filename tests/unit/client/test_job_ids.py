"""What can be no id of a job is not sent anywhere."""

from __future__ import annotations

import pytest

from skiros_py.client.calls.jobs import get_job, pause_job
from skiros_py.errors import UsageError


@pytest.mark.parametrize("name", ["", "../x", "a b", "a\tb", "a\x00", "x" * 201])
def test_what_can_be_no_id_is_refused_with_its_name(name: str) -> None:
    for call in (get_job, pause_job):
        with pytest.raises(UsageError, match="can be no id of a job") as told:
            call(name)
        assert repr(name[:80]) in str(told.value)


@pytest.mark.parametrize("name", ["kit-17", "x" * 200, "..", "a?b#c", "päckchen", "%2F"])
def test_ids_that_are_odd_are_sent(name: str) -> None:
    assert "?" not in get_job(name).path
