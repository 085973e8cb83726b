"""A photo studio: depth images of solids rendered by ray casting, with the noise of a real camera."""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # as in the worker process; Open3D reads it when imported

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.open3d import pybind as o3d
from skiros_py.ports.perception import DetectionRequest, PartModel, Region
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Snapshot

Placed = tuple[Solid, Pose]

WIDTH, HEIGHT = 320, 240
FOCAL = HEIGHT / 2.0 / math.tan(math.radians(56.0) / 2.0)
INTRINSICS = CameraIntrinsics(WIDTH, HEIGHT, FOCAL, FOCAL, (WIDTH - 1) / 2.0, (HEIGHT - 1) / 2.0, 0.05, 2.0)

STARTER = Solid(
    (
        Primitive("box", (0.118, 0.030, 0.020), Pose.of(0.0, 0.0, 0.010)),
        Primitive("cylinder", (0.0245, 0.118), Pose.of(0.0, 0.0, 0.030, pitch=math.pi / 2)),
        Primitive("cylinder", (0.013, 0.022), Pose.of(0.046, 0.0, 0.056, pitch=math.pi / 2)),
    )
)
ALTERNATOR = Solid(
    (
        Primitive("cylinder", (0.030, 0.060), Pose.of(0.0, 0.0, 0.030)),
        Primitive("cylinder", (0.014, 0.012), Pose.of(0.0, 0.0, 0.066)),
    )
)
COMPRESSOR = Solid(
    (
        Primitive("box", (0.098, 0.049, 0.052), Pose.of(0.0, 0.0, 0.026)),
        Primitive("box", (0.042, 0.049, 0.022), Pose.of(0.028, 0.0, 0.063)),
    )
)
RELAY_BOX = Solid.box(0.059, 0.040, 0.054)
PARTS = {"Starter": STARTER, "Alternator": ALTERNATOR, "Compressor": COMPRESSOR, "RelayBox": RELAY_BOX}
MODELS = tuple(PartModel(name, solid) for name, solid in PARTS.items())
SYMMETRY = {"Starter": 1, "Alternator": 0, "Compressor": 1, "RelayBox": 2}

INNER, WALL, RIM, FLOOR = 0.140, 0.006, 0.033, 0.006


def tray() -> Solid:
    """A kit of 2x2 compartments."""
    outer = 2.0 * INNER + 3.0 * WALL
    blocks = [Primitive("box", (outer, outer, FLOOR), Pose.of(0.0, 0.0, FLOOR / 2.0))]
    for at in (-(INNER + WALL), 0.0, INNER + WALL):
        z = FLOOR + RIM / 2.0
        blocks.append(Primitive("box", (WALL, outer, RIM), Pose.of(at, 0.0, z)))
        blocks.append(Primitive("box", (outer, WALL, RIM), Pose.of(0.0, at, z)))
    return Solid(tuple(blocks))


TRAY = tray()
COMPARTMENTS = tuple((sx * (INNER + WALL) / 2.0, sy * (INNER + WALL) / 2.0) for sx in (-1, 1) for sy in (-1, 1))


