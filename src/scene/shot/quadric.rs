//! Quadrics and planes of a shot file.

use std::ops::Range;

use glam::DVec3;

use crate::animation::TransformTrack;
use crate::geometry::Quadric;
use crate::geometry::quadric::QuadricShape;
use crate::scene::import::Import;
use crate::scene::keys::quadric::{QuadricTable, QuadricType};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::render_space::{Extent, RenderSpace};
use crate::scene::{Mesh, Model, SceneError};

/// Dimensions if the shot does not state them, in the units of the files.
const USUAL_RADIUS: f64 = 1.0;
const USUAL_HEIGHT: f64 = 2.0;

/// Distance to which a plane is drawn, in diagonals of the box around everything else and the eye: its rim is
/// so near to the horizon that no pixel tells them apart.
const REACH: f64 = 1e6;

/// Maximum distance to which a plane is drawn, in the units in which the shot is rendered: squares of
/// coordinates stay finite.
const FARTHEST_RIM: f64 = 1e15;

/// Reads the mesh that `table` describes, object space. A plane is drawn as far as 1: see [`spread`].
///
/// # Errors With line and column: values that make no sense, keys of another shape, or a material that is not
/// there.
pub fn of_table(
    text: TomlText<'_>,
    table: &At<QuadricTable>,
    import: &mut Import,
) -> Result<Mesh, SceneError> {
    let quadric = table.get_ref();
    refuse_foreign_keys(text, quadric)?;
    let shape = shape(text, table)?;
    let is_open = quadric.open.as_ref().is_some_and(|open| *open.get_ref());
    let material = material_named(text, table.span(), quadric.material.as_ref(), import)?;
    let mesh =
        Mesh::of_curved(Quadric::new(shape, is_open), material, import.surfaces.casts_shadow(material));
    Ok(import.arranger().with_details(mesh, &[]))
}

/// Number of the material that a table of geometry names, or of matt grey if it names none; `at`: where the table is.
///
/// # Errors If there is no such material, or too many.
pub fn material_named(
    text: TomlText<'_>,
    at: Range<usize>,
    name: Option<&At<String>>,
    import: &mut Import,
) -> Result<u16, SceneError> {
    let material = match name {
        None => import.material_of_table(""),
        Some(name) if name.get_ref().is_empty() => None,
        Some(name) => import.material_of_table(name.get_ref()),
    };
    let unknown = || {
        let name = name.map_or("", |name| name.get_ref());
        format!("there is no [[material]] `{name}`{}", import.surfaces.hint_at(name))
    };
    let span = name.map_or(at, At::span);
    let material = material.ok_or_else(|| text.fault(span.clone(), unknown()))?;
    material.map_err(|why| text.fault(span, why))
}

fn shape(text: TomlText<'_>, table: &At<QuadricTable>) -> Result<QuadricShape, SceneError> {
    let (table, span) = (table.get_ref(), table.span());
    const SIZE: &str = "a length from 1e-9 to 1e9";
    let is_size = |length: f64| (1e-9..=1e9).contains(&length);
    let length = |key, value: &Option<At<f64>>, default, wanted: &str, fits: &dyn Fn(f64) -> bool| {
        value.as_ref().map_or(Ok(default), |value| text.number(key, value, wanted, fits))
    };
    let radius = length("radius", &table.radius, USUAL_RADIUS, SIZE, &is_size)?;
    let height = length("height", &table.height, USUAL_HEIGHT, SIZE, &is_size)?;
    Ok(match table.kind {
        QuadricType::Sphere => QuadricShape::Ellipsoid { radii: DVec3::splat(radius) },
        QuadricType::Ellipsoid => {
            let missing = "an ellipsoid needs `radii = [x, y, z]`";
            let radii = table.radii.as_ref().ok_or_else(|| text.fault(span.clone(), missing))?;
            let all = DVec3::from_array(radii.get_ref().0);
            if !all.to_array().into_iter().all(is_size) {
                return Err(text.bad("radii", radii, &format!("must be three lengths, each {}", &SIZE[9..])));
            }
            QuadricShape::Ellipsoid { radii: all }
        }
        QuadricType::Cylinder => QuadricShape::Cylinder { radius, height },
        QuadricType::Cone => {
            let wanted = "0 (a tip), or a length from 1e-9 to 1e9";
            let top = length("top", &table.top, 0.0, wanted, &|top| top == 0.0 || is_size(top))?;
            QuadricShape::Cone { radius, top, height }
        }
        QuadricType::Paraboloid => QuadricShape::Paraboloid { radius, height },
        QuadricType::Hyperboloid => match (&table.waist, &table.gap) {
            (Some(_), Some(gap)) => {
                let message = "and `waist` exclude each other: a hyperboloid has one sheet with a waist, or two with a gap";
                return Err(text.bad("gap", gap, message));
            }
            (_, Some(gap)) => {
                let wanted =
                    format!("more than a millionth of the height, and less than the height, {height}");
                let fits = |gap| gap > height * 1e-6 && gap < height * (1.0 - 1e-6);
                QuadricShape::TwoSheets { radius, gap: text.number("gap", gap, &wanted, fits)?, height }
            }
            (waist, None) => {
                let wanted =
                    format!("more than a millionth of the radius, and less than the radius, {radius}");
                let fits = |waist| waist > radius * 1e-6 && waist < radius * (1.0 - 1e-6);
                let waist = length("waist", waist, radius * 0.5, &wanted, &fits)?;
                QuadricShape::OneSheet { radius, waist, height }
            }
        },
        QuadricType::Plane => QuadricShape::Plane { center: [0.0; 2], reach: 1.0 },
    })
}

