"""One run of a document: a behaviour without a skill around it."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.behaviours.children import run_until
from skiros_py.errors import UsageError
from skiros_py.execution.contained import contained
from skiros_py.execution.monitor import Status
from skiros_py.execution.scope import Scope, teller, to_its_end
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.execution import Execution, tick
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Param, missing, read_arguments


@dataclass(frozen=True, slots=True)
class RunnableDocument:
    """A document that can be run as a module.

    Attributes:
        behaviour: What it does.
        revision: Its revision: kept in the events of each run.
        help: One sentence for people.
        params: The parameters that it declares.
        outputs: Names of the values that its outcome has.
    """

    behaviour: Behaviour
    revision: int
    help: str = ""
    params: tuple[Param, ...] = ()
    outputs: tuple[str, ...] = ()


class BehaviourRun:
    """Runs a document once, as it was when the run began.

    Its devices are taken by the modules that it calls; what is cancelled with it recovers as in any composition.

    Args:
        name: The module ("tree:tidy_up").
        document: What is run.
        arguments: Its parameters, and further values that its nodes read.
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
        self._arguments = dict(arguments)
        values: dict[str, Any] = {}
        run = run or scope.monitor.new_id()
        self._tell = teller("document", name, scope, run, implementation=lambda: f"revision {document.revision}")
        self._scope = replace(
            scope,
            arguments=ChainMap(self._arguments, values),
            values=values,
            unfinished=[],
            callers=(*scope.callers, name),
            id=run,
            parent=scope.id,
        )

    def execute(self) -> Execution[Outcome]:
        """Runs it; also reports to the monitor."""
        return to_its_end(self, self._outer, self._tell)

    def run(self) -> Execution[Outcome]:
        """Runs its behaviour."""
        self.started = True
        self._tell(Status.STARTED, 0, f"revision {self._document.revision}")
        self._outer.check_depth(self._name)
        specified = contained(self._name, self._specify)
        if isinstance(specified, Failure):
            return specified

        def end(run: Execution[Outcome]) -> Outcome | None:
            return contained(self._name, lambda: tick(run))

        outcome = yield from run_until(self._document.behaviour, "body", self._scope, end)
        if isinstance(outcome, Failure) or not self._document.outputs:
            return outcome
        written = self._scope.values
        return Success(outcome.message, {key: written[key] for key in self._document.outputs if key in written})

    def _specify(self) -> None:
        """Reads the arguments of declared parameters.

        Raises:
            SkirosError: A value is missing or wrong.
        """
        params = self._document.params
        if not params:
            return
        values = read_arguments(params, self._arguments, self._scope.context.world)
        if open_ := missing(params, values):
            raise UsageError(f"{', '.join(open_)}: not specified")
        self._arguments.update(values)

    def leave(self) -> bool:
        """Ends it at once: its modules keep their own devices to recover."""
        self._outer.unfinished.extend(self._scope.unfinished)
        return False

    def release(self) -> None:
        """It has no devices of its own."""
