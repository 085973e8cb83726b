"""Ports: what a robot is to the rest of the platform. Protocols and frozen values, no library."""
