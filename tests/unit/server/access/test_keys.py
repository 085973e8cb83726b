"""Keys: made, checked, revoked, by several processes at once."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.errors import UnknownName, UsageError, WrongState
from skiros_py.server.access.keys import FILE, KeyStore, open_access, shown, without_keys
from skiros_py.server.access.roles import Role


@pytest.fixture
def keys(tmp_path: Path) -> Iterator[KeyStore]:
    with closing(KeyStore(tmp_path)) as opened:
        yield opened


def test_a_key_that_was_made_is_known_again(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.OPERATOR)

    assert key == keys.check(text)
    assert keys.key(key.id) == key


def test_the_file_holds_nothing_that_opens_a_door(keys: KeyStore, tmp_path: Path) -> None:
    _, text = keys.create("anna", Role.OPERATOR)

    content = b"".join(file.read_bytes() for file in tmp_path.iterdir())

    assert text.encode() not in content
    assert text.rpartition("_")[2].encode() not in content


def test_only_its_owner_can_read_the_file(keys: KeyStore, tmp_path: Path) -> None:
    assert (tmp_path / FILE).stat().st_mode & 0o077 == 0


@pytest.mark.parametrize(
    "change", [lambda t: t[:-1], lambda t: t + "a", lambda t: t.upper(), lambda t: "", lambda t: "\ud800"]
)
def test_anything_but_the_whole_key_is_none(keys: KeyStore, change) -> None:
    _, text = keys.create("anna", Role.ADMIN)

    assert keys.check(change(text)) is None


def test_the_id_of_one_key_with_the_secret_of_another_is_none(keys: KeyStore) -> None:
    (_, one), (_, other) = keys.create("anna", Role.ADMIN), keys.create("bert", Role.VIEWER)

    assert keys.check(one[:12] + other[12:]) is None


def test_a_revoked_key_is_none_and_being_revoked_twice_changes_nothing(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.ADMIN)

    first = keys.revoke(key.id)

    assert keys.check(text) is None
    assert keys.revoke(key.id) == first


def test_a_key_revoked_by_another_process_is_invalid_at_once(keys: KeyStore, tmp_path: Path) -> None:
    key, text = keys.create("anna", Role.ADMIN)
    assert keys.check(text) is not None

    with closing(KeyStore(tmp_path)) as elsewhere:
        elsewhere.revoke(key.id)

    assert keys.check(text) is None


def test_a_key_created_by_another_process_is_valid_at_once(keys: KeyStore, tmp_path: Path) -> None:
    assert not keys.needed

    with closing(KeyStore(tmp_path)) as elsewhere:
        _, text = elsewhere.create("anna", Role.ADMIN)

    assert keys.needed
    assert keys.check(text) is not None


def test_a_key_that_expired_is_none_and_the_door_stays_locked(keys: KeyStore, tmp_path: Path) -> None:
    key, text = keys.create("anna", Role.ADMIN, time.time() + 100)
    assert keys.check(text) is not None

    with closing(open_access(tmp_path)) as database, database.transaction() as connection:
        connection.execute("UPDATE keys SET expires = ?", (time.time() - 1,))

    assert keys.check(text) is None
    assert keys.still(key.id) is None
    assert keys.needed


def test_the_door_stays_locked_when_the_last_key_is_revoked(keys: KeyStore) -> None:
    key, _ = keys.create("anna", Role.ADMIN)

    keys.revoke(key.id)

    assert keys.needed


def test_a_key_is_checked_while_another_is_being_made(keys: KeyStore, tmp_path: Path) -> None:
    _, text = keys.create("anna", Role.ADMIN)
    with closing(open_access(tmp_path)) as elsewhere, ThreadPoolExecutor(2) as pool:
        with elsewhere.transaction():  # so that whoever makes a key waits
            making = pool.submit(keys.create, "bert", Role.VIEWER)
            checked = pool.submit(keys.check, text).result()
            made_meanwhile = making.done()
        making.exception()

    assert checked is not None
    assert not made_meanwhile


@pytest.mark.parametrize("expires", [0.0, 1e300, float("nan"), float("inf")])
def test_a_key_that_is_over_before_it_begins_is_not_made(keys: KeyStore, expires: float) -> None:
    with pytest.raises(UsageError):
        keys.create("anna", Role.ADMIN, expires)


@pytest.mark.parametrize("name", ["", "   ", "a\nb", "a\0", "\ud800", "x" * 101])
def test_a_key_is_named_after_somebody(keys: KeyStore, name: str) -> None:
    with pytest.raises(UsageError, match="named after"):
        keys.create(name, Role.ADMIN)


def test_the_last_administrator_is_not_locked_out_where_others_reach_the_server(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.ADMIN)
    keys.create("line 1", Role.MES)
    with pytest.raises(WrongState, match="make one first"):
        keys.revoke(key.id, open_to_others=True)
    assert keys.check(text) is not None

    keys.create("bert", Role.ADMIN)

    assert keys.revoke(key.id, open_to_others=True).revoked is not None


def test_a_key_that_there_is_not_is_told_with_those_that_there_are(keys: KeyStore) -> None:
    key, _ = keys.create("anna", Role.ADMIN)

    with pytest.raises(UnknownName) as caught:
        keys.revoke("nope")

    assert caught.value.known == (key.id,)


def test_the_token_of_this_start_is_no_other_starts(keys: KeyStore, tmp_path: Path) -> None:
    assert keys.is_local(keys.local_token)
    with closing(KeyStore(tmp_path)) as other:
        assert not keys.is_local(other.local_token)
    assert keys.check(keys.local_token) is None


def test_uses_are_written_down_later(keys: KeyStore, tmp_path: Path) -> None:
    key, text = keys.create("anna", Role.ADMIN)
    before = time.time()
    keys.check(text)
    with closing(open_access(tmp_path)) as elsewhere:
        keys.keep_uses(elsewhere)

    used = keys.key(key.id).used

    assert used is not None
    assert used >= before


def test_what_is_shown_of_a_key_opens_nothing(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.ADMIN)

    told = shown(key).model_dump_json()

    assert text[12:-4] not in told
    assert text[-4:] in told


def test_keys_are_hidden_in_text_also_when_they_are_cut_off(keys: KeyStore) -> None:
    _, text = keys.create("anna", Role.ADMIN)

    for told in (f"GET /x?a={text}&b=1", text[:30], text.replace("_", "%5F", 2)):
        assert text[12:25] not in without_keys(told)
    assert without_keys("GET /tasks?skip=1") == "GET /tasks?skip=1"
