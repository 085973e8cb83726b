"""A call is sent again where that does no harm."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest
import stamina

from skiros_py.client import Client
from skiros_py.client.request import Call, ProblemError, Unreachable, problem_of, retries, wait_after
from skiros_py.errors import SkirosError, UsageError

READ = Call("GET", "/jobs", Any)
ONCE = Call("POST", "/robots/r/jog", Any, repeatable=False)


def broken(cause: httpx2.TransportError) -> Unreachable:
    error = Unreachable("http://127.0.0.1:8000", "cut")
    error.__cause__ = cause
    return error


def answered(status: int, retry_after: str) -> ProblemError:
    return problem_of(
        httpx2.Response(
            status,
            headers=[(b"retry-after", retry_after.encode())],
            request=httpx2.Request("GET", "http://127.0.0.1:8000/api/v1/jobs"),
        )
    )


CUT = broken(httpx2.ReadError("cut"))


def test_a_repeatable_request_is_sent_again_when_the_connection_breaks() -> None:
    assert wait_after(CUT, READ) is True


def test_a_request_that_may_have_been_executed_is_not_sent_again() -> None:
    assert wait_after(CUT, ONCE) is False


def test_any_request_that_never_reached_the_server_is_sent_again() -> None:
    assert wait_after(broken(httpx2.ConnectError("refused")), ONCE) is True


def test_an_invalid_request_is_not_sent_again() -> None:
    assert wait_after(broken(httpx2.UnsupportedProtocol("ftp")), READ) is False
    assert wait_after(SkirosError("of another version"), READ) is False


def test_a_retry_waits_as_long_as_the_server_asks() -> None:
    assert wait_after(answered(429, "3"), ONCE) == 3.0
    assert wait_after(answered(503, "2"), READ) == 2.0
    assert wait_after(answered(503, "0"), READ) is not False


def test_a_possibly_executed_request_is_not_sent_again_to_a_busy_server() -> None:
    assert wait_after(answered(503, "2"), ONCE) is False


@pytest.mark.parametrize("said", ["3600", "soon", "-1", "٣", "9" * 400, ""])
def test_excessive_or_invalid_retry_times_are_not_waited_for(said: str) -> None:
    assert wait_after(answered(503, said), READ) is False


@pytest.mark.parametrize("status", [400, 404, 409, 412, 422, 500])
def test_final_answers_are_not_retried(status: int) -> None:
    assert wait_after(answered(status, "1"), READ) is False


def test_waits_between_tries_grow_and_end_with_the_last_try(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []
    monkeypatch.setattr("time.sleep", waits.append)

    def fail() -> None:
        for attempt in stamina.retry_context(**retries(READ, 4)):
            with attempt:
                raise CUT

    with pytest.raises(Unreachable):
        fail()
    assert len(waits) == 3
    assert all(least <= wait <= least + 0.1 for wait, least in zip(waits, (0.1, 0.2, 0.4), strict=True))


def test_zero_tries_are_refused() -> None:
    with pytest.raises(UsageError, match="tries: 1 or more"):
        Client(tries=0)
