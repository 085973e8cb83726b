"""API keys: created and shown once, stored hashed in ``access.db``; a revocation takes effect immediately."""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from skiros_py.api.server import ApiKey
from skiros_py.database import COUNTED, Database, Schema
from skiros_py.errors import Busy, UsageError, WrongState
from skiros_py.messages import Message
from skiros_py.server.access.roles import LOCAL, Role
from skiros_py.station.requests import find

_UNKNOWN = "UnknownKey"
FILE = "access.db"
"""Name of the file in a data directory."""

_TABLES = """
CREATE TABLE keys (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, role TEXT NOT NULL, digest BLOB NOT NULL, ending TEXT NOT NULL,
    created REAL NOT NULL, expires REAL, revoked REAL, used REAL
) WITHOUT ROWID;
CREATE TABLE audit (number INTEGER PRIMARY KEY AUTOINCREMENT, data TEXT NOT NULL);
"""

_CHAIN = """
CREATE TABLE audit_chain (begins INTEGER NOT NULL, last INTEGER NOT NULL, hash TEXT NOT NULL);
INSERT INTO audit_chain SELECT coalesce(max(seq), 0) + 1, coalesce(max(seq), 0), '' FROM sqlite_sequence
    WHERE name = 'audit';
"""
"""First and last number of the audit records that hold the hash of the one before, and the hash of the last one."""

_SCHEMA = Schema(Message("the keys of a server"), 0x736B6163, (_TABLES, COUNTED, _CHAIN))
"""Application id of such a file: "skac"."""


def open_access(data: Path) -> Database:
    """Opens the file in a data directory; created if missing.

    Other processes may use it at the same time: keys are created and revoked from the shell while the server runs.

    Raises:
        FileError: It cannot be opened or created, or is damaged.
    """
    return Database(data / FILE, _SCHEMA, durable=True)


_LONGEST_NAME = 100
_MOST = 10_000
"""Maximum number of keys, including revoked ones."""
_COLUMNS = "id, name, role, digest, ending, created, expires, revoked, used"
_SELECT = f"SELECT 'key ' || id, {_COLUMNS} FROM keys"  # noqa: S608 - our own names
_TOKEN = re.compile(r"sk_([a-z0-9]{1,32})_[A-Za-z0-9_-]{43}")
_TOKEN_LIKE = re.compile(r"sk(?:_|%5[fF])[A-Za-z0-9]{1,32}(?:_|%5[fF])[A-Za-z0-9_%-]{8,}")


def without_keys(text: str) -> str:
    """Returns a text in which keys, complete or truncated, are masked; for logs."""
    return _TOKEN_LIKE.sub("sk_…", text) if "sk" in text else text


@dataclass(frozen=True, slots=True)
class Key:
    """A key without its secret.

    Attributes:
        id: Its id, which is part of the key itself.
        name: Name of its owner; author of the changes made with it.
        role: Role of its owner.
        ending: Its last four characters, to distinguish keys.
        created: When it was created [s since 1970].
        expires: When it expires [s since 1970]; None for never.
        revoked: When it was revoked [s since 1970]; None if it was not.
        used: When it was last used, approximately [s since 1970]; None if never.
        digest: SHA-256 of the whole key.
    """

    id: str
    name: str
    role: Role
    ending: str
    created: float
    expires: float | None
    revoked: float | None
    used: float | None
    digest: bytes

    @property
    def valid(self) -> bool:
        """True if it is neither revoked nor expired."""
        return self.revoked is None and (self.expires is None or time.time() < self.expires)


def shown(key: Key) -> ApiKey:
    """Returns a key as the API shows it."""
    return ApiKey.view_of(key, role=key.role.value, shown=f"sk_{key.id}_…{key.ending}")


