"""What can be no id is not sent anywhere."""

from __future__ import annotations

import pytest

from skiros_py.client.topics import Jobs
from skiros_py.errors import UsageError


@pytest.mark.parametrize("name", ["", "../x", "a\tb", "a\x00", "x" * 301])
def test_an_invalid_id_is_refused_with_its_parameter_name(name: str) -> None:
    for call in (Jobs.get, Jobs.pause):
        with pytest.raises(UsageError, match="can be no id") as told:
            call(name)
        assert repr(name[:80]) in str(told.value)


@pytest.mark.parametrize("name", ["kit-17", "x" * 200, "..", "a?b#c", "päckchen", "%2F"])
def test_unusual_but_valid_ids_are_sent(name: str) -> None:
    assert "?" not in Jobs.get(name).path
