"""Devices commanded by several runs in one cycle: their contributions are merged by the kind's rule (`mixed`)."""

from __future__ import annotations

import logging
from typing import Any

from skiros_py.execution.module_faults import off_words
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.device import Contribution, DeviceSpec

_log = logging.getLogger(__name__)


class _Rule:
    """The mix rule of one device, as the watchdog sees it."""

    interruptible = True

    def __init__(self, spec: DeviceSpec[Any, Any], board: DeviceBoard) -> None:
        self.name = f"the mix rule of kind '{spec.kind}'"
        self.done = False
        self._kind = spec.kind
        self._board = board

    def fail(self, fault: BaseException) -> None:
        """Switches the rule off until the next reset."""
        self.done = True
        why = f"{self.name} was switched off in cycle {self._board.snapshot.cycle}: {off_words(fault)}"
        self._board.unmixed[self._kind] = why
        _log.error("%s", why)


class Mix:
    """Merges the commands for shared devices before they are sent.

    A rule that raises, gives no valid target (NaN, say) or holds the cycle too long is switched off: the devices of
    that kind that are shared brake, the runs that share them fail with their next command, and the cycle goes on.

    Args:
        board: The devices.
    """

    def __init__(self, board: DeviceBoard) -> None:
        self._board = board

    def merge(self) -> None:
        """Turns the contributions to each shared device into its target."""
        shared, self._board.shared = self._board.shared, {}
        for device, runs in shared.items():
            contributions = [contribution for _, contribution in runs.values()]
            if len(contributions) == 1:
                self._board.set_target(device, contributions[0].target)
            elif contributions:
                self._apply(self._board.devices[device], contributions)

    def _apply(self, spec: DeviceSpec[Any, Any], contributions: list[Contribution[Any]]) -> None:
        if spec.kind in self._board.unmixed:
            return
        rule = _Rule(spec, self._board)

        def mix() -> None:
            target = spec.mixed(contributions)
            spec.check(target)
            self._board.set_target(spec.id, target)

        try:
            self._board.guard.activity.run(rule, mix)
        except Exception as error:  # noqa: BLE001 - a plug-in's code: an error in it switches the rule off
            rule.fail(error)
