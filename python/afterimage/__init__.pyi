"""Afterimage: a ray tracer for animations that reuses the previous frame's samples, exactly."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

__version__: str

Frames = Union[str, int, range, Iterable[int]]
Matrix = npt.ArrayLike
"""(4, 4) numbers for column vectors: the last column is the translation, the last row 0 0 0 1."""
Color = Sequence[float]
"""Linear RGB."""

class Error(Exception):
    """An input that makes no sense, or work that could not be done. The text says what to do."""

class Cancelled(Error):
    """The render was cancelled."""

class Mesh:
    """A mesh of a scene, for copies of it."""

    @property
    def name(self) -> str: ...

class Material:
    """A material of a scene."""

    @property
    def name(self) -> str: ...

class Scene:
    """A shot: models, lights, camera, and how they are rendered.

    Units are those of the models. Right-handed, Y up. A scene that was loaded from a file cannot be changed.
    """

    def __init__(
        self,
        frames: Optional[Frames] = None,
        fps: Union[float, str, None] = None,
        *,
        strict: bool = False,
        **settings: Any,
    ) -> None:
        """Creates a scene without anything in it.

        frames: those that it has, as in `render` (frame 1). fps: frames in a second (24). strict: what a stand-in would replace is an
        error. settings: as in `render`.
        """
    @property
    def frames(self) -> list[int]:
        """Numbers of the frames, in rising order."""
    @property
    def warnings(self) -> list[str]:
        """Stand-ins that the picture shows, and other oddities, in whole sentences."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures, pixels."""
    def add_mesh(
        self,
        name: str,
        vertices: npt.ArrayLike,
        faces: Union[npt.ArrayLike, tuple[npt.ArrayLike, npt.ArrayLike]],
        normals: Optional[npt.ArrayLike] = None,
        uv: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        material: Union[Material, str, None] = None,
        face_materials: Optional[npt.ArrayLike] = None,
        materials: Optional[Sequence[Union[Material, str, None]]] = None,
        transform: Union[Matrix, Mapping[float, Matrix], None] = None,
        vertices_by_frame: Optional[Mapping[float, npt.ArrayLike]] = None,
        visible: Union[bool, Mapping[float, bool], None] = None,
    ) -> Mesh:
        """Adds a mesh, and shows it at `transform`.

        vertices: (n, 3), object space. faces: (m, 3) vertices of triangles, counter-clockwise seen from outside; or a tuple of the
        vertices of all corners (c,) and the number of corners of each face (m,). normals: (n, 3) or (c, 3), of any length; without
        them faces are flat. uv: (n, 2) or (c, 2), v = 0 at the bottom of the picture. colors: (n, 3) or (c, 3), linear RGB from 0 to
        1, a factor of the reflectance. material: that of all faces; or materials, and face_materials: (m,) indices into them.
        transform: from the mesh to the world, or by frame; between frames each number is interpolated. vertices_by_frame: all vertices
        at these frames. visible: or by frame, from that frame on.

        Raises Error for shapes, types and indices that do not fit, and for numbers that are not finite.
        """
    def add_curves(
        self,
        name: str,
        points: npt.ArrayLike,
        counts: Union[int, npt.ArrayLike],
        radius: Union[float, npt.ArrayLike],
        basis: str = "linear",
        uv: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        normals: Optional[npt.ArrayLike] = None,
        material: Union[Material, str, None] = None,
        transform: Union[Matrix, Mapping[float, Matrix], None] = None,
        points_by_frame: Optional[Mapping[float, npt.ArrayLike]] = None,
        visible: Union[bool, Mapping[float, bool], None] = None,
    ) -> Mesh:
        """Adds curves with a thickness, hair say, and shows them at `transform`.

        points: (n, 3), object space, curve after curve. counts: how many points each curve has, (m,), or one number for all. radius: of each
        point (n,), or one number for all. basis: "linear", "bezier", "bspline" or "catmull-rom". uv: (m, 2), texture coordinates of each
        curve; without them u goes along it. colors: (n, 3), linear RGB, a factor of the reflectance. normals: (n, 3), which makes the curves
        flat, across them. points_by_frame: all points at these frames. material, transform, visible: as in add_mesh().

        Raises Error for shapes, types and counts that do not fit, and for numbers that are not finite. Curves without a length or a thickness are
        left out.
        """
    def add_instance(
        self,
        mesh: Mesh,
        transform: Union[Matrix, Mapping[float, Matrix], None] = None,
        *,
        name: Optional[str] = None,
        visible: Union[bool, Mapping[float, bool], None] = None,
    ) -> Mesh:
        """Shows a mesh at one more place. Copies share its memory."""
    def add_material(
        self,
        name: str,
        *,
        base_color: Color = ...,
        metallic: float = ...,
        roughness: float = ...,
        ior: float = ...,
        transmission: float = ...,
        emission: Color = ...,
        emission_strength: float = ...,
        alpha: float = ...,
        base_color_map: Union[str, PathLike[str]] = ...,
        alpha_map: Union[str, PathLike[str]] = ...,
        metallic_map: Union[str, PathLike[str]] = ...,
        roughness_map: Union[str, PathLike[str]] = ...,
        emission_map: Union[str, PathLike[str]] = ...,
        normal_map: Union[str, PathLike[str]] = ...,
        bump_map: Union[str, PathLike[str]] = ...,
        **keys: Any,
    ) -> Material:
        """Adds a material. keys: those of [[material]] in shot files. Pictures multiply the numbers beside them."""
    def add_light(
        self,
        kind: Literal["point", "sun", "directional", "spot", "rectangle", "disk", "sphere"],
        *,
        transform: Union[Matrix, Mapping[float, Matrix], None] = None,
        keys: Optional[Mapping[float, Mapping[str, Any]]] = None,
        **values: Any,
    ) -> None:
        """Adds a light. values: the keys of [[light]] in shot files, as position, direction, target, color, power, radius.

        transform: of a light that is at the origin and shines along -Z with Y up, or by frame. keys: position, direction, target, up,
        color and power by frame.
        """
    def set_camera(
        self,
        *,
        transform: Union[Matrix, Mapping[float, Matrix], None] = None,
        keys: Optional[Mapping[float, Mapping[str, Any]]] = None,
        **values: Any,
    ) -> None:
        """Sets the camera. values: the keys of [camera] and [[camera.key]] in shot files, as eye, target, fov, projection.

        transform: of a camera that looks along -Z with Y up, or by frame. keys: such values by frame.
        """
    def set_sky(self, **values: Any) -> None:
        """Sets a clear sky with its sun. values: elevation, azimuth, turbidity, ground; and those of [environment]."""
    def set_environment(self, **values: Any) -> None:
        """Sets light from all around. values: those of [environment] in shot files: map, rotation, power, visible, samples."""
    def set_background(self, **values: Any) -> None:
        """Sets what rays see that hit nothing. values: color; or zenith, horizon, ground."""
    def set(self, table: str, **values: Any) -> None:
        """Sets keys of another table of a shot file: floor, ambient, stereo, shutter, render, indirect, occlusion, output."""

