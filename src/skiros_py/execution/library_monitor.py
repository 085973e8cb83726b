"""What modules ask motion and perception adapters, as a stream for observers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from skiros_py.listeners import Listeners
from skiros_py.ports.adapters import Ports, require
from skiros_py.ports.pending import Pending

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class LibraryCall:
    """One request that a module made to an adapter.

    Attributes:
        request: The request (a ``MotionRequest``, a ``LookRequest``, …).
        answer: On its way, or there: what the port says of such a request.
    """

    request: Any
    answer: Pending[Any]


class LibraryMonitor:
    """Adapters whose requests are published in order; :class:`skiros_py.ports.adapters.Ports` for modules.

    What an adapter answers at once, such as kinematics, is not published.

    Args:
        ports: The adapters.
    """

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        self._listeners = Listeners[[LibraryCall]]("requests to adapters")
        self._observed: dict[int, _Observed] = {}

    def find(self, protocol: Callable[..., T], device: str | None = None) -> T | None:
        """Returns the adapter for a device, or for the cell; None where there is none."""
        adapter = self._ports.find(protocol, device)
        if adapter is None:
            return None
        return cast("T", self._observed.setdefault(id(adapter), _Observed(adapter, self._listeners.notify)))

    def port(self, protocol: Callable[..., T], device: str | None = None) -> T:
        """Returns the adapter for a device, or for the cell.

        Raises:
            DeviceError: There is none.
        """
        return require(self.find(protocol, device), protocol, device)

    def subscribe(self, listener: Callable[[LibraryCall], None]) -> Callable[[], None]:
        """Calls the listener in the control thread with each request; it must be quick.

        Returns:
            How to end that.
        """
        return self._listeners.add(listener)


class _Observed:
    """An adapter; each method that answers later is published."""

    def __init__(self, adapter: object, publish: Callable[[LibraryCall], None]) -> None:
        self._adapter = adapter
        self._publish = publish

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._adapter, name)
        if not callable(found):
            return found

        def method(*args: Any, **options: Any) -> Any:
            answer = found(*args, **options)
            if args and hasattr(answer, "latency"):
                self._publish(LibraryCall(args[0], answer))
            return answer

        self.__dict__[name] = method
        return method
