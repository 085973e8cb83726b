"""Keys: who may come in, as what. Made, listed, and revoked at once."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response

from skiros_py.api.access import ApiKey, KeyOrder, NewKey
from skiros_py.server.access.keys import shown
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import ServicesDep
from skiros_py.server.settings import is_loopback
from skiros_py.station.requests import addressed

router = APIRouter(prefix="/keys", tags=["access"])

KeyId = Annotated[str, Path(max_length=64, description="Id of the key.", examples=["1f0c55a2"])]


@router.get("", summary="All keys", dependencies=[needs(Role.ADMIN)])
def list_keys(services: ServicesDep) -> list[ApiKey]:
    """Lists the keys, revoked and expired ones too; what is secret about them is kept nowhere."""
    return [shown(key) for key in services.keys.all()]


@router.post("", status_code=201, summary="Make a key", dependencies=[needs(Role.ADMIN)])
def create_key(order: KeyOrder, services: ServicesDep, response: Response) -> NewKey:
    """Makes a key. It is shown in this answer and never again; with the first one, everybody needs one."""
    expires = order.expires.timestamp() if order.expires is not None else None
    key, text = services.keys.create(order.name, Role(order.role), expires)
    response.headers["Location"] = f"/api/v1/keys/{key.id}"
    return NewKey(key=shown(key), secret=text)


@router.get("/{key_id}", summary="One key", dependencies=[needs(Role.ADMIN)])
def get_key(key_id: KeyId, services: ServicesDep) -> ApiKey:
    """Describes a key."""
    with addressed("UnknownKey"):
        return shown(services.keys.key(key_id))


@router.delete("/{key_id}", summary="Revoke a key", dependencies=[needs(Role.ADMIN)])
def revoke_key(key_id: KeyId, services: ServicesDep) -> ApiKey:
    """Takes a key out of use, at once and for good; its logins and streams end. Once more does no harm.

    Where other machines reach the server, the last key of an administrator stays.
    """
    with addressed("UnknownKey"):
        return shown(services.keys.revoke(key_id, open_to_others=not is_loopback(services.settings.host)))
