"""Asking whether a condition holds where its author's mistake must not end what asks."""

from __future__ import annotations

import logging

from skiros_py.interruptions import Interruption
from skiros_py.skills.conditions.condition import Condition
from skiros_py.skills.conditions.pattern import Binding
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.view import WorldView

_log = logging.getLogger(__name__)


def judge(condition: Condition, view: WorldView, binding: Binding | None = None) -> Verdict:
    """Tells whether a condition holds; one that breaks does not hold, negated or not, and the verdict says so.

    Args:
        condition: The condition.
        view: The world as believed, a snapshot, or an overlay.
        binding: Element ids by parameter key; None when the arguments are ids or classes already.
    """
    try:
        return condition.evaluate(view, binding)
    except (KeyboardInterrupt, Interruption):
        raise
    except BaseException as error:  # noqa: BLE001 - an author's code: whatever it raises, it said nothing about the world
        _log.error("condition %s broke", condition, exc_info=error)
        name = str(condition.bind(binding or {}))
        text = f"{name} broke: {type(error).__name__}: {error}"
        return Verdict(False, text)
