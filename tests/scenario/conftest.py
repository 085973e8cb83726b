"""Scenarios: a goal goes in, the simulator's truth is judged. Disturbances come at a moment, told to nobody."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from skiros_py.station.session import Options, Session


@pytest.fixture
def open_session() -> Iterator[Callable[..., Session]]:
    with ExitStack() as stack:

        def open_(scene: str = "kitting", **options: Any) -> Session:
            return stack.enter_context(Session(scene, Options(**options)))

        yield open_


@pytest.fixture
def when() -> Callable[[Session, Callable[[], bool], Callable[[], None]], None]:
    """Does something once, at the end of the first cycle in which a predicate holds."""

    def arrange(session: Session, predicate: Callable[[], bool], action: Callable[[], None]) -> None:
        done: list[bool] = []

        def look() -> None:
            if not done and predicate():
                done.append(True)
                action()

        session.cycle.observe(look)

    return arrange
