"""``skiros key``: who may use a server, as what."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import DATA
from skiros_py.errors import FileError, escaped
from skiros_py.system import require_extra

if TYPE_CHECKING:
    from skiros_py.api.server import ApiKey
    from skiros_py.server.access.keys import KeyStore

_ROLES = ("viewer", "operator", "engineer", "admin", "mes")
_LASTING = re.compile(r"([1-9]\d{0,4})([hdw])")
_SECONDS = {"h": 3600.0, "d": 86_400.0, "w": 604_800.0}


def _lasting(text: str) -> float:
    """Parses a time span such as 12h, 90d or 4w [s]."""
    match = _LASTING.fullmatch(text)
    if match is None:
        raise click.BadParameter(f"{text!r} is no time span: give hours, days or weeks, such as 12h, 90d or 4w")
    return int(match[1]) * _SECONDS[match[2]]


@click.group("key")
def command() -> None:
    """Creates, lists and revokes keys of a server.

    It works on the data directory, whether a server runs on it or not; a revocation takes effect immediately.
    """
    require_extra("server", "skiros key")


@reports("key create 'line 1 MES' --role mes --expires 90d --data plant", command)
@click.argument("name")
@click.option("--role", required=True, type=click.Choice(_ROLES), help="Role of the key's owner.")
@click.option("--expires", type=_lasting, metavar="SPAN", help="Validity: 12h, 90d, 4w.  [default: unlimited]")
@DATA
@click.option("--new", is_flag=True, help="Create the data directory if it is missing, for a first start with a key.")
def create(name: str, role: str, expires: float | None, data: Path, new: bool) -> Found:
    """Creates a key for NAME and prints it, once: it is not stored.

    Viewers look on; operators edit scenes, order and command jobs; engineers run modules, move robots by hand and
    teach; admins make keys. A MES orders, follows and commands jobs, and nothing else.
    """
    from skiros_py.server.access.keys import shown
    from skiros_py.server.access.roles import Role

    _check_folder(data, new=new)
    with _keys(data, make=True) as keys:
        key, text = keys.create(name, Role(role), None if expires is None else time.time() + expires)
    return {"key": shown(key), "secret": text}, _shown_once(text, f"{role} key for {name}")


def _shown_once(text: str, what: str) -> Iterator[str]:
    click.echo(f"{escaped(what)}; it is shown this once:", err=True)
    yield text


@reports("key list --data plant", command)
@DATA
def list_keys(data: Path) -> Found:
    """Lists the keys, including revoked and expired ones."""
    from skiros_py.server.access.keys import shown

    with _keys(data) as keys:
        found = [shown(key) for key in keys.all()]
    return {"keys": found}, (f"{key.id}  {key.role:<8}  {key.shown}  {key.name}: {_state(key)}" for key in found)


@reports("key revoke 1f0c55a2 --data plant", command)
@click.argument("key")
@DATA
def revoke(key: str, data: Path) -> Found:
    """Revokes a key immediately and permanently; KEY is its id, as 'skiros key list' shows it."""
    from skiros_py.server.access.keys import shown

    with _keys(data) as keys:
        revoked = shown(keys.revoke(key))
    return revoked, [f"{revoked.shown} of {revoked.name} is revoked"]


def _check_folder(data: Path, *, new: bool) -> None:
    """Checks that a key is not created for a folder whose name was mistyped."""
    from skiros_py.world.journal.data_directory import make_folder

    if not (new or data.exists()):
        raise FileError(
            data,
            f"no world lives there, nor is there a folder: 'skiros serve SCENE --data {data}' begins one; with --new"
            " it is made for the key",
        )
    make_folder(data)


@contextmanager
def _keys(data: Path, *, make: bool = False) -> Iterator[KeyStore]:
    from skiros_py.server.access.keys import FILE, KeyStore

    if not make and not (data / FILE).exists():
        raise FileError(data, "no keys were made in this data directory: 'skiros key create' makes one")
    with closing(KeyStore(data)) as keys:
        yield keys


def _state(key: ApiKey) -> str:
    if key.revoked is not None:
        return f"revoked {_date(key.revoked)}"
    used = f"used {_date(key.used)}" if key.used is not None else "never used"
    if key.expires is None:
        return used
    return f"{'valid until' if key.valid else 'expired'} {_date(key.expires)}, {used}"


def _date(time_: datetime) -> str:
    return time_.astimezone().strftime("%Y-%m-%d %H:%M")