@dataclass(frozen=True)
class Studio:
    """Renders scenes; tests get at everything here through it, since test files cannot import each other."""

    noise: float = 0.0015
    parts: Mapping[str, Solid] = field(default_factory=lambda: PARTS)
    symmetry: Mapping[str, int] = field(default_factory=lambda: SYMMETRY)
    kit: Solid = TRAY
    compartments: tuple[tuple[float, float], ...] = COMPARTMENTS
    kit_floor: float = FLOOR

    def look(
        self, bodies: Sequence[Placed], camera: Pose, region: Region, rng: np.random.Generator, *, seed: int = 0
    ) -> DetectionRequest:
        """Takes a picture and asks for the parts in it."""
        return DetectionRequest(self.shoot(bodies, camera, rng), camera, region, MODELS, seed)

    def part(self, name: str, x: float, y: float, z: float, yaw: float) -> Placed:
        """A part that stands in the map."""
        return self.parts[name], Pose.of(x, y, z, yaw=yaw)

    def toppled(self, name: str, rng: np.random.Generator) -> Solid:
        """A part turned onto another of its sides."""
        turns = [(r, p) for r in (0.0, 0.5, 1.0, 1.5) for p in (0.0, 0.5, 1.5) if (r, p) != (0.0, 0.0)]
        roll, pitch = turns[int(rng.integers(len(turns)))]
        turn = Pose.of(0.0, 0.0, 0.0, roll=roll * math.pi, pitch=pitch * math.pi)
        turned = Solid(tuple(Primitive(b.kind, b.size, turn @ b.pose) for b in self.parts[name].primitives))
        low, high = turned.bounds()
        lift = Pose.of(-(low[0] + high[0]) / 2.0, -(low[1] + high[1]) / 2.0, -low[2])
        return Solid(tuple(Primitive(b.kind, b.size, lift @ b.pose) for b in turned.primitives))

    def over(self, x: float, y: float, z: float, yaw: float = 0.0) -> Pose:
        """A camera at a point of the map whose optical axis points straight down."""
        return Pose.of(x, y, z, roll=math.pi, yaw=yaw)

    def table(self, height: float, x: float = 0.0, y: float = 0.0) -> Placed:
        """A table that continues beyond every region looked at."""
        return Solid.box(0.60, 0.80, 0.40), Pose.of(x, y, height - 0.40)

    def scatter(self, rng: np.random.Generator, count: int) -> list[tuple[str, float, float, float]]:
        """Draws parts (name, x, y, yaw) whose centres keep a least distance, within the usual region."""
        return scatter(rng, count, (0.10, 0.17), 0.13)

    def shoot(self, bodies: Sequence[Placed], camera: Pose, rng: np.random.Generator) -> DepthImage:
        """Takes a picture of bodies in the map."""
        scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        for solid, pose in bodies:
            for block in solid.primitives:
                scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(_mesh(block, pose)))
        v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
        rays = np.stack([(u - INTRINSICS.cx) / FOCAL, (v - INTRINSICS.cy) / FOCAL, np.ones_like(u)], axis=-1)
        matrix = camera.matrix()
        directions = rays @ matrix[:3, :3].T
        origins = np.broadcast_to(matrix[:3, 3], directions.shape)
        both = np.concatenate([origins, directions], axis=-1).astype(np.float32)
        depth = scene.cast_rays(o3d.core.Tensor(both), nthreads=1)["t_hit"].numpy()
        hit = np.isfinite(depth) & (depth < INTRINSICS.far)
        noisy = np.where(hit, depth + rng.normal(0.0, self.noise, depth.shape), 0.0).astype(np.float32)
        return DepthImage(Snapshot(0, 0.0), noisy, np.zeros((HEIGHT, WIDTH, 3), np.uint8), INTRINSICS)


def _mesh(block: Primitive, pose: Pose) -> o3d.geometry.TriangleMesh:
    if block.kind == "box":
        mesh = o3d.geometry.TriangleMesh.create_box(*block.size).translate(-np.asarray(block.size) / 2.0)
    else:
        mesh = o3d.geometry.TriangleMesh.create_cylinder(block.size[0], block.size[1], resolution=48)
    return mesh.transform((pose @ block.pose).matrix())


def scatter(
    rng: np.random.Generator, count: int, half: tuple[float, float], spacing: float, names: Sequence[str] = tuple(PARTS)
) -> list[tuple[str, float, float, float]]:
    """Draws parts (name, x, y, yaw) inside a rectangle with a least distance between centres."""
    placed: list[tuple[str, float, float, float]] = []
    while len(placed) < count:
        x, y = (float(rng.uniform(-h, h)) for h in half)
        if all(math.hypot(x - other[1], y - other[2]) >= spacing for other in placed):
            placed.append((str(rng.choice(names)), x, y, float(rng.uniform(-math.pi, math.pi))))
        elif rng.random() < 0.02:
            placed.clear()
    return placed


@pytest.fixture(scope="session")
def studio() -> Studio:
    """A studio with the usual noise."""
    return Studio()