class KeyStore:
    """The keys of a data directory; usable by any thread and by several processes.

    Data that requests need is kept in memory, and read again as soon as any process has changed the file. Keys are
    created and revoked over a separate connection, so that no request waits for the disk or for other programs that
    write. Close it.

    Args:
        data: The data directory.

    Raises:
        FileError: Its file cannot be opened or created, or is damaged.

    Attributes:
        local_token: Gives full access to programs that can read the data directory; renewed at each start.
        unreadable: The keys that were left out because they cannot be read, by name.
    """

    def __init__(self, data: Path) -> None:
        self.local_token = f"sk_{LOCAL}_{secrets.token_urlsafe(32)}"
        self._writes = open_access(data)
        try:
            self._reads = open_access(data)
        except BaseException:
            self._writes.close()
            raise
        self.unreadable = self._reads.unreadable
        self._guard = threading.Lock()
        self._known: Mapping[str, Key] = {}
        self._any = False
        self._seen = -1
        self._uses: dict[str, float] = {}

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._reads.close()
        self._writes.close()

    def create(self, name: str, role: Role, expires: float | None = None) -> tuple[Key, str]:
        """Creates a key.

        Args:
            name: Name of its owner.
            role: Role of its owner.
            expires: When it expires [s since 1970]; None for never.

        Returns:
            The key, and its text, which is not stored.

        Raises:
            UsageError: The name is not valid, or the time of expiry has passed.
            Busy: There are too many keys already.
        """
        _check_name(name)
        if expires is not None and not time.time() < expires < _END_OF_TIME:
            raise UsageError("a key expires in the future, and before the year 10000")
        key_id = secrets.token_hex(4)
        text = f"sk_{key_id}_{secrets.token_urlsafe(32)}"
        key = Key(key_id, name, role, text[-4:], time.time(), expires, None, None, digest(text))
        with self._writes.transaction(f"key {key.id} for {name}") as connection:
            ((count,),) = connection.execute("SELECT count(*) FROM keys").fetchall()
            if count >= _MOST:
                connection.execute("DELETE FROM keys WHERE revoked IS NOT NULL OR expires < ?", (time.time(),))
                ((count,),) = connection.execute("SELECT count(*) FROM keys").fetchall()
            if count >= _MOST:
                raise Busy(f"there are {count} keys already: revoke some", retry_after=60.0)
            connection.execute(
                f"INSERT INTO keys ({_COLUMNS}) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",  # noqa: S608 - our own names
                (key.id, name, role.value, key.digest, key.ending, key.created, expires, None, None),
            )
        return key, text

    def revoke(self, key_id: str, *, open_to_others: bool = False) -> Key:
        """Revokes a key; revoking it again has no effect.

        Args:
            key_id: Its id.
            open_to_others: True if other machines can reach the server: the last key of an administrator is then kept.

        Raises:
            NotFound: There is no such key.
            WrongState: It is the last key that can create keys.
        """
        with self._writes.transaction(f"key {key_id}, revoked") as connection:
            keys = {key.id: key for key in self._writes.readable(connection.execute(_SELECT).fetchall(), _key)}
            role = find("key", key_id, keys, _UNKNOWN).role
            if open_to_others and role is Role.ADMIN and not _another_admin(keys, key_id):
                raise WrongState(
                    "that is the last key of an administrator; without it no key can be created from another machine:"
                    " create another one first, or use 'skiros key revoke' on the server"
                )
            connection.execute("UPDATE keys SET revoked = coalesce(revoked, ?) WHERE id = ?", (time.time(), key_id))
        return self.key(key_id)

    def all(self) -> tuple[Key, ...]:
        """Returns all keys, oldest first, including revoked ones."""
        return tuple(sorted(self._now().values(), key=lambda key: (key.created, key.id)))

    def key(self, key_id: str) -> Key:
        """Returns a key.

        Raises:
            NotFound: There is no such key.
        """
        return find("key", key_id, self._now(), _UNKNOWN)

    @property
    def needed(self) -> bool:
        """True once a key has been created.

        Expired and revoked keys count: the server does not become open because its last key is gone. A user who can
        read the data directory can still get in, with the local token or by creating another key.
        """
        self._now()
        return self._any

    def is_local(self, text: str) -> bool:
        """Returns whether the text is the local token of this start of the server."""
        return hmac.compare_digest(digest(text), digest(self.local_token))

    def check(self, text: str) -> Key | None:
        """Returns the valid key with this text; None if there is none."""
        match = _TOKEN.fullmatch(text)
        key = self._now().get(match[1]) if match else None
        if key is None or not hmac.compare_digest(key.digest, digest(text)) or not key.valid:
            return None
        self._uses[key.id] = time.time()
        return key

    def recheck(self, key_id: str) -> Key | None:
        """Returns a key that was checked before if it is still valid."""
        key = self._now().get(key_id)
        return key if key is not None and key.valid else None

    def save_last_used(self, database: Database) -> None:
        """Stores when keys were last used.

        Args:
            database: The database, on a separate connection, so that requests do not wait for the write.
        """
        uses, self._uses = self._uses, {}
        if uses:
            with database.transaction("the last use of keys") as connection:
                connection.executemany("UPDATE keys SET used = ? WHERE id = ?", [(at, key) for key, at in uses.items()])

    def _now(self) -> Mapping[str, Key]:
        # data_version shows within 3 µs whether other connections wrote; this one only reads, and never waits for them.
        ((version,),) = self._reads.rows("PRAGMA data_version")
        if version != self._seen:
            with self._guard:
                rows = self._reads.rows(_SELECT)
                self._any = bool(rows)  # one that cannot be read does not open the server to all
                self._known, self._seen = {key.id: key for key in self._reads.readable(rows, _key)}, version
        return self._known


_END_OF_TIME = 253_402_300_800.0
"""The year 10000 [s since 1970]: later times cannot be represented as dates."""


def digest(text: str) -> bytes:
    """Returns the digest by which a secret is stored."""
    # A fast hash is enough: the secret is 256 random bits, not a chosen password, so it cannot be guessed; a slow
    # hash would only let unauthenticated callers keep the server busy.
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()


def _check_name(name: str) -> None:
    if not name.strip() or len(name) > _LONGEST_NAME or not name.isprintable():
        raise UsageError(
            f"the name of a key is that of its owner: 1 to {_LONGEST_NAME} printable characters, not {name[:120]!a}"
        )


def _key(
    id_: str,
    name: str,
    role: str,
    digest: bytes,
    ending: str,
    created: float,
    expires: float | None,
    revoked: float | None,
    used: float | None,
) -> Key:
    return Key(id_, name, Role(role), ending, created, expires, revoked, used, bytes(digest))


def _another_admin(keys: Mapping[str, Key], than: str) -> bool:
    return any(key.role is Role.ADMIN and key.valid and key.id != than for key in keys.values())
