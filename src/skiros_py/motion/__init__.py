"""Adapters of the motion ports: arm motions with Pinocchio and Coal, base paths with Shapely."""
