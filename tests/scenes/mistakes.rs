//! Mistakes in shot files, and files that are missing or of another kind: is each told with its place and remedy?

use std::sync::Arc;

use afterimage::scene;

use crate::small_shot::*;

/// Every key of docs/shot-files.md that takes a list of numbers, each on a line of its own with a good value.
const LISTS: &str = "[render]
size = [64, 48]
[background]
zenith = [0, 0, 1]
horizon = [1, 1, 1]
ground = [1, 1, 1]
[environment.sky]
ground = [1, 1, 1]
[ambient]
color = [0, 0, 0]
[[camera.key]]
frame = 1
eye = [0, 0, 5]
shift = [0, 1]
target = [0, 0, 0]
[[model]]
obj = \"m.obj\"
scale = [1, 2, 3]
rotate = [0, 0, 0]
translate = [0, 0, 0]
[[model.key]]
frame = 1
translate = [0, 0, 0]
rotate = [0, 0, 0]
scale = [1, 2, 3]
[[light]]
type = \"rectangle\"
position = [0, 9, 0]
target = [0, 0, 0]
up = [1, 0, 0]
size = [1, 1]
color = [1, 1, 1]
[[light.key]]
frame = 1
position = [0, 9, 0]
target = [0, 0, 0]
up = [1, 0, 0]
color = [1, 1, 1]
[[light]]
type = \"directional\"
direction = [0, -1, 0]
[[light.key]]
frame = 1
direction = [0, -1, 0]
[[material]]
name = \"wood\"
kd = [1, 1, 1]
ka = [1, 1, 1]
ks = [1, 1, 1]
ke = [1, 1, 1]
tf = [1, 1, 1]
";

