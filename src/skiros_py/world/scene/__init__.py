"""Scene files: reading, writing, comparing and replacing a world's scene; learned data has a similar file."""

from skiros_py.world.scene.files import describe, diff, load_scene, save_scene, scene_source
from skiros_py.world.scene.learned import learned_turtle, read_learned

__all__ = [
    "describe",
    "diff",
    "learned_turtle",
    "load_scene",
    "read_learned",
    "save_scene",
    "scene_source",
]