fn refuse_foreign_keys(text: TomlText<'_>, table: &QuadricTable) -> Result<(), SceneError> {
    let number = |value: &Option<At<f64>>| value.as_ref().map(At::span);
    let stated = [
        ("radius", number(&table.radius)),
        ("radii", table.radii.as_ref().map(At::span)),
        ("height", number(&table.height)),
        ("top", number(&table.top)),
        ("waist", number(&table.waist)),
        ("gap", number(&table.gap)),
        ("open", table.open.as_ref().map(At::span)),
    ];
    let (kind, keys) = (table.kind.name(), table.kind.keys());
    let foreign = stated.into_iter().filter_map(|(name, span)| span.map(|span| (name, span)));
    let Some((name, span)) = foreign.into_iter().find(|(name, _)| !keys.contains(name)) else {
        return Ok(());
    };
    let takes = match keys {
        [] => String::from("`material` alone"),
        keys => format!("{} and material", keys.join(", ")),
    };
    let article = if kind.starts_with('e') { "an" } else { "a" };
    Err(text.fault(span, format!("{article} {kind} has no `{name}`: it takes {takes}")))
}

/// Returns true if a model is a plane, which has no size.
pub fn is_endless(model: &Model) -> bool {
    model.mesh.as_curved().is_some_and(|curved| curved.is_endless())
}

/// Bounds of the factors by which a plane's lengths are stretched, the least and the greatest. A matrix may
/// tilt the plane.
fn stretch(track: &TransformTrack) -> [f64; 2] {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, 0.0], |[least, most], value| {
            [f64::min(least, value), f64::max(most, value)]
        })
    };
    let Some(matrix) = &track.matrix else {
        return range(&mut track.scale.values().flat_map(|scale| [scale.x.abs(), scale.z.abs()]));
    };
    let of_scale = range(&mut track.scale.values().flat_map(|scale| scale.abs().to_array()));
    let of_matrix = range(&mut matrix.values().flat_map(|matrix| {
        // of a map's two columns: the roots of the eigenvalues of their products
        let [x, z] = [matrix.matrix3.x_axis, matrix.matrix3.z_axis];
        let (sum, product) = (x.length_squared() + z.length_squared(), x.cross(z).length_squared());
        let greatest = 0.5 * (sum + (sum * sum - 4.0 * product).max(0.0).sqrt());
        [(product / greatest).sqrt(), greatest.sqrt()]
    }));
    [of_scale[0] * of_matrix[0], of_scale[1] * of_matrix[1]]
}

/// Extends `model`, if it is a plane, as far as anything of the shot could show. `extent`: of all other
/// models and the eye, in the space of the files; `frame`: the shot's first.
pub fn spread(model: Model, extent: &Extent, space: &RenderSpace, frame: i32) -> Model {
    if !is_endless(&model) {
        return model;
    }
    let [least, most] = stretch(&model.track);
    let center = model.track.map_at(frame.into()).inverse().transform_point3(extent.center());
    let reach = (extent.diagonal() * REACH / least).min(FARTHEST_RIM / space.scale() / most);
    let shape = QuadricShape::Plane { center: [center.x, center.z], reach };
    let (material, casts_shadow) = (model.mesh.material_of[0], model.mesh.shadow_casting > 0);
    let plane = Mesh::of_curved(Quadric::new(shape, false), material, casts_shadow);
    let mesh = Mesh { details: model.mesh.details.clone(), ..plane };
    Model { mesh: mesh.into(), ..model }
}