#[test]
fn lists_have_as_many_numbers_as_they_must() {
    load(LISTS);
    let color = LISTS.replace("zenith = [0, 0, 1]\nhorizon = [1, 1, 1]\nground", "color");
    let rotation = LISTS.replace("target = [0, 0, 0]\n[[model]]", "rotation = [0, 0, 0]\n[[model]]");
    let mut tried = 0;
    for text in [LISTS, &color, &rotation] {
        load(text);
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let Some((key, list)) = line.split_once(" = [") else { continue };
            let count = list.split(',').count();
            let longer = list.replace(']', ", 99]");
            let shorter = list.rsplit_once(',').map_or(String::from("]"), |(begin, _)| format!("{begin}]"));
            for (wrong, length) in [(longer.as_str(), count + 1), (&shorter, count - 1), ("]", 0)] {
                let wrong = format!("{key} = [{wrong}");
                let text = [&lines[..at], &[wrong.as_str()], &lines[at + 1..]].concat().join("\n");
                let place = format!("s.toml:{}:{}: `{key}`: ", at + 1, key.len() + 4);
                let expected = format!("{place}invalid length {length}, expected a list of {count} numbers");
                assert!(error(&text).starts_with(&expected), "{wrong}: {}", error(&text));
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 3 * (31 + 29 + 31), "every list of the three shots");
}

#[test]
fn mistakes_are_told_with_place_and_remedy() {
    let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\n";
    let orbit = "[[camera.key]]\nframe = 1\ntarget = [0, 0, 0]\n";
    let light = format!("{REST}[[light]]\n");
    let orthographic = format!("[camera]\nprojection = \"orthographic\"\n{camera}");
    // falls steeply, and then no more: a smooth curve goes below
    let heights = [(1, 100.0), (11, 0.1), (40, 0.1)].map(|(frame, height)| {
        let key = camera.replace("frame = 1", &format!("frame = {frame}"));
        format!("{key}target = [0, 0, 0]\nheight = {height}\n")
    });
    let overshooting =
        format!("[camera]\nprojection = \"orthographic\"\ninterpolation = \"smooth\"\n{}", heights.concat());
    for (text, expected) in [
        ("[render]\nsise = [1, 2]\n".into(), "s.toml:2:1: unknown key `sise`: did you mean `size`?"),
        (
            "[render]\nsize = [0, 2]\n".into(),
            "s.toml:2:9: `size` is 0: it must be a whole number from 1 to 65535",
        ),
        ("[render]\nsize = [8, \"a\"]\n".into(), "s.toml:2:12: `size`: invalid type: string"),
        ("[render]\nsamples = 17\n".into(), "s.toml:2:11: `samples` is 17"),
        ("[render]\noverscan = -1\n".into(), "s.toml:2:12: `overscan` is -1"),
        ("[render]\noverscan = 16385\n".into(), "s.toml:2:12: `overscan` is 16385"),
        ("[render]\noverscan = 2.5\n".into(), "s.toml:2:12: `overscan`: invalid type"),
        (
            "[render]\nsize = [65000, 1]\noverscan = 300\n".into(),
            "s.toml:3:12: `overscan` makes a picture of 65000x1 longer than 65535 pixels on a side",
        ),
        (
            "[indirect]\npaths = -1\n".into(),
            "s.toml:2:9: `paths` is -1: it must be a whole number from 0 to 1024",
        ),
        ("[indirect]\npaths = 1025\n".into(), "s.toml:2:9: `paths` is 1025"),
        (
            "[occlusion]\nradius = 0\n".into(),
            "s.toml:2:10: `radius` is 0: it must be a length above 0, in the units of the models",
        ),
        ("[occlusion]\nradius = -0.5\n".into(), "s.toml:2:10: `radius` is -0.5: it must be a length above 0"),
        ("[occlusion]\nradius = nan\n".into(), "s.toml:2:10: `radius` is NaN: it must be a length above 0"),
        ("[occlusion]\nradius = inf\n".into(), "s.toml:2:10: `radius` is inf: it must be a length above 0"),
        (
            "[occlusion]\nrays = 0\n".into(),
            "s.toml:2:8: `rays` is 0: it must be a whole number from 1 to 256",
        ),
        (
            "[occlusion]\nrays = 257\n".into(),
            "s.toml:2:8: `rays` is 257: it must be a whole number from 1 to 256",
        ),
        (
            "[render]\nreflections = 65\n".into(),
            "s.toml:2:15: `reflections` is 65: it must be a whole number from 0 to 64",
        ),
        ("[render]\nclamp = 0\n".into(), "s.toml:2:9: `clamp` is 0: it must be a radiance above 0"),
        ("[render]\nclamp = 1e-60\n".into(), "s.toml:2:9: `clamp` is 0."),
        ("[render]\nclamp = inf\n".into(), "s.toml:2:9: `clamp` is inf: it must be a radiance above 0"),
        (
            "[render]\ntree_memory = -1\n".into(),
            "s.toml:2:15: `tree_memory` is -1: it must be a whole number from 0 to 1048576",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\npr = 1.5\n"),
            "s.toml:9:6: `pr` is 1.5: it must be from 0 (smooth) to 1 (rough)",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\npm = nan\n"),
            "s.toml:9:6: `pm` is NaN: it must be from 0 (no metal) to 1 (metal)",
        ),
        ("[indirect]\nbounces = 65\n".into(), "s.toml:2:11: `bounces` is 65"),
        (
            "[indirect]\nbudget = \"half\"\n".into(),
            "s.toml:2:10: `budget` must be `full`, or a number of rays",
        ),
        (
            "[indirect]\nbudget = -1\n".into(),
            "s.toml:2:10: `budget`: it must be `full`, or a number of rays a frame",
        ),
        ("[indirect]\npaths_per_frame = 0\n".into(), "s.toml:2:19: `paths_per_frame`"),
        ("[indirect]\nbounce = 1\n".into(), "s.toml:2:1: unknown key `bounce`: did you mean `bounces`?"),
        ("[render]\nframes = \"9-1\"\n".into(), "s.toml:2:10: `frames`: `9-1` runs backwards"),
        ("[render]\nrate = \"24/0\"\n".into(), "s.toml:2:8: `rate` must be frames per second"),
        ("[render]\nrate = 23.976\n".into(), "s.toml:2:8: `rate`: invalid type: floating point"),
        (
            "[render]\nmode = \"ful\"\n".into(),
            "s.toml:2:8: `mode`: unknown value `ful`: did you mean `full`?",
        ),
        ("[render\n".into(), "s.toml:1:8: "),
        (String::new(), "s.toml: there is no [camera]"),
        ("[camera]\n".into(), "s.toml:1:1: the camera has no keys"),
        (
            "[[camera.key]]\nframe = 1\ntarget = [0, 0, 0]\n".into(),
            "s.toml:1:1: this camera key needs `eye`, or `orbit`",
        ),
        (format!("{orbit}orbit = [0, 91, 2]\n"), "s.toml:4:9: `orbit` is azimuth, elevation (-90 to 90)"),
        (format!("{orbit}orbit = [0, 0, 0]\n"), "s.toml:4:9: `orbit` is azimuth, elevation (-90 to 90)"),
        (
            format!("{orbit}orbit = [0, 0, 2]\neye = [0, 0, 5]\n"),
            "s.toml:5:7: `eye` and `orbit` exclude each other",
        ),
        (
            format!("{orbit}orbit = [0, 0, 2]\n{camera}target = [0, 0, 0]\n").replacen(
                "frame = 1",
                "frame = 2",
                1,
            ),
            "s.toml:6:9: the keys of a camera have either all `eye` or all `orbit`",
        ),
        (
            orbit.replace("target", "rotation") + "orbit = [0, 0, 2]\n",
            "s.toml:4:9: `orbit` goes around the key's `target`",
        ),
        (format!("{REST}[floor]\nheight = inf\n"), "s.toml:8:10: `height` is inf: it must be from -1e18"),
        (format!("{REST}[floor]\nradius = 0\n"), "s.toml:8:10: `radius` is 0: it must be a length above 0"),
        (format!("{REST}[floor]\ncolor = [0, 2, 0]\n"), "s.toml:8:9: `color` is a reflectance"),
        (camera.to_string(), "s.toml:2:9: this camera key needs `target`"),
        (format!("{camera}target = [0, 0, 5]\n"), "s.toml:3:7: `eye` and `target` are the same point"),
        (format!("{camera}target = [0, 0, nan]\n"), "s.toml:4:10: `target` must be three finite numbers"),
        (format!("{camera}target = [0, 0]\n"), "s.toml:4:10: `target`: invalid length 2"),
        (format!("{camera}rotation = [0, 0, 0]\nroll = 1\n"), "s.toml:5:8: `roll` goes with `target`"),
        ("[camera]\nprojection = \"fisheye\"\n".into(), "s.toml:2:14: `projection`: unknown value `fisheye`"),
        (
            format!("{camera}target = [0, 0, 0]\nheight = 2\n"),
            "s.toml:5:10: `height` goes with `projection = \"orthographic\"`",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\n"),
            "s.toml:4:9: this key of an orthographic camera needs `height`",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\nheight = 2\nfov = 9\n"),
            "s.toml:8:7: `fov` goes with a perspective camera",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\nheight = 0\n"),
            "s.toml:7:10: `height` is 0: it must be from 1e-18 to 1e18",
        ),
        (format!("{orthographic}target = [0, 0, 0]\nheight = nan\n"), "s.toml:7:10: `height` is NaN"),
        (format!("{orthographic}target = [0, 0, 0]\nheight = 1e19\n"), "s.toml:7:10: `height` is"),
        (
            format!("{camera}target = [0, 0, 0]\nshift = [0, nan]\n"),
            "s.toml:5:9: `shift` must be two numbers from -100 to 100",
        ),
        (
            format!("{camera}target = [0, 0, 0]\nshift = [101, 0]\n"),
            "s.toml:5:9: `shift` must be two numbers",
        ),
        (format!("{camera}target = [0, 0, 0]\nshift = 1\n"), "s.toml:5:9: `shift`: "),
        (overshooting, "s.toml:1:1: the smooth curve of `height` falls to 0 or below"),
        (
            format!("{camera}target = [0, 0, 0]\nfov = 180\n"),
            "s.toml:5:7: `fov` is 180: it must be from 1e-6 to below 180 degrees",
        ),
        (
            format!("{camera}target = [0, 0, 0]\n{camera}target = [0, 0, 0]\n"),
            "s.toml:6:9: `frame` is 1: there is another key at this frame already",
        ),
        (format!("{camera}target = [0, 0, 0]\n"), "s.toml: there is nothing to see"),
        (format!("{REST}scale = 0\n"), "s.toml:7:9: `scale` must not be zero"),
        (format!("{REST}scale = [1, 1]\n"), "s.toml:7:9: `scale`: invalid length 2"),
        (REST.replace("m.obj", "none.obj"), "s.toml:6:7: `obj`: there is no file `none.obj`"),
        (
            format!("{REST}[output]\nlayers = [\"Z\", \"far\"]\n"),
            "s.toml:8:16: `layers`: there is no layer `far`; there are diffuse",
        ),
        (
            format!("{REST}[output]\ncompression = \"dwaa\"\n"),
            "s.toml:8:15: `compression`: unknown value `dwaa`",
        ),
        (
            format!("{REST}[output]\nexposure = 21\n"),
            "s.toml:8:12: `exposure` is 21: it must be from -20 to 20 stops",
        ),
        (
            format!("{REST}[output]\ndenoise_quality = \"best\"\n"),
            "s.toml:8:19: `denoise_quality`: unknown value `best`",
        ),
        (format!("{light}type = \"point\"\n"), "s.toml:7:1: this light needs the key `position`"),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\ncone = 3\n"),
            "s.toml:10:8: a point light has no `cone`",
        ),
        (
            format!("{light}type = \"rectangle\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nsize = [1, 0]\n"),
            "s.toml:11:8: `size` must be two lengths",
        ),
        (
            format!(
                "{light}type = \"rectangle\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nup = [0, 0, 0]\n"
            ),
            "s.toml:11:6: `up` must not be zero",
        ),
        (
            format!("{light}type = \"disk\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nsoft = 0.5\n"),
            "s.toml:11:8: a disk light has no `soft`",
        ),
        (
            format!(
                "{light}type = \"disk\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nradius = 1\nsize = [1, 2]\n"
            ),
            "s.toml:12:8: `size` and `radius` exclude each other: keep one of them",
        ),
        (
            format!("{light}type = \"disk\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nspread = 0.5\n"),
            "s.toml:11:10: `spread` is 0.5: it must be from 1 to 180 degrees",
        ),
        (
            format!("{light}type = \"sphere\"\nposition = [0, 0, 0]\nspread = 90\n"),
            "s.toml:10:10: a sphere light has no `spread`",
        ),
        (
            format!("{light}type = \"sphere\"\nposition = [0, 0, 0]\nradius = 0\n"),
            "s.toml:10:10: `radius` is 0: it must be a length from 1e-9 to 1e9",
        ),
        (
            format!("{light}type = \"disk\"\nposition = [0, 0, 0]\ntarget = [0, 0, 0]\n"),
            "s.toml:7:1: `position` and `target` of this light are the same point",
        ),
        (
            format!("{light}type = \"directional\"\ndirection = [0, 0, 1]\nangle = 180\n"),
            "s.toml:10:9: `angle` is 180: it must be from 0 to below 180 degrees",
        ),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\nradius = 1\n"),
            "s.toml:10:10: a point light has no `radius`",
        ),
        (
            format!("{light}type = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nsize = [1, 1]\n"),
            "s.toml:11:8: a spot light has no `size`",
        ),
        (
            format!("{light}type = \"directional\"\ndirection = [0, 0, 0.0]\n"),
            "s.toml:9:13: `direction` must not be zero",
        ),
        (format!("{light}type = \"lamp\"\n"), "s.toml:8:8: `type`: unknown value `lamp`"),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\npower = -1\n"),
            "s.toml:10:9: `power` is -1: it must be finite, not negative, and 1e30 at most",
        ),
        (
            format!("{REST}[[material]]\nname = \"wod\"\n"),
            "s.toml:8:8: no model has a material `wod`: did you mean `wood`?",
        ),
        (format!("{REST}[[material]]\nname = \"wood\"\nkd = [-1, 0, 0]\n"), "s.toml:9:6: `kd` is a colour"),
        (
            format!("{REST}[[material]]\nname = \"wood\"\nkd = [1, 7e4, 0]\n"),
            "s.toml:9:6: `kd` is too large: 65504",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\ntf = [1, 1.5, 0]\n"),
            "s.toml:9:6: `tf` must have channels from 0",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\ntf = [1, 1, 1]\ntransmission = 0.5\n"),
            "s.toml:9:6: `tf` and `transmission` exclude each other",
        ),
        (format!("[background]\ncolor = [0, 0, 0]\nground = [0, 0, 0]\n{REST}"), "s.toml:2:9: `color` and"),
        (format!("[output]\npath = \"\"\n{REST}"), "s.toml:2:8: `path` is empty"),
        (
            format!("[environment]\npower = 1\n{REST}"),
            "s.toml:1:1: the environment needs `map` or `sky`: without them it is the [background]",
        ),
        (
            format!("[environment]\nsamples = 65\nsky = {{}}\n{REST}"),
            "s.toml:2:11: `samples` is 65: it must be",
        ),
        (format!("[environment]\nmpa = \"a\"\n{REST}"), "s.toml:2:1: unknown key `mpa`: did you mean `map`?"),
        (
            format!("[environment]\nmap = \"a.hdr\"\n{REST}"),
            "s.toml:2:7: `map`: there is no file `a.hdr` in ",
        ),
        (
            format!("[environment]\nmap = \"a.hdr\"\nsky = {{}}\n{REST}"),
            "s.toml:2:7: `map` and `sky` exclude each other",
        ),
        (format!("[environment]\nmap = 3\n{REST}"), "s.toml:2:7: `map`: invalid type"),
        (format!("[environment]\nsky = 3\n{REST}"), "s.toml:2:7: `sky`: invalid type"),
        (format!("[environment]\nsky = {{}}\nvisible = 1\n{REST}"), "s.toml:3:11: `visible`: invalid type"),
        (
            format!("[environment]\nsky = {{}}\npower = -1\n{REST}"),
            "s.toml:3:9: `power` is -1: it must be finite and not negative",
        ),
        (format!("[environment]\nsky = {{}}\npower = 1e39\n{REST}"), "s.toml:3:9: `power` is 1"),
        (
            format!("[environment]\nsky = {{}}\nrotation = inf\n{REST}"),
            "s.toml:3:12: `rotation` is inf: it must be finite",
        ),
        (
            format!("[environment]\nsky = {{}}\nrotation = \"a\"\n{REST}"),
            "s.toml:3:12: `rotation`: invalid type",
        ),
        (
            format!("[environment.sky]\nelevation = 91\n{REST}"),
            "s.toml:2:13: `elevation` is 91: it must be from -6 to 90 degrees",
        ),
        (
            format!("[environment.sky]\nturbidity = 1.5\n{REST}"),
            "s.toml:2:13: `turbidity` is 1.5: it must be from 2 to 10",
        ),
        (format!("[environment.sky]\nazimuth = nan\n{REST}"), "s.toml:2:11: `azimuth` is NaN"),
        (format!("[environment.sky]\nground = [0, 2, 0]\n{REST}"), "s.toml:2:10: `ground` is an albedo"),
        (format!("[environment.sky]\nground = [0, -1, 0]\n{REST}"), "s.toml:2:10: `ground` is a colour"),
        (
            format!("[environment.sky]\nturbidty = 3\n{REST}"),
            "s.toml:2:1: unknown key `turbidty`: did you mean `turbidity`?",
        ),
    ] {
        let message = error(&text);
        assert!(message.starts_with(expected), "for\n{text}\nexpected {expected}\ngot      {message}");
    }
}

