"""Parameters that were left out, found in the world: what fits the conditions under which a skill can start."""

from skiros_py.skills.inference.inferring import Inferred, Missing, applying, infer

__all__ = ["Inferred", "Missing", "applying", "infer"]
