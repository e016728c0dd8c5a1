//! Meshes that a skeleton or blend shapes deform (UsdSkelBindingAPI): their points at each frame.

use std::collections::BTreeSet;
use std::rc::Rc;

use glam::{DAffine3, DVec3, Vec3};
use openusd::sdf::Value;
use openusd::usd::{Prim, Stage};
use rayon::prelude::*;

use super::place::affine;
use super::skeleton::{PoseKey, Skeleton};
use super::value::{
    Answer, PrimError, Read, numbers, points, said, targets, value, whole_numbers, word, words,
};
use crate::scene::Shapes;

/// A mesh's binding to a skeleton.
pub struct Skin {
    skeleton: Rc<Skeleton>,
    /// Map from the mesh to the skeleton as it was bound.
    bind: DAffine3,
    /// Joints and weights of the points, as many a point; none of a mesh that has blend shapes alone.
    influences: Option<Influences>,
    blend_shapes: Vec<BlendShape>,
}

struct Influences {
    a_point: usize,
    joints: Vec<usize>,
    weights: Vec<f64>,
    /// True if all points have those of the first.
    is_rigid: bool,
}

struct BlendShape {
    /// Number of its weight in the skeleton's poses.
    number: usize,
    /// Points that it moves, and by what.
    offsets: Vec<(usize, DVec3)>,
}

/// Returns true if a mesh is bound to joints, or has blend shapes.
///
/// # Errors What the library says.
pub fn is_bound(prim: &Prim) -> Answer<bool> {
    let names = said(prim.property_names())?;
    let is_ours = |name: &str| matches!(name, "primvars:skel:jointIndices" | "skel:blendShapeTargets");
    Ok(names.iter().any(|name| is_ours(name.as_str())))
}

impl Skin {
    /// Reads the binding of a mesh to a skeleton. `unused` grows by what has no effect.
    ///
    /// # Errors Joints that are not there, lists that do not fit the points, and what the library says.
    pub fn read(
        stage: &Stage,
        prim: &Prim,
        skeleton: Rc<Skeleton>,
        code: f64,
        unused: &mut BTreeSet<String>,
    ) -> Answer<Self> {
        let bind = value(prim, "primvars:skel:geomBindTransform", code)?;
        let bind = bind.as_ref().and_then(numbers).and_then(|numbers| affine(&numbers));
        if word(prim, "primvars:skel:skinningMethod", code)?.as_deref() == Some("dualQuaternion") {
            unused.insert(String::from("skins with dual quaternions are blended linearly"));
        }
        let influences = Influences::read(prim, &skeleton, code)?;
        if let (Some(influences), Some(points)) =
            (&influences, value(prim, "points", code)?.as_ref().and_then(points))
        {
            influences.check(points.len())?;
        }
        Ok(Self {
            bind: bind.filter(DAffine3::is_finite).unwrap_or(DAffine3::IDENTITY),
            influences,
            blend_shapes: blend_shapes(stage, prim, &skeleton.blend_shapes, code, unused)?,
            skeleton,
        })
    }

    /// True if joints move the mesh: its points are in the space of the skeleton then, otherwise in its own.
    pub fn has_joints(&self) -> bool {
        self.influences.is_some()
    }

    /// Frames, and the points at these.
    ///
    /// # Errors Lists that do not fit the points; more than there is memory for.
    pub fn shapes(&self, rest: &[[f32; 3]]) -> Read<Vec<(f64, Vec<[f32; 3]>)>> {
        if let Some(influences) = &self.influences {
            influences.check(rest.len())?;
        }
        said(Shapes::check_memory(self.skeleton.keys.len(), rest.len())).map_err(PrimError::Fatal)?;
        Ok(self.skeleton.keys.iter().map(|key| (key.frame, self.points(rest, key))).collect())
    }

    fn points(&self, rest: &[[f32; 3]], key: &PoseKey) -> Vec<[f32; 3]> {
        let mut points: Vec<DVec3> = rest.iter().map(|point| Vec3::from(*point).as_dvec3()).collect();
        for BlendShape { number, offsets } in &self.blend_shapes {
            let weight = key.weights.get(*number).copied().unwrap_or(0.0);
            for (point, offset) in offsets.iter().filter(|_| weight != 0.0) {
                if let Some(point) = points.get_mut(*point) {
                    *point += *offset * weight;
                }
            }
        }
        if let Some(influences) = &self.influences {
            let bind = self.bind;
            points.par_iter_mut().enumerate().for_each(|(number, point)| {
                *point = influences.moved(&key.joints, number, bind.transform_point3(*point));
            });
        }
        points.into_iter().map(|point| point.as_vec3().to_array()).collect()
    }
}

