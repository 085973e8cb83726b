"""Contract tests of skills, for an author's own tests: the declared effects must occur, and no others.

::

    @pytest.mark.parametrize("case", contract_cases("my-package"), ids=str)
    def test_contract(case):
        case.check()
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.checking.cases import Ground
from skiros_py.checking.contract import Contract
from skiros_py.checking.contract import check_contract as run_contract
from skiros_py.checking.plugin_check import own_contracts
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.world import World


@dataclass(frozen=True, slots=True)
class ContractCase:
    """The contract test of one implementation of a skill.

    Attributes:
        name: The entry point that names the skill.
        run: Runs the test.
    """

    name: str
    run: Callable[[], Contract]

    def check(self) -> None:
        """Runs the skill where its preconditions hold, and compares the world before and after.

        Raises:
            AssertionError: An effect did not occur, an undeclared change occurred, or no world was found in which the
                skill can start, so that nothing was tested.
        """
        _raise_for(self.run())

    def __str__(self) -> str:
        return self.name


def contract_cases(distribution: str) -> list[ContractCase]:
    """Returns a case for each skill of an installed distribution that runs on a fake robot, by entry point.

    Raises:
        UnknownName: There is no such distribution with plug-ins.
    """
    return [ContractCase(name, run) for name, run in own_contracts(distribution).items()]


def check_contract(
    skill: Skill,
    world: Callable[[], World],
    *,
    skills: Sequence[Skill] = (),
    primitives: Iterable[type[Primitive[Any]]] = (),
) -> None:
    """Runs a skill in a world where its preconditions hold, or can be achieved, and compares before and after.

    Args:
        skill: An implementation for the fake driver.
        world: Creates the world: ``lambda: world_of("…")``, or :func:`~skiros_py.testing.tiny_world`.
        skills: Other skills that it calls, or that may prepare its start.
        primitives: Primitives that any of them calls.

    Raises:
        AssertionError: As of :meth:`ContractCase.check`.
    """
    named = {primitive.name: primitive for primitive in primitives}
    _raise_for(run_contract(skill, [Ground("the world given", world)], skills, named))


def _raise_for(contract: Contract) -> None:
    if contract.findings:
        raise AssertionError("\n".join(map(str, contract.findings)))
