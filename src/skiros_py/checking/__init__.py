"""Checks plug-ins: applies the rules to everything in a distribution, and runs its skills on a fake robot."""

from skiros_py.checking.cases import Ground
from skiros_py.checking.contract import Contract, check_contract
from skiros_py.checking.plugin_check import PluginReport, as_installed, check_plugins, own_contracts

__all__ = ["Contract", "Ground", "PluginReport", "as_installed", "check_contract", "check_plugins", "own_contracts"]
