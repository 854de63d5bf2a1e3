"""Reduced-order models of legged locomotion: planar bodies on springy legs."""

__version__ = "0.1.0"
