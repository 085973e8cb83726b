"""Scene files: a world is read from one and written to one."""

from skiros_py.world.scene.files import load_scene, save_scene, scene_goals

__all__ = ["load_scene", "save_scene", "scene_goals"]
