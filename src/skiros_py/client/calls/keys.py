"""Keys: who may come in, as what."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.keys import ApiKey, KeyOrder, NewKey
from skiros_py.client.call import Call


def list_keys() -> Call[list[ApiKey]]:
    """Lists the keys, revoked ones too."""
    return Call("GET", "/keys", list[ApiKey])


def create_key(order: KeyOrder) -> Call[NewKey]:
    """Makes a key, which is shown this once."""
    body = order.model_dump(mode="json", exclude_none=True)
    return Call("POST", "/keys", NewKey, json=body, repeatable=False)


def get_key(key: str) -> Call[ApiKey]:
    """Tells what is known of a key, by its id."""
    return Call("GET", _path(key), ApiKey)


def revoke_key(key: str) -> Call[ApiKey]:
    """Takes a key out of use, by its id."""
    return Call("DELETE", _path(key), ApiKey)


def _path(key: str) -> str:
    return f"/keys/{quote(key, safe='')}"
