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


def test_a_created_key_is_recognised(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.OPERATOR)

    assert key == keys.check(text)
    assert keys.key(key.id) == key


def test_the_key_file_contains_no_usable_secret(keys: KeyStore, tmp_path: Path) -> None:
    _, text = keys.create("anna", Role.OPERATOR)

    content = b"".join(file.read_bytes() for file in tmp_path.iterdir())

    assert text.encode() not in content
    assert text.split("_", 2)[2].encode() not in content


def test_only_the_owner_can_read_the_key_file(keys: KeyStore, tmp_path: Path) -> None:
    assert (tmp_path / FILE).stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("damage", ["role = 'admjn'", "digest = 'text'", "name = CAST(x'ff' AS TEXT), role = ''"])
def test_a_damaged_key_is_named_and_invalid_and_hides_no_other(keys: KeyStore, damage: str) -> None:
    (bad, bad_text), (good, good_text) = keys.create("anna", Role.ADMIN), keys.create("bert", Role.ADMIN)
    with keys._writes.transaction() as connection:
        connection.execute(f"UPDATE keys SET {damage} WHERE id = ?", (bad.id,))

    assert keys.check(bad_text) is None
    assert (keys.check(good_text), keys.all()) == (good, (good,))
    assert list(keys.unreadable) == [f"key {bad.id}"]


def test_a_server_whose_only_key_is_damaged_still_needs_one(keys: KeyStore) -> None:
    keys.create("anna", Role.ADMIN)
    with keys._writes.transaction() as connection:
        connection.execute("UPDATE keys SET role = '?'")

    assert keys.needed
    assert keys.all() == ()


@pytest.mark.parametrize(
    "change", [lambda t: t[:-1], lambda t: t + "a", lambda t: t.upper(), lambda t: "", lambda t: "\ud800"]
)
def test_only_the_complete_key_is_valid(keys: KeyStore, change) -> None:
    _, text = keys.create("anna", Role.ADMIN)

    assert keys.check(change(text)) is None


def test_the_id_of_one_key_with_the_secret_of_another_is_invalid(keys: KeyStore) -> None:
    (_, one), (_, other) = keys.create("anna", Role.ADMIN), keys.create("bert", Role.VIEWER)

    assert keys.check(one[:12] + other[12:]) is None


def test_a_revoked_key_is_invalid_and_revoking_it_again_changes_nothing(keys: KeyStore) -> None:
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


def test_an_expired_key_is_invalid_and_keys_are_still_needed(keys: KeyStore, tmp_path: Path) -> None:
    key, text = keys.create("anna", Role.ADMIN, time.time() + 100)
    assert keys.check(text) is not None

    with closing(open_access(tmp_path)) as database, database.transaction() as connection:
        connection.execute("UPDATE keys SET expires = ?", (time.time() - 1,))

    assert keys.check(text) is None
    assert keys.recheck(key.id) is None
    assert keys.needed


def test_keys_are_still_needed_after_the_last_key_is_revoked(keys: KeyStore) -> None:
    key, _ = keys.create("anna", Role.ADMIN)

    keys.revoke(key.id)

    assert keys.needed


def test_a_key_can_be_checked_while_another_is_created(keys: KeyStore, tmp_path: Path) -> None:
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
def test_a_key_that_expires_in_the_past_is_not_created(keys: KeyStore, expires: float) -> None:
    with pytest.raises(UsageError):
        keys.create("anna", Role.ADMIN, expires)


@pytest.mark.parametrize("name", ["", "   ", "a\nb", "a\0", "\ud800", "x" * 101])
def test_a_key_needs_a_valid_name(keys: KeyStore, name: str) -> None:
    with pytest.raises(UsageError, match="the name of a key"):
        keys.create(name, Role.ADMIN)


def test_the_last_admin_key_of_a_reachable_server_cannot_be_revoked(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.ADMIN)
    keys.create("line 1", Role.MES)
    with pytest.raises(WrongState, match="create another one first"):
        keys.revoke(key.id, open_to_others=True)
    assert keys.check(text) is not None

    keys.create("bert", Role.ADMIN)

    assert keys.revoke(key.id, open_to_others=True).revoked is not None


def test_an_unknown_key_is_answered_with_the_known_ones(keys: KeyStore) -> None:
    key, _ = keys.create("anna", Role.ADMIN)

    with pytest.raises(UnknownName) as caught:
        keys.revoke("nope")

    assert caught.value.known == (key.id,)


def test_the_local_token_is_valid_only_for_this_start(keys: KeyStore, tmp_path: Path) -> None:
    assert keys.is_local(keys.local_token)
    with closing(KeyStore(tmp_path)) as other:
        assert not keys.is_local(other.local_token)
    assert keys.check(keys.local_token) is None


def test_uses_of_keys_are_stored_later(keys: KeyStore, tmp_path: Path) -> None:
    key, text = keys.create("anna", Role.ADMIN)
    before = time.time()
    keys.check(text)
    with closing(open_access(tmp_path)) as elsewhere:
        keys.save_last_used(elsewhere)

    used = keys.key(key.id).used

    assert used is not None
    assert used >= before


def test_the_displayed_form_of_a_key_gives_no_access(keys: KeyStore) -> None:
    key, text = keys.create("anna", Role.ADMIN)

    told = shown(key).model_dump_json()

    assert text[12:-4] not in told
    assert text[-4:] in told


def test_keys_are_masked_in_text_even_if_truncated(keys: KeyStore) -> None:
    _, text = keys.create("anna", Role.ADMIN)

    for told in (f"GET /x?a={text}&b=1", text[:30], text.replace("_", "%5F", 2)):
        assert text[12:25] not in without_keys(told)
    assert without_keys("GET /tasks?skip=1") == "GET /tasks?skip=1"
