//! Phong's reflection model as MTL means it: no division by pi, no energy balance.

use glam::Vec3;

use crate::scene::Material;

use super::light::Arrival;

/// Light that leaves whatever the eye's place: emission and ambient light.
///
/// Where a texture colours the diffuse reflectance it colours the ambient one as well.
pub fn emitted_and_ambient(material: &Material, albedo: Vec3, ambient: Vec3) -> Vec3 {
    let reflectance = if material.diffuse_map.is_some() {
        let texture = Vec3::select(
            material.diffuse.cmpgt(Vec3::ZERO),
            albedo / material.diffuse.max(Vec3::splat(f32::MIN_POSITIVE)),
            Vec3::ZERO,
        );
        material.ambient * texture
    } else {
        material.ambient
    };
    material.emission + reflectance * ambient
}

/// Whether light from `direction` can reach the front of a surface with these normals. A shading normal
/// that leans beyond the facet's horizon does not make it reach.
#[inline]
pub fn faces(normal: Vec3, facet: Vec3, direction: Vec3) -> bool {
    normal.dot(direction) > 0.0 && facet.dot(direction) > 0.0
}

/// Diffuse light by Lambert's cosine law.
#[inline]
pub fn diffuse(albedo: Vec3, normal: Vec3, arrival: &Arrival) -> Vec3 {
    albedo * arrival.irradiance * normal.dot(arrival.direction).max(0.0)
}

/// The highlight: Ks (R . V)^Ns, where R is the direction to the light mirrored at the normal and `view`
/// (unit length) points to the eye.
#[inline]
pub fn specular(material: &Material, normal: Vec3, view: Vec3, arrival: &Arrival) -> Vec3 {
    let mirrored = 2.0 * normal.dot(arrival.direction) * normal - arrival.direction;
    let cos = mirrored.dot(view);
    if cos <= 0.0 {
        return Vec3::ZERO;
    }
    material.specular * arrival.irradiance * cos.powf(material.shininess)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(direction: Vec3) -> Arrival {
        Arrival { to_light: direction, direction, far: f32::INFINITY, irradiance: Vec3::splat(2.0) }
    }

    #[test]
    fn diffuse_follows_the_cosine() {
        let slanted = from(Vec3::new(0.6, 0.8, 0.0));
        let lit = diffuse(Vec3::splat(0.5), Vec3::Y, &slanted);
        assert!((lit - Vec3::splat(0.8)).length() < 1e-6);
        assert_eq!(diffuse(Vec3::ONE, Vec3::NEG_Y, &slanted), Vec3::ZERO);
    }

    #[test]
    fn the_highlight_peaks_in_the_mirror_direction() {
        let material = Material { specular: Vec3::splat(0.25), shininess: 10.0, ..Material::fallback() };
        let slanted = from(Vec3::new(0.6, 0.8, 0.0));
        let peak = specular(&material, Vec3::Y, Vec3::new(-0.6, 0.8, 0.0), &slanted);
        assert!((peak - Vec3::splat(0.5)).length() < 1e-5, "{peak}");
        assert_eq!(specular(&material, Vec3::Y, Vec3::new(1.0, 0.0, 0.0), &slanted), Vec3::ZERO);
    }

    #[test]
    fn a_texture_colours_the_ambient_light_too() {
        let material = Material {
            diffuse: Vec3::splat(0.5),
            ambient: Vec3::ONE,
            diffuse_map: Some(0),
            ..Material::fallback()
        };
        let light = emitted_and_ambient(&material, Vec3::new(0.5, 0.25, 0.0), Vec3::splat(0.1));
        assert!((light - Vec3::new(0.1, 0.05, 0.0)).length() < 1e-6);
    }
}
