//! OBJ and MTL files that broke other loaders: each loads, or gives an error that a person can use.

use std::path::{Path, PathBuf};
use std::time::Instant;

use afterimage::scene::{self, Triangles};

use crate::collection;

fn files_of(folder: &Path, kind: &str, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_of(&path, kind, found);
        } else if path.extension().is_some_and(|extension| extension == kind) {
            found.push(path);
        }
    }
}

#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn every_material_file_is_read_or_says_why_not() {
    let folder = collection::folder("awkward");
    let mut files = Vec::new();
    files_of(&folder, "mtl", &mut files);
    assert!(files.len() > 80, "the collection is whole");
    let place = tempfile::tempdir().unwrap();
    let obj = place.path().join("x.obj");
    for path in &files {
        let text = format!("mtllib {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", path.display());
        std::fs::write(&obj, text).unwrap();
        match scene::load(&obj, false) {
            Ok(shot) => {
                let told = |w: &scene::Warning| w.0.path == *path || w.0.message.contains("Ka is 0");
                assert!(shot.warnings.iter().all(told), "{:?}", shot.warnings);
            }
            Err(error) => assert!(error.path == *path && error.line.is_some(), "{error}"),
        }
    }
}

#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn every_file_loads_or_says_why_not() {
    let folder = collection::folder("awkward");
    let mut files = Vec::new();
    files_of(&folder, "obj", &mut files);
    assert!(files.len() > 100, "the collection is whole");
    let mut loaded = 0;
    for path in &files {
        let start = Instant::now();
        match scene::load(path, false) {
            Ok(shot) => {
                loaded += 1;
                check(&shot.scene, path);
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.starts_with(&*folder.to_string_lossy()) && error.message.len() > 20, "{text}");
            }
        }
        assert!(start.elapsed().as_secs() < 10, "{} took too long", path.display());
    }
    assert!(loaded * 10 > files.len() * 8, "most files are only odd: {loaded} of {} loaded", files.len());
}

/// What the renderer takes for granted.
fn check(scene: &scene::Scene, path: &Path) {
    for model in &scene.models {
        let mesh = &model.mesh;
        let Triangles { positions, corners, normals, uvs, .. } = mesh.triangles();
        let positions = positions.as_slice();
        let vertices = positions.len();
        assert!(!corners.is_empty(), "{}", path.display());
        assert!(corners.iter().flatten().all(|i| (*i as usize) < vertices), "{}", path.display());
        assert!(positions.as_flattened().iter().all(|x| x.is_finite()), "{}", path.display());
        assert_eq!(mesh.material_of.len(), mesh.count());
        for count in [normals.len(), uvs.len()] {
            assert!(count == 0 || count == vertices, "{}", path.display());
        }
        assert!(normals.iter().all(|n| n.is_normalized() || n.length() == 0.0), "{}", path.display());
        assert!(uvs.iter().all(|uv| uv.is_finite()));
        for (i, material) in mesh.material_of.iter().enumerate() {
            let casts = scene.materials[*material as usize].casts_shadow();
            assert_eq!(casts, i < mesh.shadow_casting, "{}", path.display());
        }
    }
    let textures = scene.textures.len() as u32;
    assert!(scene.materials.iter().filter_map(|m| m.diffuse_map).all(|map| map < textures));
}
