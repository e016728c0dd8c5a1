//! Blender's Fresnel and Layer Weight nodes.
//!
//! They see a normal only by its cosine: the dot product of the normal and the direction towards the viewer, both of length 1.
//! Its sign does not matter: which side we see is told apart.
use super::finite;

/// The smallest index of refraction of the nodes.
const LEAST: f32 = 1e-5;

/// The reflectance of an interface to a dielectric, 0 to 1, for unpolarised light. `ior` is the ratio of the refractive indices, that
/// of the far side over that of the near one.
pub fn dielectric(cosine: f32, ior: f32) -> f32 {
    let near = cosine.abs();
    let squared = ior * ior - 1.0 + near * near;
    if squared <= 0.0 {
        return 1.0; // total reflection
    }
    let far = squared.sqrt();
    let across = (far - near) / (far + near);
    let along = (near * (far + near) - 1.0) / (near * (far - near) + 1.0);
    finite(0.5 * across * across * (1.0 + along * along))
}

/// Blender's Fresnel node. `inside` is whether we see the surface from its back, as where light leaves the material.
pub fn fresnel(cosine: f32, ior: f32, inside: bool) -> f32 {
    let ior = ior.max(LEAST);
    dielectric(cosine, if inside { 1.0 / ior } else { ior })
}

/// The output "Fresnel" of Blender's Layer Weight node: that of an index of 1 / (1 - blend).
pub fn layer_fresnel(cosine: f32, blend: f32, inside: bool) -> f32 {
    let inverse = (1.0 - blend).max(LEAST);
    dielectric(cosine, if inside { inverse } else { 1.0 / inverse })
}

/// The output "Facing" of Blender's Layer Weight node: 0 where we look straight at the surface, 1 at its outline. `blend` moves the
/// transition; at one half it is 1 - the cosine.
pub fn layer_facing(cosine: f32, blend: f32) -> f32 {
    let blend = blend.clamp(0.0, 1.0 - LEAST);
    let exponent = if blend < 0.5 { 2.0 * blend } else { 0.5 / (1.0 - blend) };
    finite(1.0 - cosine.abs().powf(exponent))
}
