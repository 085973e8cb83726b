"""Use cases: the installed plug-ins, and their faults."""

from __future__ import annotations

from functools import cache

from skiros_py.api.modules import PluginFaultInfo, PluginInfo, Plugins
from skiros_py.catalogue import Surveyed, survey
from skiros_py.plugins import PluginFault
from skiros_py.station.requests import Service


class PluginService(Service):
    """Lists plug-ins."""

    def all(self) -> Plugins:
        """Lists every installed entry point, and whether it works."""
        return _surveyed()

    def faults(self) -> list[PluginFaultInfo]:
        """Lists the plug-ins that do not load or do not fit the present scene."""
        return [_fault(fault) for fault in self._station.session.catalogue.faults]


@cache
def _surveyed() -> Plugins:
    """Loads all entry points, once: the installation does not change while a program runs."""
    found, others = survey()
    return Plugins(items=[_plugin(one) for one in found], others=[_fault(fault) for fault in others])


def _plugin(one: Surveyed) -> PluginInfo:
    entry = one.entry
    return PluginInfo.view_of(
        entry,
        distribution=entry.distribution.name,
        version=entry.distribution.version,
        object=entry.value,
        works=one.works,
        faults=[_fault(fault) for fault in one.faults],
    )


def _fault(fault: PluginFault) -> PluginFaultInfo:
    return PluginFaultInfo.model_validate(fault, from_attributes=True)