#[test]
fn missing_files_are_stand_ins_or_strict_errors() {
    let (folder, lit) = (folder(), format!("[ambient]\ncolor = [1, 1, 1]\n{REST}"));
    std::fs::write(
        folder.path().join("m.mtl"),
        "newmtl wood\nmap_Kd a.png\nnewmtl clear\nmap_Kd -s 2 a.png\n",
    )
    .unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert_eq!(shot.warnings.len(), 1, "one a file: {:?}", shot.warnings);
    assert!(shot.warnings[0].to_string().contains("m.mtl:4: the texture `a.png` cannot be found"));
    let [first, second] = shot.scene.textures.as_slice() else { unreachable!("two ways to use the file") };
    assert!(Arc::ptr_eq(&first.image, &second.image));
    assert!(load_in(folder.path(), &lit, true).is_err());
    std::fs::write(folder.path().join("a.png"), "no picture").unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert!(shot.warnings[0].to_string().contains("cannot be read"), "{:?}", shot.warnings);
    std::fs::write(folder.path().join("a.png"), "#?RADIANCE\n\n-Y 1 +X 1\n\0\0\0\0").unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert!(shot.warnings.is_empty(), "{:?}", shot.warnings);
    std::fs::remove_file(folder.path().join("m.mtl")).unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert_eq!(shot.warnings.len(), 1, "{:?}", shot.warnings);
    assert!(shot.warnings[0].to_string().contains("m.obj:1: the material file `m.mtl` cannot be found"));
}