impl Influences {
    fn read(prim: &Prim, skeleton: &Skeleton, code: f64) -> Answer<Option<Self>> {
        let (indices, weights) = ("primvars:skel:jointIndices", "primvars:skel:jointWeights");
        let joints = value(prim, indices, code)?.as_ref().and_then(whole_numbers).unwrap_or_default();
        let weights = value(prim, weights, code)?.as_ref().and_then(numbers).unwrap_or_default();
        if joints.is_empty() || weights.is_empty() {
            return Ok(None);
        }
        let stated = said(prim.attribute(indices).get_metadata::<Value>("elementSize"))?;
        let stated = stated.as_ref().and_then(whole_numbers).and_then(|numbers| numbers.first().copied());
        let a_point = stated.and_then(|count| usize::try_from(count).ok()).unwrap_or(1).max(1);
        if joints.len() != weights.len() || joints.len() % a_point != 0 {
            let (joints, weights) = (joints.len(), weights.len());
            return Err(format!(
                "it has {joints} jointIndices and {weights} jointWeights, {a_point} a point"
            ));
        }
        let own = value(prim, "skel:joints", code)?.as_ref().and_then(words).filter(|own| !own.is_empty());
        let of_skeleton = |name: &String| skeleton.joints.iter().position(|joint| joint == name);
        let order: Vec<Option<usize>> = match &own {
            Some(own) => own.iter().map(of_skeleton).collect(),
            None => (0..skeleton.joints.len()).map(Some).collect(),
        };
        let numbered = |(joint, weight): (&i64, &f64)| -> Answer<(usize, f64)> {
            // exporters fill up with joint 0 and weight 0, also without a joint
            if *weight <= 0.0 || !weight.is_finite() {
                return Ok((0, 0.0));
            }
            let known = usize::try_from(*joint).ok().and_then(|joint| *order.get(joint)?);
            let joint = known.ok_or_else(|| format!("it names joint {joint}, which is not there"))?;
            Ok((joint, *weight))
        };
        let pairs = joints.iter().zip(&weights).map(numbered).collect::<Answer<Vec<_>>>()?;
        let (joints, weights) = pairs.into_iter().unzip();
        let spread = said(prim.attribute(indices).get_metadata::<Value>("interpolation"))?;
        let is_rigid = matches!(spread, Some(Value::Token(word)) if word.as_str() == "constant");
        Ok(Some(Self { a_point, joints, weights, is_rigid }))
    }

    fn check(&self, points: usize) -> Answer<()> {
        let stated = self.joints.len() / self.a_point;
        if self.is_rigid || stated == points {
            return Ok(());
        }
        Err(format!("it has joints for {stated} points, and {points} points"))
    }

    /// Where a point is that was bound here. As in Pixar's library weights count as they are, whatever their sum is.
    fn moved(&self, pose: &[DAffine3], number: usize, bound: DVec3) -> DVec3 {
        let first = if self.is_rigid { 0 } else { number * self.a_point };
        let range = first..first + self.a_point;
        let pairs = self.joints[range.clone()].iter().zip(&self.weights[range]);
        let mut moved = pairs.filter(|(_, weight)| **weight > 0.0).peekable();
        // what nothing moves stays
        if moved.peek().is_none() {
            return bound;
        }
        moved.map(|(joint, weight)| pose[*joint].transform_point3(bound) * *weight).sum()
    }
}

/// Reads the blend shapes of a mesh that an animation moves.
fn blend_shapes(
    stage: &Stage,
    prim: &Prim,
    animated: &[String],
    code: f64,
    unused: &mut BTreeSet<String>,
) -> Answer<Vec<BlendShape>> {
    let names = value(prim, "skel:blendShapes", code)?.as_ref().and_then(words).unwrap_or_default();
    let mut read = Vec::new();
    for (name, target) in names.into_iter().zip(targets(prim, "skel:blendShapeTargets")?) {
        let Some(number) = animated.iter().position(|known| *known == name) else { continue };
        let shape = stage.prim(target);
        let properties = said(shape.property_names())?;
        if properties.iter().any(|name| name.as_str().starts_with("inbetweens:")) {
            unused.insert(String::from("shapes in between (inbetweens) of blend shapes are not used"));
        }
        let offsets = value(&shape, "offsets", code)?.as_ref().and_then(points).unwrap_or_default();
        let indices = value(&shape, "pointIndices", code)?.as_ref().and_then(whole_numbers);
        let places: Vec<usize> = match indices.filter(|indices| !indices.is_empty()) {
            Some(indices) => {
                indices.into_iter().map(|index| usize::try_from(index).unwrap_or(usize::MAX)).collect()
            }
            None => (0..offsets.len()).collect(),
        };
        let offsets = offsets.iter().map(|offset| Vec3::from(*offset).as_dvec3());
        read.push(BlendShape { number, offsets: places.into_iter().zip(offsets).collect() });
    }
    Ok(read)
}
