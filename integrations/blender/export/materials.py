# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: surfaces to [[material]] tables and their pictures."""

from dataclasses import fields

import numpy as np

from . import graphs, toml
from .at_rest import trees_of, values_of
from .glass import glass_of, varies
from .images import safe
from .meshes import digest_of
from .nodes import Evaluator, alike, constant
from .pictures import Pictures
from .rays import Seen
from .surfaces import BLENDED, Surface, is_colored, is_zero, surface_of, surface_to_all
from .volumes import Medium, medium_of, nothing

GRAPHS = "materials.mtlx"
"""File of what nodes compute, beside the shot."""

LEAST_ALPHA = 1e-3
"""Alpha below which what a surface shows is not known from the light that is left."""

MOST_BENDING = 100.0
"""The largest index of refraction that the renderer takes."""

VEIL_TEXELS = 256
"""Edge of the picture of an even veil. Shadow rays pass or are stopped by chance, once for a part of a texel."""

SOFT_SHARE = 0.1
"""Share of a picture's alpha that is neither there nor gone from which on its surface is a veil."""

PARTS = {"coat": ("coat_roughness", "coat_ior", "coat_tint"), "subsurface": ("radius",)}
"""Parameters that say what a part of a surface is like, by its weight."""


class Materials:
    """The materials of an export. Each is written when a mesh uses it first."""

    def __init__(self, images, warnings, exposure=1.0):
        self.images, self.warnings, self.exposure = images, warnings, exposure
        self.names, self.read, self.tables, self.seen = {}, {}, {}, {}
        self.of_volumes = {}
        """Names of the tables of what materials say of volumes, and the grids that they take."""
        self.document = graphs.Document(lambda pixels, name: images.write_color(f"{name} node", np.asarray(pixels)))

    def surface(self, material):
        """The surface of a material, and its evaluator. None is Blender's default grey."""
        key = material.name_full if material else ""
        if material:
            self.seen[key] = material.original
        if key not in self.read:
            self.read[key] = self._read(material)
        return self.read[key]

    def _read(self, material):
        """Reads the surface of a material, as it is now."""
        if material is None:
            return Surface(), Evaluator(Pictures(self.images))
        images = [getattr(node, "image", None) for tree in trees_of(material) for node in tree.nodes]
        pictures = Pictures(self.images, images)

        def read(attributes_vary):
            return surface_to_all(lambda ray: Evaluator(pictures, ray=ray, has_graphs=True, attributes_vary=attributes_vary), material)

        try:
            surface, evaluator = read(False)
            if evaluator.asked and glass_depends_on_attributes(surface, evaluator, material):
                surface, evaluator = read(True)
        except (AttributeError, IndexError, KeyError, TypeError, ValueError, RuntimeError) as error:
            # a node of an unknown version must not end the export
            surface, evaluator = Surface(), Evaluator(pictures)
            evaluator.said = [f"cannot be read ({type(error).__name__}: {error}) and is shown in grey"]
        if evaluator.asked:
            self._probe(material, surface, evaluator)
        for each in fields(surface):
            value = getattr(surface, each.name)
            if isinstance(value, np.ndarray) and value.shape[:2] == (1, 1) and np.isnan(value).any():
                evaluator.say("its values that are not numbers are 0 (check its drivers)")
                setattr(surface, each.name, np.nan_to_num(value, nan=0.0))
        if surface.seen.holdout and is_veil(surface):
            evaluator.say("its holdout is a whole one also where it is clear in part")
        return surface, evaluator

    def shown(self, material):
        """What is shown of a material as it is now, as one list to compare. What is replaced by a constant is no change."""
        surface, evaluator = self._read(material)
        found = [summary(getattr(surface, each.name), each.name in COMPUTED) for each in fields(surface)]
        found.append([evaluator.uv[0], summary(evaluator.uv[1])] if evaluator.uv else [])
        return [*found, values_of(material)] if evaluator.painted else found

    def at(self, frame):
        """Has pictures be those of a frame from now on."""
        self.images.at(frame)

    def clips(self, material, time):
        """Which pictures of movies and sequences a material shows at a time, as a list to compare."""
        return sorted(clip.at(time) for clip in self.surface(material)[1].pictures.clips)

    def originals(self):
        """All materials that were asked for, as they are saved: those that are evaluated do not outlive a frame."""
        return list(self.seen.values())

    def forget(self):
        """Forgets what surfaces are like, so that they are read again."""
        self.read.clear()

    def _probe(self, material, surface, evaluator):
        """Finds out what depends on colour attributes: how a surface with others differs. The base colour alone may."""
        found = [graphs.graph_of(part) for part in (surface.base, *((surface.transmission, surface.tint) if evaluator.attributes_vary else ()))]
        found = [graph for graph in found if graph is not None]
        if found:
            names = sorted(set().union(*(graph.attributes for graph in found)))
            evaluator.vertex_color = names[0] if names else None
            if len(names) > 1:
                evaluator.say(f"of its colour attributes `{names[0]}` counts beside what nodes compute")
            return
        other = otherwise_painted(evaluator, material)
        differs = [part for part in (*BLENDED, "emission", "alpha", "veil") if not np.array_equal(getattr(surface, part), getattr(other, part))]
        if "base" in differs:
            if surface.base.shape[:2] != (1, 1):
                evaluator.say("its colour attribute is left out beside pictures")
            else:
                evaluator.painted = True
                surface.base = constant(1.0, 1.0, 1.0)
        if set(differs) - {"base", "tint"}:
            evaluator.say("colour attributes count for its base colour alone")

    def is_there(self, material):
        """Returns true if faces of a material are drawn. If not, that is told."""
        surface, evaluator = self.surface(material)
        if not surface.is_there:
            self._tell(material, evaluator)
        return surface.is_there

    def is_medium(self, material):
        """Returns true if a material has no surface, and is what fills its meshes."""
        return not self.surface(material)[0].has_surface

    def leave_out(self, material):
        """Tells that faces of a medium are left out, as others of their mesh have surfaces."""
        self.warnings.add_for(f"material `{material.name}`", ["it has a volume and no surface, and its faces are left out beside others of a mesh"])

    def visibility(self, material):
        """To which rays faces of a material show themselves."""
        return self.surface(material)[0].seen

    def is_veil(self, material):
        """Returns true if a material is clear in part."""
        return is_veil(self.surface(material)[0])

    def reflects_nothing(self, material):
        """Returns true if a material is black or clear."""
        surface, evaluator = self.surface(material)
        is_black = all(is_zero(part) for part in (surface.base, surface.specular, surface.transmission)) and not evaluator.painted
        return is_black or is_zero(surface.alpha)

    def is_even_veil(self, material):
        """Returns true if a material is clear in part, and without a picture of its own as much so everywhere."""
        return is_even_veil(self.surface(material)[0])

    def _tell(self, material, evaluator):
        """Tells what was replaced of a material."""
        self.warnings.add_for(f"material `{material.name if material else 'default'}`", evaluator.said)

    def attributes(self, materials):
        """Names of the colour attributes that meshes of these materials need."""
        evaluators = [self.surface(material)[1] for material in materials if material]
        painted = {name for evaluator in evaluators if evaluator.painted for name in evaluator.asked}
        return painted | {evaluator.vertex_color for evaluator in evaluators if evaluator.vertex_color}

    def colors(self, material, geometry, mesh):
        """Base colours at the corners of a mesh, (corners, 3); None where they do not depend on its colour attributes."""
        evaluator = self.surface(material)[1]
        if not evaluator.painted and not evaluator.vertex_color:
            return None
        asked = evaluator.asked if evaluator.painted else {evaluator.vertex_color}
        for name in sorted(asked - set(geometry.colors)):
            self.warnings.add(f"mesh `{mesh}` has no colour attribute `{name}`, which material `{material.name}` wants: it is black there")
        black = np.zeros((geometry.corners, 3), dtype=np.float32)
        if evaluator.vertex_color:
            return np.clip(geometry.colors.get(evaluator.vertex_color, black), 0, 1)
        base = surface_of(Evaluator(evaluator.pictures, lambda name: geometry.colors.get(name, black)[:, None, :], evaluator.ray), material).base
        return np.clip(np.broadcast_to(base[:, 0, :], black.shape), 0, 1)

    def name(self, material):
        """The name of a material in the shot, which is also that of the files of its meshes: as Blender's, if files may have it."""
        key = material.name_full if material else ""
        if key not in self.names:
            self.names[key] = self._unlike(safe(material.name if material else "default"))
        return self.names[key]

    def _unlike(self, stem):
        """A name like this that no other material has."""
        taken = {name.lower() for name in self.names.values()}
        name, count = stem, 1
        while name.lower() in taken:
            count += 1
            name = f"{stem} {count}"
        return name

    def indices(self):
        """Pass indices of materials, by their names in the shot."""
        return {self.name(material): material.pass_index for material in self.originals()}

    def uv(self, material):
        """Name of the UV map of a material's pictures and the mapping of (u, v, 1); None without pictures."""
        return self.surface(material)[1].uv

    def has_tiles(self, material):
        """Returns true if its pictures are tiles of UDIM."""
        evaluator = self.surface(material)[1]
        return evaluator.uv is not None and evaluator.pictures.mosaic is not None

    def ask_random(self):
        """Returns true if a graph takes the number by which copies of a mesh differ."""

        def asks(value):
            if isinstance(value, tuple):
                return any(map(asks, value))
            graph = value if isinstance(value, graphs.Node) else graphs.graph_of(value)
            return graph is not None and graph.asks_random

        return any(asks(getattr(surface, each.name)) for surface, _ in self.read.values() for each in fields(surface))

    def has_bump(self, material):
        """Returns true if it needs to know how large a texture is on its mesh."""
        return self.surface(material)[0].bump is not None

    def use(self, material, density=1.0, scale=1.0):
        """Writes the table of a material, once. `density`: units of the world in one unit of the texture, and `scale` in one of its mesh."""
        name = self.name(material)
        if name in self.tables:
            return
        surface, evaluator = self.surface(material)
        glass = glass_of(surface, evaluator)
        values = {"name": name, **self._values(name, surface, glass, evaluator, density), **self._medium(surface)}
        written = self._graphs(name, surface, glass, evaluator, scale, values)
        unused = {name for of, names in PARTS.items() if is_zero(getattr(surface, of)) for name in names}
        computed = [
            each.name
            for each in fields(surface)
            if each.name not in written | unused and graphs.graph_of(getattr(surface, each.name)) is not None
        ]
        if computed:
            evaluator.say(f"nodes compute its {', '.join(computed).replace('_', ' ')}: a constant counts in place of each")
        self.tables[name] = toml.table("[[material]]", values)
        self._tell(material, evaluator)

    def use_of_volume(self, material, factor, there):
        """Writes the table of what a material says of a volume, once, and `factor` times as much of it. `there`: names of its grids. Returns the
        table's name, the grids that it takes, and to which rays it shows itself."""
        key = (material.name_full if material else "", factor, tuple(there))
        if key not in self.of_volumes:
            name = self._unlike(f"{safe(material.name if material else 'default')} volume")
            self.names["volume", *key] = name
            medium, evaluator = self._read_volume(material, there)
            values = {"name": name, "surface": False, **({"volume_density": factor} if factor != 1 else {})}
            if medium.varies():
                medium.emit = medium.emit * self.exposure
                self.document.add(name, {}, {}, np.eye(3), None, medium, False)
                values["mtlx"] = GRAPHS
            else:
                values |= medium.keys(self.exposure, "volume_")
            self.tables[name] = toml.table("[[material]]", values)
            self._tell(material, evaluator)
            self.of_volumes[key] = name, frozenset(evaluator.grids)
        if material:
            self.seen[material.name_full] = material.original
        return *self.of_volumes[key], self.visibility(material)

    def _read_volume(self, material, there):
        """Reads what a material says of a volume with these grids, and its evaluator."""
        evaluator = Evaluator(Pictures(self.images), has_graphs=True)
        evaluator.grids, evaluator.grids_there = set(), there
        if material is None or not material.use_nodes:
            density = graphs.computed(constant(0.5), graphs.of_grid(evaluator, "density", "float"))
            return Medium(constant(0.5, 0.5, 0.5) * density, constant(0.5, 0.5, 0.5) * density, constant(0.0, 0.0, 0.0)), evaluator
        outputs = [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL" and node.target in {"ALL", "CYCLES"}]
        outputs.sort(key=lambda node: not node.is_active_output)
        return medium_of(evaluator, outputs[0].inputs["Volume"]) if outputs else nothing(), evaluator

    def _medium(self, surface):
        """Keys of what fills its meshes. What nodes give from place to place, see _graphs."""
        medium = unpacked(surface)
        keys = medium.keys(self.exposure, "volume_") if medium is not None and not medium.varies() else {}
        return keys if surface.has_surface else {**keys, "surface": False}

    def _values(self, name, surface, glass, evaluator, density):
        """Keys of the [[material]]."""
        values = {}
        if glass is None or surface.alpha.shape[:2] != (1, 1):
            self._alpha(name, surface, evaluator, values)
        self._emission(name, surface, values)
        if glass is not None:
            self._glass(name, surface, glass, evaluator, values)
            self._inside(glass, values)
            if surface.alpha.shape[:2] == (1, 1) and float(surface.alpha.max()) < 1:
                evaluator.say("the alpha of glass is left out")
            self._normal(name, surface, evaluator, density, values)
            return values
        self._base(name, surface.base, evaluator, values)
        if surface.hair is not None:
            roughness, radial, coat, ior, offset = surface.hair
            values["hair"] = {"roughness": roughness, "radial_roughness": radial, "coat": coat, "ni": ior, "offset": float(np.clip(offset, -45, 45))}
            return values
        if float(surface.specular.max()) == 0 and float(surface.metallic.max()) == 0 and float(surface.coat.max()) == 0:
            values["illum"] = 1
            values["ks"] = [0.0, 0.0, 0.0]
        else:
            self._number(name, "roughness", surface.roughness, "pr", evaluator, values)
            self._number(name, "metallic", surface.metallic, "pm", evaluator, values)
            values["ni"] = index_of(reflectance(float(surface.ior.mean())) * float(surface.specular.mean()))
            self._coat(surface, evaluator, values)
        self._matt(surface, evaluator, values)
        below = float(np.clip(surface.subsurface, 0, 1).mean())
        if below > 1e-3:
            values["subsurface"] = below
            values["subsurface_radius"] = np.maximum(surface.radius.mean(axis=(0, 1)), 0).tolist()
            if surface.entry is not None:
                values.update(zip(("subsurface_ni", "subsurface_pr", "subsurface_matt"), surface.entry, strict=True))
            if surface.subsurface.shape[:2] != (1, 1) or surface.radius.shape[:2] != (1, 1):
                evaluator.say("pictures of its subsurface scattering count by their means")
        self._normal(name, surface, evaluator, density, values)
        return values

    @staticmethod
    def _inside(glass, values):
        """What glass absorbs: the colour of light that has come as far as the length at which the most of it is left by a half or so."""
        absorption = glass.absorption
        if float(absorption.max()) > 0:
            depth = 1 / float(absorption.max())
            values.update(depth=depth, depth_color=np.exp(-absorption * depth).tolist())

    def _matt(self, surface, evaluator, values):
        """What becomes of the light that it scatters, and the fuzz above all."""
        for key, value in (("diffuse_roughness", surface.matt_roughness), ("translucency", surface.translucency), ("fuzz", surface.fuzz)):
            share = float(np.clip(value, 0, 1).mean())
            if share > 1e-3:
                values[key] = share
        if "fuzz" in values:
            values["fuzz_roughness"] = float(np.clip(surface.fuzz_roughness, 0, 1).mean())
            tint = np.clip(surface.fuzz_tint.mean(axis=(0, 1)), 0, 1).tolist()
            if min(tint) < 1:
                values["fuzz_color"] = tint
        if "pm" in values or "map_pm" in values or graphs.graph_of(surface.metallic) is not None:
            edge = float(np.clip(surface.edge, 0, 1).mean())
            if edge < 1:
                values["metal_edge"] = edge
        anisotropy = float(np.clip(surface.anisotropy, 0, 1).mean())
        if anisotropy > 1e-3 and values.get("illum") != 1:
            turn, around = surface.tangent
            values.update(anisotropy=anisotropy, anisotropy_turn=turn)
            if around:
                values["anisotropy_around"] = around
        varying = (surface.matt_roughness, surface.translucency, surface.fuzz, surface.fuzz_roughness, surface.fuzz_tint)
        if any(part.shape[:2] != (1, 1) for part in varying):
            evaluator.say("pictures of its sheen, its translucency and its diffuse roughness count by their means")

    def _glass(self, name, surface, glass, evaluator, values):
        """Glass, and what is matt beside it. Where graphs say how much of it there is, see _graphs."""
        reflected, total = glass.reflected(surface)
        values.update(ks=reflected.tolist(), ni=min(max(0.0, float(surface.ior.mean())), MOST_BENDING))
        if total.min() < 1:
            values["ks_total"] = total.tolist()
        scattered = 1.0
        if not glass.is_of_graphs:
            share = 1.0 if varies(glass.share) else float(glass.share.mean())
            through = np.full(3, share) if varies(glass.tint) else np.clip(glass.tint.mean(axis=(0, 1)), 0, 1) * share
            # of what `tf` keeps back `kd` is scattered
            scattered = 1.0 if varies(glass.share) else min((1 - share) / max(1 - float(through.max()), 1e-6), 1.0)
            values.update(illum=7, tf=through.tolist())
            if varies(glass.tint):
                values["map_tf"] = self._color(name, "transmission colour", glass.tint, evaluator)
            if varies(glass.share):
                values["map_transmission"] = self.images.write_numbers(f"{name} transmission", glass.share)
        self._base(name, glass.base, evaluator, values, scattered)
        self._number(name, "roughness", surface.roughness, "pr", evaluator, values)

    @staticmethod
    def _coat(surface, evaluator, values):
        """The clear coat above the surface."""
        weight = float(np.clip(surface.coat, 0, 1).mean())
        if weight < 1e-3:
            return
        tint = np.clip(surface.coat_tint.mean(axis=(0, 1)), 0, 1).tolist()
        values.update(coat=weight, coat_roughness=float(np.clip(surface.coat_roughness, 0, 1).mean()), coat_ni=max(1.0, float(surface.coat_ior.mean())))
        # Blender's darken nothing, and those of materials with graphs would
        values["coat_darkening"] = 0.0
        if min(tint) < 1:
            values["coat_color"] = tint
        if any(part.shape[:2] != (1, 1) for part in (surface.coat, surface.coat_roughness, surface.coat_ior, surface.coat_tint)):
            evaluator.say("pictures of its coat count by their means")

    def _base(self, name, base, evaluator, values, factor=1.0):
        """The base colour, and a factor of it."""
        if graphs.graph_of(base) is not None:
            return
        if base.shape[:2] == (1, 1):
            values["kd"] = np.clip(base[0, 0] * factor, 0, 1).tolist()
            return
        values["map_kd"] = self._color(name, "base", base, evaluator)
        values["kd"] = [factor] * 3

    def _color(self, name, what, value, evaluator):
        """The file of a picture of colours: its own one, where nodes leave it as it is."""
        picture = evaluator.picture_of(value)
        clear = picture and (self.images.pixels(picture)[:, :, 3] >= 0.5).all()
        if clear and self.images.is_plain(picture, "sRGB"):
            return self.images.copy(picture)
        return self.images.write_color(f"{name} {what}", value)

    def _alpha(self, name, surface, evaluator, values):
        alpha = surface.alpha
        if graphs.graph_of(alpha) is not None:
            if is_colored(surface):
                evaluator.say("the colour of its transparent shader is left out")
        elif alpha.shape[:2] == (1, 1):
            if is_colored(surface):
                # the renderer has no colour of veils that are pictures
                values.update(d=max(0.0, float(alpha.mean())), tf=np.clip(surface.veil.mean(axis=(0, 1)), 0, 1).tolist())
                evaluator.say("its shadow is a full one or none, as it lets light through in a colour")
                if surface.veil.shape[:2] != (1, 1):
                    evaluator.say("the picture of the colour of its transparent shader counts by its mean")
            elif is_even_veil(surface):
                # a picture, for shadows of `d` alone are full ones or none: see mesh_store.anywhere
                values["map_d"] = self.images.write_numbers(f"{name} alpha", np.broadcast_to(alpha, (VEIL_TEXELS, VEIL_TEXELS, 1)))
                values["alpha_mode"] = "blend"
            elif float(alpha.mean()) <= 0:
                values["d"] = 0.0
        elif float(alpha.min()) < 0.999:
            values["map_d"] = self.images.write_numbers(f"{name} alpha", alpha)
            values["alpha_mode"] = "blend" if is_soft(alpha) else "cut"
            if is_colored(surface):
                evaluator.say("the colour of its transparent shader is left out")

    def _emission(self, name, surface, values):
        if graphs.graph_of(surface.emission) is not None:
            # see _graphs
            return
        light = surface.emission
        if values.get("alpha_mode") == "blend":
            light = undimmed(*alike(light, surface.alpha))
        light = np.clip(light * self.exposure, 0, 60000)
        if light.shape[:2] == (1, 1):
            values["ke"] = light[0, 0].tolist() if float(light.max()) > 0 else None
            return
        top = float(light.max())
        if top > 0:
            values["map_ke"] = self.images.write_color(f"{name} emission", light / top)
            values["ke"] = [top] * 3

    def _graphs(self, name, surface, glass, evaluator, scale, values):
        """Writes what nodes compute of a material, beside the keys that it has already. Returns the names of the parameters."""
        inputs, written = {}, set()
        constants = {"specular_weight": 0.0} if values.get("illum") == 1 else {}
        if glass is not None and glass.is_of_graphs:
            parameters = {"transmission_weight": glass.share, "transmission_color": glass.tint}
            if "depth_color" in values:
                # a parameter of the table has its place
                del parameters["transmission_color"]
            for parameter, value in parameters.items():
                if varies(value):
                    inputs[parameter] = graphs.of_value(value)
                else:
                    value = np.clip(value[0, 0], 0, 1)
                    constants[parameter] = value if len(value) == 3 else float(value[0])
        if graphs.graph_of(surface.alpha) is not None and glass is None:
            inputs["geometry_opacity"] = graphs.graph_of(surface.alpha)
            written.add("alpha")
        if graphs.graph_of(surface.emission) is not None:
            light = surface.emission * self.exposure
            if "alpha" in written or values.get("alpha_mode") == "blend":
                # what is blended is dimmed by the renderer
                light = light / np.maximum(surface.alpha, LEAST_ALPHA)
            inputs["emission_color"], constants["emission_luminance"] = graphs.graph_of(light), 1.0
            written.add("emission")
        base = surface.base if glass is None else glass.base
        parts = [("base", base, "kd", "base_color")]
        if values.get("illum") != 1:
            parts.append(("roughness", surface.roughness, "pr", "specular_roughness"))
        if glass is None and values.get("illum") != 1:
            parts.append(("metallic", surface.metallic, "pm", "base_metalness"))
        for part, value, key, parameter in parts:
            if graphs.graph_of(value) is not None and key not in values:
                inputs[parameter] = graphs.graph_of(value)
                written.add(part)
        if "base_color" in inputs and "subsurface" in values:
            # OpenPBR has a colour of its own for what goes below
            inputs["subsurface_color"] = inputs["base_color"]
        if surface.heights:
            inputs["geometry_normal"] = graphs.bump(surface.heights, scale)
            written.add("heights")
        displaced = None
        if surface.displaced:
            height, length, middle = surface.displaced
            varies_there = height.shape[:2] != (1, 1) or graphs.graph_of(height) is not None
            displaced = (graphs.of_value(height) if varies_there else float(height.mean()), length, middle)
            written.add("displaced")
        medium = unpacked(surface)
        if medium is not None and not medium.varies():
            medium = None
        if inputs or displaced or medium is not None:
            matrix = evaluator.uv[1] if evaluator.uv else np.eye(3)
            if medium is not None:
                medium.emit = medium.emit * self.exposure
                written.add("medium")
            self.document.add(name, inputs, constants, matrix, displaced, medium, surface.has_surface)
            values["mtlx"] = GRAPHS
        if glass is not None:
            return written | NOT_OF_GLASS
        # a matt surface has no layer, and what is left out of glass was told
        return written | ({"roughness", "metallic"} if values.get("illum") == 1 else set()) | {"base", "tint", "transmission", "shine"}

    def _number(self, name, what, value, key, evaluator, values):
        if graphs.graph_of(value) is not None and values.get("illum") != 1:
            # see _graphs
            return
        value = np.clip(value, 0, 1)
        if value.shape[:2] == (1, 1):
            values[key] = float(value.mean())
            return
        values[f"map_{key}"] = self.images.write_numbers(f"{name} {what}", value)
        values[key] = 1.0

    def _normal(self, name, surface, evaluator, density, values):
        if surface.bump is not None:
            height, slope = surface.bump
            normals = normals_of(height[:, :, 0], slope / max(density, 1e-9), evaluator.pictures.mosaic)
            values["norm"] = self.images.write_numbers(f"{name} bump", normals)
        elif surface.normal is not None:
            picture = evaluator.picture_of(surface.normal)
            if picture and self.images.is_plain(picture, "Non-Color"):
                values["norm"] = self.images.copy(picture)
            else:
                values["norm"] = self.images.write_numbers(f"{name} normal", surface.normal)


def unpacked(surface):
    """What fills the meshes of a surface; None of clear ones."""
    if not surface.medium:
        return None
    *colors, anisotropy = surface.medium
    return Medium(*colors, float(np.asarray(anisotropy).mean()))


NOT_OF_GLASS = {each.name for each in fields(Surface)} - {"ior", "alpha", "emission", "roughness", "absorption", "heights", "displaced", "medium"}
"""Parts of a surface that glass does not have, or of which glass.py tells."""

COMPUTED = {"base", "roughness", "metallic", "alpha", "emission", "heights", "displaced", "transmission", "tint", "medium"}
"""Parts of a surface that graphs may give. Of others a constant counts in place of a graph."""


def summary(value, may_be_computed=True):
    """Numbers as a list, and a digest of pictures and graphs."""
    if isinstance(value, tuple):
        return [summary(each, may_be_computed) for each in value]
    graph = value if isinstance(value, graphs.Node) else graphs.graph_of(value)
    if graph is not None:
        return graphs.described(graph) if may_be_computed else np.asarray(value).mean(axis=(0, 1)).tolist()
    if isinstance(value, Seen):
        return sorted(value.keys().items())
    if not isinstance(value, np.ndarray):
        return "" if value is None else value
    return value.ravel().tolist() if value.size <= 9 else digest_of(value).hex()


def is_soft(alpha):
    """Returns true if more than a tenth of what is there is so in part: more than the edges of leaves."""
    return int(((alpha > 0.1) & (alpha < 0.9)).sum()) > SOFT_SHARE * int((alpha > 0.1).sum())


def is_veil(surface):
    """Returns true if a surface is clear in part, and not cut out alone."""
    alpha = surface.alpha
    if graphs.graph_of(alpha) is not None:
        return True
    return float(alpha.max()) < 1 if alpha.shape[:2] == (1, 1) else is_soft(alpha)


def is_even_veil(surface):
    """Returns true if a surface is as clear everywhere, and neither gone nor whole."""
    return surface.alpha.shape[:2] == (1, 1) and 0 < float(surface.alpha.mean()) < 1 and graphs.graph_of(surface.alpha) is None


def undimmed(light, alpha):
    """The light that alpha has dimmed: the renderer dims what is blended. One texel if it is the same all over."""
    full = light / np.maximum(alpha, LEAST_ALPHA)
    full = np.where(alpha < LEAST_ALPHA, full.max(axis=(0, 1)), full)
    is_even = np.ptp(full, axis=(0, 1)).max() <= 1e-4 * full.max()
    return full[:1, :1] if is_even else full


def otherwise_painted(evaluator, material):
    """The surface of a material whose colour attributes are others."""
    return surface_of(Evaluator(evaluator.pictures, lambda name: constant(0.25, 0.5, 0.75), evaluator.ray), material)


def glass_depends_on_attributes(surface, evaluator, material):
    """Returns true if colour attributes say where a material is glass, or which colour has most of what goes through it."""
    other = otherwise_painted(evaluator, material)
    is_glass = float(max(part.transmission.mean() for part in (surface, other))) > 0.5
    return not np.array_equal(surface.transmission, other.transmission) or is_glass and not np.array_equal(surface.tint, other.tint)


def reflectance(ior):
    """Share of the light that a surface reflects at right angles (Fresnel's equations)."""
    return ((ior - 1) / (ior + 1)) ** 2


def index_of(head_on):
    """The index of refraction of what reflects so much at right angles."""
    root = max(np.sqrt(min(head_on, 0.9)), 0.005)
    return float((1 + root) / (1 - root))


def normals_of(height, slope, mosaic=None):
    """Directions from 0 to 1 of heights that repeat. `slope`: how much a height of 1 rises, in units of the texture's own size, which is the
    mean of its sides where it is a mosaic of square tiles."""
    rows, columns = height.shape
    wide = np.sqrt(mosaic.columns / mosaic.rows) if mosaic else 1.0
    along = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) * (columns / 2) * (slope / wide)
    up = (np.roll(height, -1, axis=0) - np.roll(height, 1, axis=0)) * (rows / 2) * (slope * wide)
    direction = np.stack([-along, -up, np.ones_like(height)], axis=2)
    return (direction / np.linalg.norm(direction, axis=2, keepdims=True) * 0.5 + 0.5).astype(np.float32)
