"""Afterimage: a ray tracer for animations that reuses the previous frame's samples, exactly."""

from ._afterimage import Cancelled, Error, Frame, Material, Mesh, Render, Scene, __version__, load, render

__all__ = ["Cancelled", "Error", "Frame", "Material", "Mesh", "Render", "Scene", "__version__", "load", "render"]
