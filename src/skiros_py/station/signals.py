"""Use cases: reading and setting the signals of the cell."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.devices import CellSignal, SignalReading, SignalReadings
from skiros_py.execution.signals import SignalLost, Signals
from skiros_py.ports.signals import Value
from skiros_py.station.requests import Service, addressed
from skiros_py.station.session import Session


class SignalService(Service):
    """Describes, reads and sets signals."""

    def all(self) -> list[CellSignal]:
        """Describes all signals, those of the devices first."""
        signals = self._station.session.runtime.signals
        return [_described(signals, name) for name in signals.names]

    def read(self, names: Sequence[str]) -> SignalReadings:
        """Returns the values of signals in one control cycle.

        Args:
            names: Their names. A stateful signal is computed in every cycle after it is read for the first time.

        Raises:
            NotFound: There is no such signal.
        """

        def readings(session: Session) -> SignalReadings:
            snapshot = session.cycle.board.snapshot
            values = {name: _reading(session.runtime.signals, name) for name in names}
            return SignalReadings(time=snapshot.time, cycle=snapshot.cycle, signals=values)

        with addressed():
            return self._station.control.call(readings)

    def set(self, name: str, value: Value) -> None:
        """Sets an input; the value takes effect in the next cycle.

        Raises:
            NotFound: There is no such signal.
            UsageError: It is not an input, or the value does not have its shape.
        """
        with addressed():
            self._station.session.runtime.signals.set(name, value)


def _described(signals: Signals, name: str) -> CellSignal:
    one = signals.describe(name)
    return CellSignal(
        name=name,
        unit=one.unit,
        frame=one.frame,
        help=one.help,
        length=one.length,
        source=signals.source(name),
        input=signals.is_input(name),
    )


def _reading(signals: Signals, name: str) -> SignalReading:
    try:
        return SignalReading(value=signals.read(name).value, reason="")
    except SignalLost as error:
        return SignalReading(value=None, reason=error.reason)
