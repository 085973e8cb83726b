"""Plug-ins: what is installed, and what is wrong with it."""

from __future__ import annotations

from skiros_py.api.plugins import PluginFaultInfo, Plugins
from skiros_py.client.call import Call


def list_plugins() -> Call[Plugins]:
    """Lists every entry point that is installed where the server runs."""
    return Call("GET", "/plugins", Plugins)


def list_plugin_faults() -> Call[list[PluginFaultInfo]]:
    """Lists what does not load or fit into the present scene."""
    return Call("GET", "/plugins/faults", list[PluginFaultInfo])
