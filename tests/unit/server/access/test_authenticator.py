"""Who makes a request."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from starlette.datastructures import Headers

from skiros_py.errors import UsageError
from skiros_py.server.access.authenticator import COOKIE, Authenticator, check_access
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.roles import Caller, Role
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings


@pytest.fixture
def keys(tmp_path: Path) -> Iterator[KeyStore]:
    with closing(KeyStore(tmp_path)) as opened:
        yield opened


def _caller(authenticator: Authenticator, address: str = "127.0.0.1", **headers: str) -> Caller:
    return authenticator.caller(Headers({name.replace("_", "-"): text for name, text in headers.items()}), address)


def _refused(authenticator: Authenticator, address: str = "127.0.0.1", **headers: str) -> Problem:
    with pytest.raises(Problem) as caught:
        _caller(authenticator, address, **headers)
    return caught.value


def test_without_keys_local_callers_have_access_under_the_name_they_give(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)

    assert _caller(authenticator) == Caller("local", Role.ADMIN)
    assert _caller(authenticator, x_skiros_user="anna\x07" + "a" * 500).name == "anna" + "a" * 96
    assert _caller(authenticator, x_skiros_user="Jürgen".encode().decode("latin-1")).name == "Jürgen"


def test_once_a_key_exists_every_caller_needs_one(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)
    key, text = keys.create("anna", Role.VIEWER)

    assert _refused(authenticator).status == 401
    assert _caller(authenticator, authorization=f"Bearer {text}") == Caller("anna", Role.VIEWER, key.id)
    assert _caller(authenticator, x_api_key=text, x_skiros_user="bert") == Caller("anna", Role.VIEWER, key.id)


@pytest.mark.parametrize(
    "shown",
    [
        {"authorization": "Bearer nonsense"},
        {"authorization": "Bearer eyJhbGciOiJub25lIn0.eyJyb2xlIjoiYWRtaW4ifQ."},
        {"authorization": "Basic YWRtaW46YWRtaW4="},
        {"authorization": ""},
        {"x_api_key": ""},
        {"x_api_key": "sk_local_" + "A" * 43},
    ],
)
def test_a_wrong_key_is_refused_even_if_none_is_needed(keys: KeyStore, shown: dict[str, str]) -> None:
    problem = _refused(Authenticator(ServerSettings(), keys), **shown)

    assert problem.status == 401
    assert problem.headers["WWW-Authenticate"].startswith("Bearer")


def test_callers_that_guess_keys_must_wait_and_callers_with_a_valid_key_need_not(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)
    _, text = keys.create("anna", Role.VIEWER)

    answers = [_refused(authenticator, "192.0.2.1", x_api_key="wrong").status for _ in range(12)]

    assert answers == [401] * 10 + [429] * 2
    assert _refused(authenticator, "192.0.2.2", x_api_key="wrong").status == 401
    assert _caller(authenticator, "192.0.2.1", x_api_key=text).name == "anna"


def test_all_addresses_of_a_network_share_the_limit_for_wrong_keys(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)

    answers = [_refused(authenticator, f"2001:db8::{number:x}", x_api_key="wrong").status for number in range(11)]

    assert answers[-1] == 429


def test_a_login_is_valid_until_it_or_its_key_ends(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)
    key, text = keys.create("anna", Role.VIEWER)
    (_, one), (_, other) = authenticator.login(text, ""), authenticator.login(text, "")

    assert _caller(authenticator, cookie=f"a=b; {COOKIE}={one}").key == key.id
    authenticator.logout(Headers({"cookie": f"{COOKIE}={one}"}))
    assert _refused(authenticator, cookie=f"{COOKIE}={one}").status == 401
    assert _caller(authenticator, cookie=f"{COOKIE}={other}").key == key.id
    keys.create("bert", Role.VIEWER)
    keys.revoke(key.id)
    assert _refused(authenticator, cookie=f"{COOKIE}={other}").status == 401


def test_a_login_is_valid_until_its_key_is_revoked(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)
    stranger = _caller(authenticator)
    assert authenticator.recheck(stranger)

    key, text = keys.create("anna", Role.VIEWER)
    anna = _caller(authenticator, x_api_key=text)

    assert not authenticator.recheck(stranger)
    assert authenticator.recheck(anna)
    assert authenticator.recheck(_caller(authenticator, x_api_key=keys.local_token))
    keys.revoke(key.id)
    assert not authenticator.recheck(anna)


def test_the_local_token_gives_access_when_all_keys_are_lost(keys: KeyStore) -> None:
    authenticator = Authenticator(ServerSettings(), keys)
    key, text = keys.create("anna", Role.ADMIN)

    keys.revoke(key.id)

    assert _refused(authenticator).status == 401
    assert _refused(authenticator, x_api_key=text).status == 401
    assert _caller(authenticator, x_api_key=keys.local_token).role == Role.ADMIN


def test_programs_that_may_read_the_data_directory_are_administrators(keys: KeyStore) -> None:
    keys.create("anna", Role.VIEWER)

    caller = _caller(Authenticator(ServerSettings(), keys), x_api_key=keys.local_token, x_skiros_user="bert")

    assert (caller.name, caller.role) == ("bert", Role.ADMIN)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "robot.example"])
def test_a_server_reachable_by_others_does_not_start_without_a_key(keys: KeyStore, host: str) -> None:
    settings = ServerSettings(host=host)
    with pytest.raises(UsageError, match="skiros key create"):
        check_access(settings, keys)

    keys.create("anna", Role.ADMIN)

    check_access(settings, keys)
    assert _refused(Authenticator(settings, keys)).status == 401


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1"])
def test_a_server_for_this_machine_starts_without_a_key(keys: KeyStore, host: str) -> None:
    check_access(ServerSettings(host=host), keys)


def test_authentication_cannot_be_disabled_for_a_server_reachable_by_others() -> None:
    with pytest.raises(UsageError, match="could move the robots"):
        ServerSettings(host="0.0.0.0", authentication="none")