#[test]
fn other_files_are_refused() {
    let folder = folder();
    let message = |name: &str| scene::load(&folder.path().join(name), false).unwrap_err().to_string();
    assert!(message("m.mtl").contains("not a file that can be rendered"));
    assert!(message("none.obj").contains("none.obj: the OBJ file cannot be read"));
    assert!(message("none.toml").contains("none.toml: the shot file cannot be read"));
}

/// Models that were renamed with their materials name what was there before; some programs put names between quotes.
#[test]
fn the_material_file_beside_a_model_stands_in_for_one_that_is_not_there() {
    let folder = folder();
    for (line, told) in [
        ("mtllib gone.mtl", Some("m.obj:1: the material file `gone.mtl` cannot be found: `m.mtl` is read")),
        ("mtllib \"m.mtl\"", None),
        ("", Some("m.obj: it names no material file (mtllib): `m.mtl`, which is beside it, is read")),
        ("mtllib gone.mtl m.mtl", None),
    ] {
        std::fs::write(folder.path().join("m.obj"), OBJ.replace("mtllib m.mtl", line)).unwrap();
        let shot = load_in(folder.path(), REST, false).unwrap();
        let wood = shot.scene.materials.iter().find(|one| one.name == "wood").unwrap();
        assert_eq!(wood.diffuse, glam::Vec3::new(0.5, 0.25, 0.125), "{line}");
        if let Some(told) = told {
            let is_told = shot.warnings.iter().any(|warning| warning.to_string().contains(told));
            assert!(is_told, "{line}: {:?}", shot.warnings);
            assert!(load_in(folder.path(), REST, true).is_ok(), "the colours are there");
        }
    }
}

