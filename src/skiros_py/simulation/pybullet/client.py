"""One PyBullet client, with its id filled in and its errors translated."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any, cast

from skiros_py.errors import DeviceError, UsageError


class Client:
    """The functions and constants of the pybullet module, for one physics client.

    Functions get the client's id; what pybullet raises leaves here as DeviceError.

    Args:
        gui: Open a window.

    Raises:
        UsageError: A window is wanted where there is no display.
        DeviceError: PyBullet cannot be started as it is needed here.
    """

    def __init__(self, *, gui: bool = False) -> None:
        if gui:
            _require_display()
        self._library = _library()
        if not self._library.isNumpyEnabled():
            raise DeviceError("this build of pybullet lacks numpy support, without which images take seconds")
        mode = self._library.GUI if gui else self._library.DIRECT
        self._id: int = self._library.connect(mode)
        if self._id < 0:
            raise DeviceError("PyBullet did not start a physics server")
        if gui:
            self._library.configureDebugVisualizer(self._library.COV_ENABLE_GUI, 0, physicsClientId=self._id)

    def look_at(self, target: tuple[float, float, float], distance: float) -> None:
        """Turns the window's view to a point of the map, from a distance above [m]; nothing without a window."""
        self._library.resetDebugVisualizerCamera(distance, -35.0, -60.0, target, physicsClientId=self._id)

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._library, name)
        if callable(value):
            value = _translated(functools.partial(value, physicsClientId=self._id), name, self._library.error)
        setattr(self, name, value)  # the next access does not come here
        return value

    def close(self) -> None:
        """Ends the client; may be called twice."""
        if self._id >= 0:
            self._library.disconnect(self._id)
            self._id = -1


def _translated(function: Callable[..., Any], name: str, fault: type[Exception]) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except fault as error:
            raise DeviceError(f"PyBullet, {name}: {error}") from error

    return call


def _require_display() -> None:
    # PyBullet ends the whole process when it cannot open its window, so this must be known before.
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise UsageError(
            "there is no display to open the simulation's window on (DISPLAY is not set); "
            "run without the window and look at recorded pictures instead"
        )


@functools.cache
def _library() -> ModuleType:
    with _quiet_stderr():
        import pybullet  # heavy, and only who simulates needs it

        return cast(ModuleType, pybullet)


@contextlib.contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Keeps the build date, which the library prints when it is loaded, off the user's screen."""
    sys.stderr.flush()
    saved = os.dup(2)
    try:
        with open(os.devnull, "wb") as sink:  # noqa: PTH123 - a device, not a path of ours
            os.dup2(sink.fileno(), 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
