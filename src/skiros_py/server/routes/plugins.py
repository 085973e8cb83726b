"""Routes: plug-ins and their faults."""

from __future__ import annotations

from functools import cache

from fastapi import APIRouter

from skiros_py.api.plugins import PluginFaultInfo, PluginInfo, Plugins
from skiros_py.catalogue import Surveyed, survey
from skiros_py.plugins import PluginFault
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import ServicesDep

__all__ = ["router"]

router = APIRouter(tags=["plugins"])


@router.get("/plugins", summary="List the plug-ins", dependencies=[needs(Role.ENGINEER)])
def list_plugins() -> Plugins:
    """Every entry point that is installed, from which distribution, and whether it works; as the server started."""
    return _surveyed()


@router.get("/plugins/faults", summary="List broken plug-ins", dependencies=[needs(Role.ENGINEER)])
def list_plugin_faults(services: ServicesDep) -> list[PluginFaultInfo]:
    """What does not load or fit into the present scene, with the traceback for its author; all else works."""
    return [_fault(fault) for fault in services.session.catalogue.faults]


@cache
def _surveyed() -> Plugins:
    """Loads everything, once: what is installed does not change while a program runs."""
    found, others = survey()
    return Plugins(items=[_plugin(one) for one in found], others=[_fault(fault) for fault in others])


def _plugin(one: Surveyed) -> PluginInfo:
    entry = one.entry
    return PluginInfo(
        name=entry.name,
        group=entry.group,
        distribution=entry.distribution.name,
        version=entry.distribution.version,
        object=entry.value,
        works=one.works,
        faults=[_fault(fault) for fault in one.faults],
    )


def _fault(fault: PluginFault) -> PluginFaultInfo:
    return PluginFaultInfo(
        name=fault.name,
        group=fault.group,
        distribution=fault.distribution,
        reason=fault.reason,
        origin=fault.origin,
        traceback=fault.traceback,
    )