#[test]
fn links_to_nothing_are_mistakes() {
    let shot = |light: &str, model: &str| {
        format!(
            "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[[model]]\nname = \"hero\"\nobj = \"m.obj\"\n\
             groups = [\"cast\"]\n{model}\n[[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\n{light}\n"
        )
    };
    let fits = "light_link = { include = [\"hero\"] }\nshadow_link = { exclude = [\"cast\"] }";
    load(&shot("shadow_link = { include = [] }", ""));
    load(&shot(fits, "light_link = { exclude = [\"floor\"] }\n[floor]"));
    for (link, place, message) in [
        (
            "light_link = { include = [\"herro\"] }",
            "13:27",
            "`light_link` names `herro`, which is no model and no group of models: did you mean `hero`?",
        ),
        (
            "shadow_link = { exclude = [\"\"] }",
            "13:28",
            "`shadow_link` has an empty name: write that of a model or a group",
        ),
        (
            "light_link = { include = [] }",
            "13:26",
            "`include` of `light_link` is empty: nothing would be lit",
        ),
        (
            "light_link = {}",
            "13:14",
            "`light_link` names nothing: give it `include` or `exclude`, or take it out",
        ),
        (
            "light_link = { include = [\"cast\"], exclude = [\"hero\"] }",
            "13:14",
            "`light_link` means no model: all that it includes is excluded; take a name out of `exclude`",
        ),
        ("light_link = { exclude = [\"floor\"] }", "13:27", "`light_link` names `floor`, which is no model"),
    ] {
        let told = error(&shot(link, ""));
        assert!(told.contains(&format!("s.toml:{place}: {message}")), "{told}");
    }
    let told = error(&shot("", "shadow_link = { include = [\"hreo\"] }"));
    assert!(told.contains("s.toml:9:28: `shadow_link` names `hreo`"), "{told}");
}

/// Embree's masks have a bit for each set of models that cast shadows.
#[test]
fn too_many_sets_of_models_are_a_mistake() {
    let shot = |lights: usize| {
        let models = (0..17).map(|number| format!("[[model]]\nname = \"{number}\"\nobj = \"m.obj\"\n"));
        let lights = (0..lights).map(|number| {
            format!(
                "[[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\nshadow_link = {{ exclude = [\"{number}\"] }}\n"
            )
        });
        let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
        camera.to_string() + &models.chain(lights).collect::<String>()
    };
    load(&shot(16));
    let told = error(&shot(17));
    assert!(told.contains("more than 16 different sets of models: let some lights have the same"), "{told}");
}
