"""Calls become requests, and answers become results or faults with words."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import JobOrder
from skiros_py.client import Client, ProblemError, Unreachable
from skiros_py.client.request import Call, arguments_of, reaching, result_of, settings_for
from skiros_py.client.topics.work import Goals, Jobs
from skiros_py.errors import SkirosError, UsageError

GET = Call("GET", "/jobs/a", Any)
URL = "http://127.0.0.1:8000"


def answered(status: int, content: bytes) -> httpx2.Response:
    return httpx2.Response(status, content=content, request=httpx2.Request("GET", URL))


@pytest.mark.parametrize("url", ["", "here", "ftp://a", "http://", "http://a?b", "http://a#b", "http://a:port", "//a"])
def test_an_invalid_address_is_refused(url: str) -> None:
    with pytest.raises(UsageError, match="no address"):
        settings_for(url, None, 1.0)


@pytest.mark.parametrize(
    "wrong", [{"url": None}, {"url": 5}, {"timeout": -1}, {"timeout": "x"}, {"timeout": 1e30}, {"tries": "x"}]
)
def test_a_client_with_wrong_settings_is_refused_at_once(wrong: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match=r"no address of a server|timeout: a positive time|tries: 1 or more"):
        Client(**wrong)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), "\ud800"])
def test_a_body_that_json_cannot_carry_is_refused_before_it_is_sent(value: Any) -> None:
    with pytest.raises(UsageError, match="plain data with finite numbers"):
        arguments_of(Call("PUT", "/signals/a", Any, json={"value": value}))


@pytest.mark.parametrize("error", [httpx2.ConnectTimeout("x"), httpx2.DecodingError("x"), httpx2.TooManyRedirects("x")])
def test_any_error_of_the_http_library_is_one_of_this_package_with_the_address(error: Exception) -> None:
    with pytest.raises(Unreachable, match=URL), reaching(URL):
        raise error


def test_fields_of_an_order_are_sent_like_the_order_and_wrong_ones_are_named(recwarn: pytest.WarningsRecorder) -> None:
    assert Jobs.put("a", {"goal": "Held(x)"}).json == Jobs.put("a", JobOrder(goal="Held(x)")).json
    assert Goals.check({"goal": "Held(x)"}).json == Goals.check(GoalOrder(goal="Held(x)")).json
    with pytest.raises(UsageError, match="priority: must be"):
        Jobs.put("a", {"goal": "Held(x)", "priority": "high"})
    assert not recwarn.list


def test_a_key_in_the_address_is_refused_without_being_shown() -> None:
    with pytest.raises(UsageError) as refused:
        settings_for("http://sk_secret@host", None, 1.0)

    assert "sk_secret" not in str(refused.value)


@pytest.mark.parametrize("key", ["two words", "line\nbreak", "schlüssel"])
def test_an_invalid_key_is_refused_without_being_shown(key: str) -> None:
    with pytest.raises(UsageError) as refused:
        settings_for(URL, key, 1.0)

    assert key not in str(refused.value)


@pytest.mark.parametrize(("url", "proxies"), [(URL, False), ("http://[::1]:1", False), ("http://mes.example", True)])
def test_local_addresses_bypass_the_proxy(url: str, proxies: bool) -> None:
    assert settings_for(url, None, 1.0)["trust_env"] is proxies


def test_dots_in_an_id_are_escaped() -> None:
    assert arguments_of(Call("GET", "/jobs/../plan", Any))["url"] == "/jobs/%2E%2E/plan"


def test_parameters_that_are_none_are_left_out() -> None:
    arguments = arguments_of(Call("GET", "/jobs", Any, query={"a": None, "b": 1}, headers={"If-Match": None}))

    assert arguments["params"] == {"b": 1}
    assert arguments["headers"] == {}


def test_a_repeatable_post_has_an_idempotency_key() -> None:
    assert arguments_of(Call("POST", "/jobs", Any))["headers"]["Idempotency-Key"]
    assert "Idempotency-Key" not in arguments_of(Call("POST", "/jobs", Any, repeatable=False))["headers"]


def test_a_problem_document_is_raised_with_its_own_message() -> None:
    body = b'{"title": "Conflict", "status": 409, "code": "InvalidJobOrderStatus", "detail": "it is over"}'

    with pytest.raises(ProblemError, match="it is over") as refused:
        result_of(GET, answered(409, body))

    assert (refused.value.status, refused.value.code) == (409, "InvalidJobOrderStatus")


@pytest.mark.parametrize("body", [b"<html>Bad Gateway</html>", b"", b"\xff", b"[]"])
def test_an_error_of_an_intermediate_server_is_shown_unchanged(body: bytes) -> None:
    with pytest.raises(ProblemError, match="502 Bad Gateway") as refused:
        result_of(GET, answered(502, body))

    assert refused.value.status == 502


def test_an_answer_that_does_not_parse_is_a_fault() -> None:
    with pytest.raises(SkirosError, match="different versions"):
        result_of(GET, answered(200, b"no json"))


def test_without_an_answer_the_error_explains_how_to_start_a_server() -> None:
    with pytest.raises(Unreachable, match="skiros serve") as fault, reaching(URL):
        raise httpx2.ConnectError("refused")

    assert fault.value.url == URL
