"""Plug-ins by entry points: the built-ins use the same door as anyone's.

They are found without importing any of them, and loaded when they are needed. One that fails to load is reported
with its name, version, origin and traceback, and does not affect the others.
"""

from skiros_py.plugins.installation import GROUPS, OWN_NAME, Installation, as_if_installed, installation, misfit
from skiros_py.plugins.loading import (
    LazyPlugins,
    attempt,
    examined,
    fault_of,
    files_of,
    find_plugin,
    folder_of,
    load,
    load_plugins,
    raised,
    unambiguous,
)
from skiros_py.plugins.plugin import Distribution, Entry, Plugin, PluginFault, locate, origin_of

__all__ = [
    "GROUPS",
    "OWN_NAME",
    "Distribution",
    "Entry",
    "Installation",
    "LazyPlugins",
    "Plugin",
    "PluginFault",
    "as_if_installed",
    "attempt",
    "examined",
    "fault_of",
    "files_of",
    "find_plugin",
    "folder_of",
    "installation",
    "load",
    "load_plugins",
    "locate",
    "misfit",
    "origin_of",
    "raised",
    "unambiguous",
]
