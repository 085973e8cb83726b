"""Routes: plug-ins and their faults."""

from __future__ import annotations

from fastapi import APIRouter

from skiros_py.api.modules import PluginFaultInfo, Plugins
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["plugins"])


@router.get("/plugins", summary="List the plug-ins", dependencies=[needs(Role.ENGINEER)])
def list_plugins(station: StationDep) -> Plugins:
    """Every entry point that is installed, from which distribution, and whether it works; as the server started."""
    return station.plugins.all()


@router.get("/plugins/faults", summary="List broken plug-ins", dependencies=[needs(Role.ENGINEER)])
def list_plugin_faults(station: StationDep) -> list[PluginFaultInfo]:
    """What does not load or fit into the present scene, with the traceback for its author; all else works."""
    return station.plugins.faults()
