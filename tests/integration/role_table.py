"""Who may call which operation, written by hand: what the server says of itself is held against this.

A line is a path below ``/api/v1`` (or from the root, with two slashes) with the methods that ask for the role of its
block at least; ``+`` behind a method says that a factory system may call it, too.
"""

from __future__ import annotations

from collections.abc import Iterator

_LADDER = ("viewer", "operator", "engineer", "admin")

_TABLE = {
    "nobody": """
        //healthz GET
        //readyz GET
        /session POST
    """,
    "viewer": """
        //metrics GET
        /session GET+ DELETE+
        /jobs GET+
        /jobs/{id} GET+
        /job-responses GET+
        /capabilities GET+
        /jobs/{id}/response GET+
        /jobs/{id}/plan GET+
        /jobs/{id}/trace GET+
        /jobs/{id}/report GET+
        /jobs/{id}/transitions GET+
        /jobs/{id}/replay GET
        /jobs/{id}/recording GET
        /jobs/{id}/explanation GET+
        /jobs/{job}/events GET+
        /goals GET+
        /goals/check POST+
        /goals/conditions GET+
        /events GET+
        /events/recent GET+
        /alarms GET+
        /alarms/{alarm} GET+
        /stop GET+
        /state GET
        /world GET
        /world/changes GET
        /world/changes/{number} GET
        /view GET
        /tree GET
        /elements GET
        /elements/{element} GET
        /elements/{element}/relations GET
        /elements/{element}/history GET
        /ontology/classes GET
        /ontology/classes/{name} GET
        /ontology/relations GET
        /ontology/properties GET
        /ontology/placements GET
        /learned GET
        /learned.ttl GET
        /locks GET
        /scenes GET
        /scenes/{name} GET
        /scene GET
        /scene.ttl GET
        /scene/diff GET
        /simulation GET
        /simulation/bodies GET
        /simulation/picture GET
        /managers GET
        /modules GET
        /modules/{agent}/{module} GET
        /module-runs GET
        /documents GET
        /documents/{kind} GET+
        /documents/{kind}/{id} GET+
        /documents/{kind}/{id}/text GET
        /documents/{kind}/{id}/revisions GET
        /module-runs/{id} GET
        /skills GET
        /skills/{name} GET
        /tasks GET
        /tasks/{name} GET
        /tasks/{name}/trace GET
        /devices GET
        /devices/{id} GET
        /devices/{id}/state GET
        /signals GET
        /signals/values GET
        /robots GET
        /robots/{id} GET
        /robots/{id}/state GET
        /robots/{id}/model GET
        /robots/{id}/model/meshes/{name} GET
        /devices/{id}/motion GET
        /devices/{id}/observation GET
        /robots/state/stream GET
    """,
    "operator": """
        /jobs POST+
        /jobs/{id} PUT+ DELETE+
        /jobs/{id}/start POST+
        /jobs/{id}/revoke-start POST+
        /jobs/{id}/pause POST+
        /jobs/{id}/resume POST+
        /jobs/{id}/stop POST+
        /jobs/{id}/abort POST+
        /jobs/{id}/cancel POST+
        /jobs/{id}/clear POST+
        /jobs/{id}/answer POST+
        /previews GET+ POST+
        /previews/{id} GET+
        /previews/{id}/repairs/{number}/apply POST
        /alarms/{alarm}/answer POST+
        /alarms/{alarm}/acknowledge POST
        /stop POST+
        /reset POST
        /goals PUT
        /documents/{kind}/{id} PUT DELETE
        /documents/{kind}/{id}/text PUT
        /world/transactions POST
        /world/undo POST
        /world/redo POST
        /elements POST
        /elements/{element} PATCH DELETE
        /elements/{element}/relations/{relation}/{other} PUT DELETE
        /locks POST DELETE
        /scenes POST
        /scenes/{name} DELETE
        /scene PUT
        /signals/{name}/value PUT
        /tasks POST
        /tasks/{name}/{command} POST
    """,
    "engineer": """
        /queries POST
        /learned POST
        /learned/import POST
        /learned/forget POST
        /learned/{element} PATCH DELETE
        /simulation/bodies/{element} DELETE
        /simulation/bodies/{element}/pose PUT
        /simulation/reset POST
        /simulation/pace PUT
        /managers/{agent} PUT DELETE
        /devices/{id}/open POST
        /devices/{id}/close POST
        /devices/{id}/jog POST
        /devices/{id}/teach POST
        /modules/{agent}/{module}/panel POST
        /modules/{agent}/{module}/runs POST
        /modules/{agent}/{module}/reset POST
        /module-runs/{id}/breakpoints PUT
        /module-runs/{id}/{command} POST
        /plugins GET
        /plugins/faults GET
    """,
    "admin": """
        /webhooks GET POST
        /webhooks/dead-letters GET
        /webhooks/{webhook} GET PATCH DELETE
        /webhooks/{webhook}/ping POST
        /webhooks/{webhook}/deliveries GET
        /webhooks/{webhook}/deliveries/{number}/redeliver POST
        /keys GET POST
        /keys/{key_id} GET DELETE
        /audit GET
        /audit/export GET
        /data/findings GET
        /data/backups POST
    """,
}


def _rows() -> Iterator[tuple[str, str, str, bool]]:
    """Yields least role, method, path, and whether a factory system may."""
    for least, block in _TABLE.items():
        for line in block.strip().splitlines():
            path, *methods = line.split()
            whole = path[1:] if path.startswith("//") else f"/api/v1{path}"
            for method in methods:
                yield least, method.rstrip("+"), whole, method.endswith("+")


def _allowed(least: str, mes: bool) -> frozenset[str]:
    return frozenset(_LADDER[_LADDER.index(least) :]) | (frozenset({"mes"}) if mes else frozenset())


OPEN = frozenset((method, path) for least, method, path, _ in _rows() if least == "nobody")
"""What needs no key: methods and paths."""
ROLES = {(method, path): _allowed(least, mes) for least, method, path, mes in _rows() if least != "nobody"}
"""Who may call the others: methods and paths, and roles."""
