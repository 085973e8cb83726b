"""Robots: parts from a pallet into a kit for each of them; how exactly a camera is found on a hand.

    uv run --group test python benchmarks/robots.py --robot mobile_iiwa --robot ur10e_cell --picks 100

Each robot takes parts of at least five types from a pallet with clutter, and puts them into a kit; where these stand,
what the parts are, what they weigh and how slippery the fingers are is drawn from the seed of a scene, and judged by
the simulator's truth. ``--half`` is for one half of the ranges only; with ``--pictures`` there are pictures of each
miss. Without ``--robot``, cameras are calibrated: from pictures of a printed board.
"""

from __future__ import annotations

import math
import sys
import tempfile
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import count, islice
from pathlib import Path

import manipulation_scenes as scenes
import numpy as np
from manipulation_scenes import Chance, Scene
from manipulation_stage import Campaign, Stage, Trial, conditions, honest, share
from table import Figure, finish

from skiros_primitives.board_views import board_views
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose
from skiros_py.perception.calibration import SeenCorners, solve
from skiros_py.ports.calibration import CalibrationResult, MarkerBoard
from skiros_py.ports.simulation import Surface
from skiros_py.ports.values import CameraIntrinsics
from skiros_py.recording.pictures import contact_sheet
from skiros_py.system import default_simulation

_SEEDS = 20
_VIEWS = 15
_NOISE = 0.2  # of a corner, in each coordinate [px]
_MOST, _MOST_TURN = 0.0007, math.radians(0.1)  # [m, rad]
_BOARD = MarkerBoard(7, 5, 0.03, 0.0225)
_WRIST = CameraIntrinsics(320, 240, 225.7, 225.7, 159.5, 119.5, 0.05, 2.0)  # the camera of the mobile panda


def corners_of(board: MarkerBoard) -> Array:
    """Returns the inner corners of a board [m], shape (n, 3)."""
    places = [(x, y, 0.0) for y in range(1, board.rows) for x in range(1, board.columns)]
    return board.square * np.array(places)


def seen_from(views: list[Pose], camera: Pose, board: Pose, rng: np.random.Generator) -> list[SeenCorners]:
    """Returns what a camera sees of the board from given poses, with noise.

    Args:
        views: Poses of the camera.
        camera: The camera in the frame of what carries it.
        board: The board.
        rng: Source of the noise.
    """
    corners, k = corners_of(_BOARD), _WRIST
    seen: list[SeenCorners] = []
    for view in views:
        x, y, z = (view.inverse() @ board).apply(corners).T
        pixels = np.stack([k.fx * x / z + k.cx, k.fy * y / z + k.cy], axis=-1)
        inside = np.all((pixels >= 0.0) & (pixels <= (k.width - 1, k.height - 1)), axis=1)
        noisy = pixels + rng.normal(0.0, _NOISE, pixels.shape)
        seen.append(SeenCorners(corners[inside], noisy[inside], k, view @ camera.inverse()))
    return seen


def off(result: CalibrationResult, camera: Pose) -> tuple[float, float]:
    """Returns the errors of a calibration; infinite where there is none [m, rad]."""
    if result.pose is None:
        return math.inf, math.inf
    error = camera.inverse() @ result.pose
    return math.hypot(*error.position), 2.0 * math.acos(min(1.0, abs(error.orientation[3])))


def calibrated(seed: int, count: int = _VIEWS) -> tuple[tuple[float, float], tuple[float, float]]:
    """Returns the errors of a calibration, and those of what was believed before."""
    rng = np.random.default_rng([seed, 18])
    camera = Pose.of(0.05, -0.03, -0.06, roll=0.1, pitch=-0.05, yaw=1.5)
    board = Pose.of(0.5, 0.1, 0.3, roll=math.pi, yaw=0.4)

    def guess(pose: Pose) -> Pose:  # by hand
        x, y, z, roll, pitch, yaw = rng.uniform(-1.0, 1.0, 6).tolist()
        return pose @ Pose.of(0.02 * x, 0.02 * y, 0.02 * z, roll=0.1 * roll, pitch=0.1 * pitch, yaw=0.1 * yaw)

    believed, there = guess(camera), guess(board)
    hands = [view @ believed.inverse() for view in islice(board_views(_BOARD, there, _WRIST), count)]
    seen = seen_from([hand @ camera for hand in hands], camera, board, rng)
    result = solve(seen, believed, there)
    before = CalibrationResult(believed, there, 0, 0.0, 0.0, 0.0)
    return off(result, camera), off(before, camera)


