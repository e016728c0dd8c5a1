//! Nodes without inputs: what the surface gives.

use std::sync::Arc;

use glam::Vec3;

use crate::graph::{Definition, Function, Kind, Options, Places, UvSet};
use crate::lanes::Vec3x8;

/// Texture coordinates; option `set`: 1 for the second set.
pub static UV: Definition =
    Definition { name: "blender_uv", inputs: &[], outputs: &[("out", Kind::Vector)], function: uv };

/// Place in object space.
pub static POINT: Definition = Definition {
    name: "blender_object_coordinates",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::Point)),
};

/// Place in the box around the mesh, from 0 to 1.
pub static GENERATED: Definition = Definition {
    name: "blender_generated_coordinates",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::Generated)),
};

/// Normal in object space.
pub static NORMAL: Definition = Definition {
    name: "blender_object_normal",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::Normal)),
};

/// Place in the world.
pub static WORLD_POINT: Definition = Definition {
    name: "blender_world_coordinates",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::WorldPoint)),
};

/// Normal in the world.
pub static WORLD_NORMAL: Definition = Definition {
    name: "blender_world_normal",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::WorldNormal)),
};

/// Colour of the vertices; option `attribute`: its name, though meshes have one colour alone.
pub static VERTEX_COLOR: Definition = Definition {
    name: "blender_vertex_color",
    inputs: &[],
    outputs: &[("out", Kind::Color)],
    function: |options, _| {
        options.text("attribute");
        Ok(Arc::new(Source::VertexColor))
    },
};

/// Origin of the model in the world.
pub static MODEL_PLACE: Definition = Definition {
    name: "blender_object_location",
    inputs: &[],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(Arc::new(Source::ModelPlace)),
};

/// Number of the model, from 0 to 1.
pub static MODEL_RANDOM: Definition = Definition {
    name: "blender_object_random",
    inputs: &[],
    outputs: &[("out", Kind::Number)],
    function: |_, _| Ok(Arc::new(Source::ModelRandom)),
};

/// What a grid of a volume has; option `grid`: its name. Zero where there is no volume, or no such grid.
pub static VOLUME_GRID: Definition = Definition {
    name: "blender_volume_grid",
    inputs: &[],
    outputs: &[("color", Kind::Color), ("value", Kind::Number)],
    function: |options, output| {
        let grid = options.text("grid").unwrap_or("density").to_string();
        Ok(Arc::new(Source::Volume(grid, output == 1)))
    },
};

fn uv(options: &Options, _: usize) -> Result<Arc<dyn Function>, String> {
    let named = |set: &str| match set {
        "0" => Some(UvSet::First),
        "1" => Some(UvSet::Second),
        _ => None,
    };
    Ok(Arc::new(Source::Uv(options.one_of("set", UvSet::First, named)?)))
}

/// What a surface gives.
#[derive(Debug)]
enum Source {
    Uv(UvSet),
    Point,
    Generated,
    Normal,
    WorldPoint,
    WorldNormal,
    ModelPlace,
    ModelRandom,
    VertexColor,
    /// Name of a grid, and whether a vector of it counts by its mean.
    Volume(String, bool),
}

impl Function for Source {
    fn is_of_place(&self) -> bool {
        true
    }

    fn values(&self, _: &[Vec3x8], places: Places) -> Vec3x8 {
        places.each(|_, place| match self {
            Self::Uv(set) => place.uv(*set).extend(0.0),
            Self::Point => place.point(),
            Self::Generated => place.generated(),
            Self::Normal => place.normal(),
            Self::WorldPoint => place.world_point(),
            Self::WorldNormal => place.world_normal(),
            Self::ModelPlace => place.model_place(),
            Self::ModelRandom => Vec3::splat(place.model_random()),
            Self::VertexColor => place.vertex_color(),
            Self::Volume(grid, is_number) => {
                let value = place.of_volume(grid).unwrap_or(Vec3::ZERO);
                if *is_number { Vec3::splat(value.element_sum() / 3.0) } else { value }
            }
        })
    }
}
