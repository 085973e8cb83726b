"""A call is sent again where that does no harm."""

from __future__ import annotations

import httpx2
import pytest

from skiros_py.client.call import Call, plain
from skiros_py.client.patience import Patience
from skiros_py.errors import UsageError

READ = Call("GET", "/jobs", plain)
ONCE = Call("POST", "/robots/r/jog", plain, repeatable=False)
BROKEN = httpx2.ReadError("cut")


def answered(status: int, **headers: str) -> httpx2.Response:
    return httpx2.Response(status, headers={name.replace("_", "-"): value for name, value in headers.items()})


def test_what_may_be_repeated_is_sent_again_when_the_connection_breaks() -> None:
    assert Patience().wait_after(BROKEN, READ, 1) is not None


def test_what_may_have_been_done_already_is_not_sent_again() -> None:
    assert Patience().wait_after(BROKEN, ONCE, 1) is None


def test_what_never_reached_the_server_is_sent_again_whatever_it_is() -> None:
    assert Patience().wait_after(httpx2.ConnectError("refused"), ONCE, 1) is not None


def test_it_waits_for_as_long_as_the_server_asks() -> None:
    assert Patience().wait_after(answered(429, retry_after="3"), ONCE, 1) == 3.0
    assert Patience().wait_after(answered(503, retry_after="2"), READ, 1) == 2.0


@pytest.mark.parametrize("said", ["3600", "soon", "-1", "٣", "9" * 400, ""])
def test_nobody_waits_for_an_hour_or_for_nonsense(said: str) -> None:
    response = httpx2.Response(503, headers=[(b"retry-after", said.encode())])

    assert Patience().wait_after(response, READ, 1) is None


@pytest.mark.parametrize("status", [200, 202, 400, 404, 409, 412, 422, 500])
def test_an_answer_is_an_answer(status: int) -> None:
    assert Patience().wait_after(answered(status, retry_after="1"), READ, 1) is None


def test_waits_grow_and_end_with_the_last_try() -> None:
    waits = [Patience(tries=4).wait_after(BROKEN, READ, sent) for sent in (1, 2, 3, 4)]

    assert waits[-1] is None
    assert all(0.05 <= wait <= 0.4 for wait in waits[:-1] if wait is not None)


def test_never_to_try_is_refused() -> None:
    with pytest.raises(UsageError, match="tries: 1 or more"):
        Patience(0)
