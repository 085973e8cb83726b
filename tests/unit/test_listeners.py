"""Listeners: each is called, in order, whatever the others do."""

from __future__ import annotations

import logging

import pytest

from skiros_py.interruptions import Interruption, UserStop
from skiros_py.listeners import Listeners


def test_listeners_are_called_in_order_until_they_leave() -> None:
    listeners, heard = Listeners[[str]]("words"), list[str]()
    leave = listeners.add(lambda word: heard.append(f"first {word}"))
    listeners.add(lambda word: heard.append(f"second {word}"))

    listeners.notify("a")
    leave()
    listeners.notify("b")

    assert heard == ["first a", "second a", "second b"]
    assert listeners


def test_a_listener_that_leaves_meanwhile_does_not_keep_others_from_hearing() -> None:
    listeners, heard = Listeners[[]]("events"), list[str]()
    leave = listeners.add(lambda: leave())
    listeners.add(lambda: heard.append("called"))

    listeners.notify()

    assert heard == ["called"]


@pytest.mark.parametrize("fault", [ValueError("nonsense"), SystemExit(3)])
def test_a_listener_that_raises_is_logged_and_the_others_are_called(
    fault: BaseException, caplog: pytest.LogCaptureFixture
) -> None:
    listeners, heard = Listeners[[]]("events"), list[str]()

    def breaks() -> None:
        raise fault

    listeners.add(breaks)
    listeners.add(lambda: heard.append("called"))
    with caplog.at_level(logging.ERROR):
        listeners.notify()

    assert heard == ["called"]
    assert "a listener of events broke" in caplog.text


@pytest.mark.parametrize("stop", [UserStop, Interruption])
def test_what_ends_code_from_outside_passes(stop: type[BaseException]) -> None:
    listeners = Listeners[[]]("events")

    def stopped() -> None:
        raise stop

    listeners.add(stopped)
    with pytest.raises(stop):
        listeners.notify()
