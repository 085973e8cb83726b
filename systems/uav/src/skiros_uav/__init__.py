"""Robots that fly: device kinds, a hexacopter, conditions, primitives and skills. Found through entry points."""
