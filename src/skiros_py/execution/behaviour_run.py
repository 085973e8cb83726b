"""One run of a document: a behaviour without a skill around it."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.behaviours.children import run_until
from skiros_py.execution.contained import contained
from skiros_py.execution.monitor import Status
from skiros_py.execution.scope import Scope, teller, to_its_end
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.execution import Execution, tick
from skiros_py.skills.outcome import Outcome


@dataclass(frozen=True, slots=True)
class RunnableDocument:
    """A document that can be run as a module.

    Attributes:
        behaviour: What it does.
        revision: Its revision: kept in the events of each run.
        help: One sentence for people.
    """

    behaviour: Behaviour
    revision: int
    help: str = ""


class BehaviourRun:
    """Runs a document once, as it was when the run began.

    Its devices are taken by the modules that it calls; what is cancelled with it recovers as in any composition.

    Args:
        name: The module ("tree:tidy_up").
        document: What is run.
        arguments: Values that its nodes read.
        scope: What it runs in.
        run: Id of this run; a new one where left out.
    """

    def __init__(
        self,
        name: str,
        document: RunnableDocument,
        arguments: Mapping[str, Any],
        scope: Scope,
        run: str = "",
    ) -> None:
        self.started = False
        self._name = name
        self._document = document
        self._outer = scope
        values: dict[str, Any] = {}
        run = run or scope.monitor.new_id()
        self._tell = teller("document", name, scope, run, implementation=lambda: f"revision {document.revision}")
        self._scope = replace(
            scope,
            arguments=ChainMap(dict(arguments), values),
            values=values,
            unfinished=[],
            callers=(*scope.callers, name),
            id=run,
        )

    def execute(self) -> Execution[Outcome]:
        """Runs it; also reports to the monitor."""
        return to_its_end(self, self._outer, self._tell)

    def run(self) -> Execution[Outcome]:
        """Runs its behaviour."""
        self.started = True
        self._tell(Status.STARTED, 0, f"revision {self._document.revision}")
        self._outer.check_depth(self._name)

        def end(run: Execution[Outcome]) -> Outcome | None:
            return contained(self._name, lambda: tick(run))

        return (yield from run_until(self._document.behaviour, "body", self._scope, end))

    def leave(self) -> bool:
        """Ends it at once: its modules keep their own devices to recover."""
        self._outer.unfinished.extend(self._scope.unfinished)
        return False

    def release(self) -> None:
        """It has no devices of its own."""
