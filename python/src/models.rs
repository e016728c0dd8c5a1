//! Models of what a program says of them.

use std::sync::Arc;

use afterimage::scene::given::GivenModel;
use afterimage::scene::{LightLinks, Linked, ModelNames, RayKind, RayVisibility, Role};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::errors::error;
use crate::motion;

/// What is said of a model's part in links of lights: groups, light_link, shadow_link.
pub type Links<'a, 'py> =
    (Option<Vec<String>>, Option<&'a Bound<'py, PyDict>>, Option<&'a Bound<'py, PyDict>>);

/// A model of the mesh 0.
pub fn model(
    name: String,
    transform: Option<&Bound<'_, PyAny>>,
    visible: Option<&Bound<'_, PyAny>>,
    (hidden_from, is_holdout, is_catcher): (Option<Vec<String>>, bool, bool),
    links: Links<'_, '_>,
) -> PyResult<GivenModel> {
    let places = motion::places(transform, &format!("transform of `{name}`"))?;
    let (is_visible, visible) =
        visible.map_or(Ok((true, Vec::new())), |visible| motion::visible(visible, &name))?;
    let hidden_from = hidden_from.unwrap_or_default();
    let hidden_from = hidden_from.iter().map(|kind| ray_kind(kind, &name)).collect::<PyResult<_>>()?;
    let role = match (is_holdout, is_catcher) {
        (true, true) => {
            return Err(error(format!("`{name}`: `holdout` and `shadow_catcher` exclude each other")));
        }
        (true, false) => Role::Holdout,
        (false, true) => Role::ShadowCatcher,
        (false, false) => Role::Itself,
    };
    let ray_visibility = RayVisibility { hidden_from, role };
    let linked = linked(&name, links)?;
    Ok(GivenModel { name, mesh: 0, places, is_visible, visible, ray_visibility, linked })
}

/// What links of lights know of a model. Names are compared with those of the scene when it is rendered.
fn linked(of: &str, (groups, light_link, shadow_link): Links<'_, '_>) -> PyResult<Linked> {
    let names = |key: &str, link: Option<&Bound<'_, PyDict>>| -> PyResult<ModelNames> {
        let mut names = ModelNames::default();
        for (part, value) in link.into_iter().flatten() {
            let list = || value.extract::<Vec<String>>().ok().filter(|_| !value.is_instance_of::<PyString>());
            let part = part.extract::<String>().unwrap_or_default();
            match (part.as_str(), list()) {
                ("include", Some(list)) => names.include = Some(list),
                ("exclude", Some(list)) => names.exclude = list,
                _ => {
                    let message = "must be a dict with `include`, `exclude` or both: lists of names";
                    return Err(error(format!("`{key}` of `{of}` {message}")));
                }
            }
        }
        Ok(names)
    };
    let links = LightLinks {
        receivers: names("light_link", light_link)?,
        blockers: names("shadow_link", shadow_link)?,
    };
    let emission = (links != LightLinks::default()).then(|| Arc::new(links));
    Ok(Linked { groups: groups.unwrap_or_default().into(), emission, light_group: None })
}

/// Kind of rays of this name.
fn ray_kind(name: &str, of: &str) -> PyResult<RayKind> {
    let names = RayKind::ALL.map(RayKind::name).join("`, `");
    RayKind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        error(format!("`hidden_from` of `{of}`: there are no rays `{name}`; kinds are `{names}`"))
    })
}