class Frame:
    """A finished frame."""

    @property
    def number(self) -> int:
        """Number of the frame."""
    @property
    def layers(self) -> dict[str, npt.NDArray[Any]]:
        """Arrays (height, width, channels) by the name of the layer, the top row first.

        "RGBA" is the picture, others are those of docs/layers.md: "Z", "N", "denoised". They are float32; "object" and "material" are
        uint32. Those of a right eye end in ".right".
        """
    @property
    def stats(self) -> dict[str, Any]:
        """Statistics, as the program's --stats says them of a frame: samples, rays, seconds. Those of a right eye: "right"."""
    @property
    def seconds(self) -> float:
        """Seconds that the frame took."""

class Render:
    """Frames, one after the other, each rendered when it is asked for."""

    def __iter__(self) -> Render: ...
    def __next__(self) -> Frame: ...
    def cancel(self) -> None:
        """Cancels the render, from any thread. Whoever waits for a frame gets Cancelled within a second."""

def load(path: Union[str, PathLike[str]], *, strict: bool = False) -> Scene:
    """Loads a shot file (.toml), or a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz).

    strict: missing textures and materials are errors. Raises Error with file, line and remedy.
    """

def render(
    scene: Scene,
    frames: Optional[Frames] = None,
    mode: Optional[Literal["auto", "reproject", "full"]] = None,
    progress: Optional[Callable[[int, float], Any]] = None,
    **settings: Any,
) -> Render:
    """Renders frames of a scene, in the order in which they are made of one another.

    Renders that follow each other go on with the samples of the one before, where neither the scene nor settings have changed.

    frames: "1-48", "1-48x2", a number, a range, or numbers (the scene's). mode: when samples are reused (the scene's). progress: called
    with the frame's number and its share that is done, 0 to 1, by the thread that waits for the frame; an exception in it, or False as
    its result, cancels. settings: keys of [render], [indirect] and [output] in shot files, as size, samples, paths, layers, denoise;
    occlusion_radius and occlusion_rays; crop=(x, y, width, height), threads, backend, audit, build.

    Raises Error for settings that make no sense. The iterator raises Error, Cancelled, and what the progress function raises.
    """
