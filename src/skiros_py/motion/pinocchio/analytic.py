"""All joint angles for a pose in closed form, by ssik, for arms of six or seven revolute joints of the usual kinds."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any
from zipfile import BadZipFile

import numpy as np
from ssik._ssik_native import Solver  # its Python solver takes 30 times as long for chains that are not prebuilt

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import RevoluteChain
from skiros_py.ports.kinematics import InverseKinematics

_DERIVED = "ikgeo.general_6r"  # its coefficients take half a minute to derive
_WRAPPED, _NO_SEED = 1, np.zeros(0)
_SAME = 6
"""Decimals in which postures that are the same agree [rad]."""
_APART = (1.2, 0.6, 0.3)
"""Postures are chosen that differ by this in a joint, then by less, if there are not enough [rad]."""


@dataclass(frozen=True, slots=True)
class _Record:
    """What ssik's solver is made from: the kind of arm, and its numbers."""

    family: str
    schema: int
    arrays: Mapping[str, Any]


class AnalyticKinematics(InverseKinematics):
    """Knows all branches of an arm: an :class:`~skiros_py.ports.kinematics.InverseKinematics`.

    An arm of seven joints has a curve of solutions for a pose, the self-motion of its elbow; it is sampled. Moving each
    sample on along it, towards the reference, costs more than it saves: planners ask ``solve`` for what is nearest.

    Args:
        solver: ssik's solver for the arm.
        chain: The arm.
        numeric: Searches from seeds, and where there is no solution in closed form.
    """

    def __init__(self, solver: Solver, chain: RevoluteChain, numeric: InverseKinematics) -> None:
        self._solve_all: Callable[..., tuple[Array, Array, Array]] = solver.solve
        self._chain, self._numeric = chain, numeric

    def solve(
        self,
        target: Array,
        seed: Array,
        *,
        towards: Array | None = None,
        pulls: int = 1,
        strength: float = 0.2,
        iterations: int = 40,
    ) -> Array | None:
        """Searches from one seed, numerically: the next posture on a line is near."""
        return self._numeric.solve(target, seed, towards=towards, pulls=pulls, strength=strength, iterations=iterations)

    def all_branches(self, target: Array) -> Array:
        """Returns all solutions within the limits [rad], shape (solutions, joints)."""
        # limits, seed, metric, tolerance, greatest number, rescue near singularities, its iterations, windings
        return self._solve_all(target, _WRAPPED, False, _NO_SEED, "wrap_l2", False, 0.0, -1, True, 15, True)[0]

    def branches(
        self,
        target: Array,
        reference: Array,
        limits: tuple[Array, Array],
        rng: np.random.Generator,
        *,
        count: int = 6,
        restarts: int = 50,
    ) -> list[Array]:
        """Returns distinct solutions, the one nearest to a reference first: at most a number, spread over all."""
        postures = self.all_branches(target)
        if limits[0] is not self._chain.lower or limits[1] is not self._chain.upper:
            postures = postures[((postures >= limits[0]) & (postures <= limits[1])).all(axis=1)]
        if not len(postures):
            return self._numeric.branches(target, reference, limits, rng, count=count, restarts=restarts)
        _, first = np.unique(postures.round(_SAME), axis=0, return_index=True)
        postures = postures[np.sort(first)]  # where branches meet, the solver gives both
        steps = postures - reference
        postures = postures[np.einsum("ij,ij->i", steps, steps).argsort(kind="stable")]
        return list(postures if len(postures) <= count else postures[_spread(postures, count)])


def _spread(postures: Array, count: int) -> list[int]:
    """Returns which postures to take, the first ones first, but not all of one self-motion."""
    chosen: list[int] = []
    for apart in _APART:
        for number in range(len(postures)):
            if number in chosen:
                continue
            if not chosen or np.abs(postures[chosen] - postures[number]).max(axis=1).min() > apart:
                chosen.append(number)
            if len(chosen) == count:
                return sorted(chosen)
    return sorted(chosen)


def analytic_kinematics(
    chain: RevoluteChain | None, numeric: InverseKinematics, cache: Path | None = None
) -> AnalyticKinematics | None:
    """Returns the kinematics of an arm; None where ssik has no closed form for it.

    Args:
        chain: The arm; None for one that is no chain of revolute joints.
        numeric: Searches from seeds.
        cache: Folder for what is worked out about an arm, which takes seconds.
    """
    if chain is None:
        return None
    numbers = (chain.placements, chain.axes, chain.lower, chain.upper)
    key = hashlib.sha256(version("ssik").encode() + b"".join(np.ascontiguousarray(one).tobytes() for one in numbers))
    path = None if cache is None else cache / f"{key.hexdigest()[:32]}.npz"
    record = _read(path) if path is not None else None
    if record is None:
        record = _record(chain)
        if path is not None:
            _write(path, record)
    return AnalyticKinematics(Solver(record), chain, numeric) if record.family else None


def _record(chain: RevoluteChain) -> _Record:
    """Works out what the solver is made from; without a family where there is no solver."""
    from ssik import Manipulator  # with sympy, which takes seconds to import
    from ssik.cpp import SOLVER_DATA_SCHEMA, UnsupportedFamilyError, solver_data

    nothing = _Record("", SOLVER_DATA_SCHEMA, {})
    if len(chain.axes) not in (6, 7):
        return nothing
    arm = Manipulator.from_transforms(chain.placements, chain.axes, limits=np.column_stack([chain.lower, chain.upper]))
    if arm.solver_name == _DERIVED:
        return nothing
    try:
        data = solver_data(arm)
    except UnsupportedFamilyError:
        return nothing
    return _Record(data.family, data.schema, dict(data.arrays))


def _read(path: Path) -> _Record | None:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files if name not in ("family", "schema")}
            return _Record(str(file["family"]), int(file["schema"]), arrays)
    except (OSError, ValueError, KeyError, BadZipFile):
        return None


def _write(path: Path, record: _Record) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=path.parent, delete=False) as file:
            np.savez(file, **{"family": np.array(record.family), "schema": np.array(record.schema), **record.arrays})
        Path(file.name).replace(path)
    except OSError:
        return  # it is worked out again next time
