"""Rehearsals: plans carried out in a second physics world, made from beliefs, in a process of its own."""