def calibration() -> list[Figure]:
    """Calibrates a camera in a hand for each seed."""
    after, before = (np.array(errors) for errors in zip(*map(calibrated, range(_SEEDS)), strict=True))
    far, turned = after.max(axis=0)
    what = f"hand-eye from {_VIEWS} views, {_NOISE} px noise, worst of {_SEEDS} seeds"
    middle = np.median(after, axis=0)
    return [
        Figure(
            f"{what}: position",
            f"{1e3 * far:.3f} mm (median {1e3 * middle[0]:.3f})",
            f"<= {1e3 * _MOST:.1f} mm",
            bool(far <= _MOST),
            f"by hand {1e3 * before[:, 0].max():.1f} mm",
        ),
        Figure(
            f"{what}: angle",
            f"{math.degrees(turned):.3f} deg (median {math.degrees(middle[1]):.3f})",
            f"<= {math.degrees(_MOST_TURN):.1f} deg",
            bool(turned <= _MOST_TURN),
            f"by hand {math.degrees(before[:, 1].max()):.1f} deg",
        ),
    ]


ROBOTS = {"mobile_panda": False, "mobile_iiwa": False, "mobile_fanuc": False, "ur10e_cell": True}
"""Whether nothing moves a robot, by its name."""
_IN_A_KIT = 4
_FRICTION = 0.6, 1.0
"""Least and greatest friction of the pads of the fingers."""


class Pallet(Campaign):
    """Parts from a pallet into a kit.

    Args:
        robot: The robot that does it.
    """

    name = "pallet"

    def __init__(self, robot: str) -> None:
        self.robot = robot

    def scene(self, seed: int) -> Scene:
        """Generates a scene."""
        return scenes.pallet(seed, self.robot, stands=ROBOTS[self.robot])

    def run(self, stage: Stage) -> dict[str, float]:
        """Makes the fingers more slippery, and fills the kit."""
        friction = Chance(stage.scene.seed).within(*_FRICTION)
        (body,) = stage.session.simulation.scene.robots
        for gripper in stage.session.spec.robots[0].of(GripperSpec):
            body.model.joints(gripper.joints).set_surface(Surface(lateral=friction, anchored=True))
        report = stage.pursue(stage.scene.goals)
        return {"friction": friction, "time": report.simulated}

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the share of parts that are in the kit, at the first try and after all."""
        first = [right for trial in trials for right in trial.first]
        shown = f"{sum(first)} of {len(first)} without a failed step, {100.0 * sum(first) / max(1, len(first)):.1f} %"
        times = [trial.facts["time"] / len(trial.scene.goals) for trial in trials]
        figures = [replace(conditions(trials, 99.0), compared=shown), honest(trials)]
        figures.append(share("scenes without a hit", [not trial.hits for trial in trials], 100.0))
        figures.append(Figure("simulated time for a part", f"median {np.median(times or math.nan):.1f} s"))
        return [replace(figure, what=f"{self.robot}: {figure.what}") for figure in figures]


def trials_of(
    campaign: Pallet, picks: int, seeds: Iterator[int], engine: str, pictures: Path | None
) -> Iterator[Trial]:
    """Runs scenes until a robot was to pick and place so many parts; says how each went, with pictures of misses."""
    while picks > 0:
        scene = campaign.scene(next(seeds))
        scene = replace(scene, goals=scene.goals[: min(picks, _IN_A_KIT)])
        picks -= len(scene.goals)
        with tempfile.TemporaryDirectory(prefix="skiros-campaign-") as folder:
            trial = campaign.trial(scene, Path(folder), pictures=pictures is not None, simulation=engine)
        print(f"{scene.name} ({scene.kind}, {engine}): {'MISS' if trial.misses else 'as wanted'}", file=sys.stderr)
        for miss in trial.misses:
            print(f"  {miss}", flush=True)
        if pictures is not None and trial.misses:
            pictures.mkdir(parents=True, exist_ok=True)
            contact_sheet(trial.pictures).save(pictures / f"{scene.name}_{engine}.png")
        yield trial


def main() -> int:
    """Runs the campaign of each robot, or calibrates; prints the table."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--robot", action="append", choices=sorted(ROBOTS), help="a robot; several times for several")
    parser.add_argument("--picks", type=int, default=100, help="parts that each robot is to pick and place")
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--half", choices=("odd", "even", "both"), default="both", help="seeds that are taken")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of the misses")
    parser.add_argument("--simulation", default=default_simulation(), help="engine that simulates")
    arguments = parser.parse_args()
    if not arguments.robot:
        return finish("robots", calibration())
    figures: list[Figure] = []
    parities = {"odd": (1,), "even": (0,), "both": (0, 1)}[arguments.half]
    for robot in arguments.robot:
        campaign, trials = Pallet(robot), list[Trial]()
        seeds = (seed for seed in count(arguments.first) if seed % 2 in parities)
        with suppress(KeyboardInterrupt):
            trials.extend(trials_of(campaign, arguments.picks, seeds, arguments.simulation, arguments.pictures))
        tried = sum(len(trial.scene.goals) for trial in trials)
        figures += campaign.figures(trials)
        wanted = f"{arguments.picks}"
        figures.append(Figure(f"{robot}: parts that were wanted", f"{tried}", wanted, tried == arguments.picks))
    return finish(f"robots, {arguments.simulation}", figures)


if __name__ == "__main__":
    sys.exit(main())
