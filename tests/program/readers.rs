//! Do other programs see every layer of our files, with its values? A variable names each program (CONTRIBUTING.md); without
//! it its tests are ignored.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::runs;
use crate::runs::Place;

/// Of the analytic shot.
const PIXELS: usize = 64 * 36;

/// Values by the whole names of their channels.
type Channels = BTreeMap<String, Vec<f32>>;

/// All parts of a file.
fn channels(path: &Path) -> Channels {
    let mut all = Channels::new();
    for part in 0..openexr::part_count(path).unwrap() {
        let mut planes: Vec<Vec<f32>> = Vec::new();
        let image = openexr::scan_part(path, part, |channel, values| {
            planes.resize(planes.len().max(channel + 1), Vec::new());
            planes[channel].extend_from_slice(values);
        });
        let names = image.unwrap().channels.into_iter().map(|channel| channel.name);
        all.extend(names.zip(planes));
    }
    all
}

/// A frame that has samples of every status but `base`, with all layers: in one part, and in a part for each.
fn frames(place: &Place) -> [(PathBuf, Channels); 2] {
    ["", "--multipart"].map(|format| frame(place, format))
}

fn frame(place: &Place, format: &str) -> (PathBuf, Channels) {
    let name = if format.is_empty() { "one" } else { "parts" };
    place.render(&format!("-o {name}.####.exr --frames 2 --layers all --mode reproject {format}")).done();
    let path = place.path(&format!("{name}.0002.exr"));
    let channels = channels(&path);
    assert!(channels.len() >= 55, "all of them: {:?}", channels.keys());
    (path, channels)
}

/// The program that `variable` names.
fn named(variable: &str) -> Command {
    Command::new(std::env::var(variable).unwrap_or_else(|_| panic!("{variable} names a program")))
}

/// What the program says on stdout.
fn said(command: &mut Command) -> Vec<u8> {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers").join(name)
}

/// What a program makes of the frame: it is given the frame and a folder for the one file that it writes.
fn made_by(place: &Place, command: &mut Command, path: &Path) -> Channels {
    let name = format!("read {}", path.file_stem().unwrap().to_string_lossy());
    let folder = place.path(&name);
    std::fs::create_dir(&folder).unwrap();
    let said = said(command.arg(path).arg(&folder));
    let [file] = &place.names(&name)[..] else { panic!("{}", String::from_utf8_lossy(&said)) };
    channels(&folder.join(file))
}

#[track_caller]
fn assert_same(name: &str, ours: &[f32], theirs: &[f32]) {
    assert_eq!(ours.len(), theirs.len(), "{name}");
    let off = ours.iter().zip(theirs).filter(|(ours, theirs)| ours != theirs).count();
    assert_eq!(off, 0, "{name}: values that differ");
}

/// The names that an output of Blender's Image node may have for one of our channels.
fn in_blender(name: &str, ours: &Channels) -> Vec<String> {
    match (name, name.split_once('.')) {
        // of a file in parts Blender 5 shows the parts' names
        ("Z", _) => vec!["Depth.V".to_owned(), "Z.V".to_owned()],
        (color, None) => vec![format!("Combined.{color}"), format!("rgba.{color}")],
        // vectors are colours for Blender 3, and Blender 5 names all of them alike
        (_, Some((layer, axis))) if axis != "V" || ours.contains_key(&format!("{layer}.U")) => {
            let is_uva = ours.contains_key(&format!("{layer}.U"));
            let alike = match axis {
                "X" => &["X", "R"][..],
                "Y" => &["Y", "G"],
                "Z" => &["Z", "B"],
                "W" => &["W", "A"],
                "U" => &["U", "X", "R"],
                "V" => &["V", "Y", "G"],
                // colours of Blender 3 have another alpha
                "A" if is_uva => &["B", "Z", "A"],
                _ => &[axis],
            };
            // those of Cryptomattes are written small
            let small = format!("{layer}.{}", axis.to_lowercase());
            alike.iter().map(|axis| format!("{layer}.{axis}")).chain([small]).collect()
        }
        _ => vec![name.to_owned()],
    }
}

/// All but those whose names begin with any of `lost`.
fn assert_blender_shows_all(ours: &Channels, theirs: &Channels, lost: &[&str]) {
    for (name, values) in ours.iter().filter(|(name, _)| !lost.iter().any(|lost| name.starts_with(lost))) {
        let known = in_blender(name, ours);
        let found = known.iter().find_map(|known| theirs.get(known));
        let found = found.unwrap_or_else(|| panic!("{name} is not in {:?}", theirs.keys()));
        assert_same(name, values, found);
    }
}

#[test]
#[cfg_attr(not(python_with_bpy), ignore = "needs Python with bpy 5: set AFTERIMAGE_BPY")]
fn blender_as_a_python_module_shows_every_layer() {
    let place = Place::new();
    for (path, ours) in frames(&place) {
        let theirs = made_by(&place, named("AFTERIMAGE_BPY").arg(script("blender.py")), &path);
        // the node that writes what the test sees writes three parts of a vector
        assert_blender_shows_all(&ours, &theirs, &["motion.W"]);
    }
}

#[test]
#[cfg_attr(not(blender), ignore = "needs Blender 3.4 or later: set AFTERIMAGE_BLENDER")]
fn blender_shows_every_layer() {
    let place = Place::new();
    for (path, ours) in frames(&place) {
        let mut blender = named("AFTERIMAGE_BLENDER");
        blender.args(["--background", "--factory-startup", "--python"]).arg(script("blender.py")).arg("--");
        let theirs = made_by(&place, &mut blender, &path);
        let is_old = theirs.contains_key("P.R");
        assert_blender_shows_all(&ours, &theirs, if is_old { &[] } else { &["motion.W"] });
    }
}

#[test]
#[cfg_attr(not(python_with_openimageio), ignore = "needs Python with OpenImageIO: set AFTERIMAGE_OIIO")]
fn openimageio_reads_every_channel() {
    let place = Place::new();
    for (path, ours) in frames(&place) {
        let theirs = made_by(&place, named("AFTERIMAGE_OIIO").arg(script("openimageio.py")), &path);
        assert!(theirs.keys().eq(ours.keys()), "{:?}", theirs.keys());
        ours.iter().for_each(|(name, values)| assert_same(name, values, &theirs[name]));
    }
}

#[test]
#[cfg_attr(
    not(python_with_openexr),
    ignore = "needs Python with OpenEXR 3.3 or later: set AFTERIMAGE_PYTHON"
)]
fn python_reads_every_channel() {
    let place = Place::new();
    for (path, ours) in frames(&place) {
        let mut python = named("AFTERIMAGE_PYTHON");
        let text = said(python.arg(script("openexr.py")).arg(&path));
        assert_python_said(&String::from_utf8(text).unwrap(), &path, &ours);
    }
}

fn assert_python_said(text: &str, path: &Path, ours: &Channels) {
    assert_eq!(text.lines().count(), ours.len());
    let parts =
        (0..openexr::part_count(path).unwrap()).map(|part| openexr::read_header_of(path, part).unwrap());
    let stored: Vec<_> = parts.flat_map(|part| part.channels).collect();
    for line in text.lines() {
        let [name, kind, width, sum] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let channel = stored.iter().find(|channel| channel.name == name).unwrap();
        let is_half = channel.stored == openexr::SampleType::Half;
        assert_eq!((kind, width), (if is_half { "float16" } else { "float32" }, "64"), "{name}");
        let expected: f64 = ours[name].iter().map(|value| f64::from(*value)).sum();
        let sum: f64 = sum.parse().unwrap();
        assert!((sum - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{name}: {sum}, not {expected}");
    }
}

/// A frame of two eyes, in one part and in a part for each layer and eye: what an eye sees, by the names that its channels have in a
/// file of its own.
fn frames_of_eyes(place: &Place) -> [(PathBuf, [Channels; 2]); 2] {
    ["", "--multipart"].map(|format| {
        let name = if format.is_empty() { "eyes" } else { "parts of eyes" };
        let options =
            format!("--separation 0.3 --convergence 6 --frames 2 --layers all --mode reproject {format}");
        let mut command = place.command(runs::analytic(), &options);
        let path = place.path(&format!("{name}.exr"));
        runs::Ran::new(command.arg("-o").arg(&path).output().unwrap()).done();
        let path = place.path(&format!("{name}.0002.exr"));
        let eyes = ["left", "right"].map(|eye| seen_by(&path, eye));
        assert!(
            eyes.iter().all(|seen| seen.len() >= 55 && seen.len() == eyes[0].len()),
            "{:?}",
            eyes[1].keys()
        );
        (path, eyes)
    })
}

fn seen_by(path: &Path, eye: &str) -> Channels {
    let mut seen = Channels::new();
    for part in 0..openexr::part_count(path).unwrap() {
        let mut planes: Vec<Vec<f32>> =
            vec![Vec::new(); openexr::read_header_of(path, part).unwrap().channels.len()];
        let image =
            openexr::scan_part(path, part, |channel, values| planes[channel].extend_from_slice(values));
        let image = image.unwrap();
        let view = match image.attribute("view") {
            Some(openexr::Attribute::Text(view)) => Some(view.clone()),
            _ => None,
        };
        for (channel, plane) in image.channels.iter().zip(planes) {
            let name = match &view {
                Some(view) => (view == eye).then(|| channel.name.clone()),
                None => name_seen_by(eye, &channel.name),
            };
            seen.extend(name.map(|name| (name, plane)));
        }
    }
    seen
}

/// What a channel of a file of both views is called in a file of this eye alone, if it is one of its.
fn name_seen_by(eye: &str, name: &str) -> Option<String> {
    match name.split('.').collect::<Vec<_>>()[..] {
        [letter] => (eye == "left").then(|| letter.to_owned()),
        [view, letter] => (view == eye).then(|| letter.to_owned()),
        [layer, view, letter] => (view == eye).then(|| format!("{layer}.{letter}")),
        _ => None,
    }
}

#[test]
#[cfg_attr(not(python_with_bpy), ignore = "needs Python with bpy 5: set AFTERIMAGE_BPY")]
fn blender_shows_layers_of_both_eyes() {
    let place = Place::new();
    // of files of several views in parts Blender 5.0 leaves two layers out, whichever it lists last
    let lost: [&[&str]; 2] = [&["motion.W"], &["motion.W", "N.", "CryptoGroup00."]];
    for ((path, eyes), lost) in frames_of_eyes(&place).into_iter().zip(lost) {
        for (eye, ours) in ["left", "right"].into_iter().zip(eyes) {
            let theirs = made_by(&place, named("AFTERIMAGE_BPY").arg(script("blender.py")).arg(eye), &path);
            assert_blender_shows_all(&ours, &theirs, lost);
            std::fs::remove_dir_all(place.path(&format!("read {}", path.file_stem().unwrap().display())))
                .unwrap();
        }
    }
}

#[test]
#[cfg_attr(not(python_with_openimageio), ignore = "needs Python with OpenImageIO: set AFTERIMAGE_OIIO")]
fn openimageio_reads_both_eyes() {
    let place = Place::new();
    let [(one, [left, right]), (parts, eyes)] = frames_of_eyes(&place);
    let read = |path| made_by(&place, named("AFTERIMAGE_OIIO").arg(script("openimageio.py")), path);
    let theirs = read(&one);
    assert_eq!(theirs.len(), left.len() + right.len());
    for (name, values) in &theirs {
        let eye = if name_seen_by("left", name).is_some() { "left" } else { "right" };
        let ours = if eye == "left" { &left } else { &right };
        assert_same(name, &ours[&name_seen_by(eye, name).unwrap()], values);
    }
    let theirs = read(&parts);
    for (eye, ours) in ["left", "right"].into_iter().zip(eyes) {
        ours.iter().for_each(|(name, values)| assert_same(name, values, &theirs[&format!("{eye}.{name}")]));
    }
}

#[test]
#[cfg_attr(
    not(python_with_openexr),
    ignore = "needs Python with OpenEXR 3.3 or later: set AFTERIMAGE_PYTHON"
)]
fn python_reads_both_eyes() {
    let place = Place::new();
    for (number, (path, [left, right])) in frames_of_eyes(&place).into_iter().enumerate() {
        let text = said(named("AFTERIMAGE_PYTHON").arg(script("openexr.py")).arg(&path));
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text.lines().count(), left.len() + right.len());
        for line in text.lines() {
            let [name, _, width, sum] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
            let own = |eye: &str| match number {
                0 => name_seen_by(eye, name),
                _ => name.strip_prefix(&format!("{eye}.")).map(str::to_owned),
            };
            let ours =
                own("left").map(|name| &left[&name]).or_else(|| own("right").map(|name| &right[&name]));
            let expected: f64 = ours.unwrap().iter().map(|value| f64::from(*value)).sum();
            let sum: f64 = sum.parse().unwrap();
            assert_eq!(width, "64");
            assert!(
                (sum - expected).abs() <= 1e-9 * expected.abs().max(1.0),
                "{name}: {sum}, not {expected}"
            );
        }
    }
}

/// The models of the analytic shot: a decoder finds mattes by the header, and what it makes of them is told by sums.
#[test]
#[cfg_attr(
    not(python_with_cryptomatte),
    ignore = "needs Python with cryptomatte-api: set AFTERIMAGE_CRYPTOMATTE"
)]
fn an_independent_decoder_finds_every_matte() {
    let place = Place::new();
    // of files in parts this decoder reads the first alone
    let (path, ours) = frame(&place, "");
    let mut python = named("AFTERIMAGE_CRYPTOMATTE");
    let text = String::from_utf8(said(python.arg(script("cryptomatte.py")).arg(&path))).unwrap();
    let mut sums: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for line in text.lines() {
        let [layer, name, sum, moment] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let [sum, moment] = [sum, moment].map(|number| number.parse::<f64>().unwrap());
        let of_layer = sums.entry(layer).or_default();
        *of_layer = [of_layer[0] + sum, of_layer[1] + moment];
        assert!(layer != "CryptoObject" || name == "background" || sum > 0.0, "{name} is seen");
    }
    let weighted = |(pixel, alpha): (usize, &f32)| f64::from(*alpha) * pixel as f64;
    let alpha = [
        ours["A"].iter().map(|alpha| f64::from(*alpha)).sum::<f64>(),
        ours["A"].iter().enumerate().map(weighted).sum::<f64>(),
    ];
    assert_eq!(sums.keys().copied().collect::<Vec<_>>(), ["CryptoGroup", "CryptoMaterial", "CryptoObject"]);
    for (layer, sums) in sums {
        let off = [0, 1].map(|number| (sums[number] / alpha[number] - 1.0).abs());
        assert!(off.iter().all(|off| *off < 1e-4), "{layer}: {sums:?}, not {alpha:?}");
    }
}

/// What Blender's Cryptomatte node makes of a model and of a material is what the ranks of the file say.
#[test]
#[cfg_attr(not(python_with_bpy), ignore = "needs Python with bpy 5: set AFTERIMAGE_BPY")]
fn blender_makes_mattes() {
    let place = Place::new();
    let (path, ours) = frame(&place, "");
    let header = openexr::read_header(&path).unwrap();
    let manifest = |layer: &str| -> BTreeMap<String, String> {
        let text = |name: &str| match header.attribute(name) {
            Some(openexr::Attribute::Text(text)) => text.clone(),
            other => panic!("{name}: {other:?}"),
        };
        let names = header.attributes.iter().map(|(name, _)| name.as_str());
        let key = names.filter(|name| name.ends_with("/name")).find(|name| text(name) == layer).unwrap();
        serde_json::from_str(&text(&key.replace("/name", "/manifest"))).unwrap()
    };
    for layer in ["CryptoObject", "CryptoMaterial"] {
        let (name, digits) = manifest(layer).into_iter().find(|(name, _)| name != "background").unwrap();
        let id = u32::from_str_radix(&digits, 16).unwrap();
        let mut matte = vec![0.0; PIXELS];
        for (part, [ids, shares]) in (0..6).map(|rank| (rank / 2, [["R", "G"], ["B", "A"]][rank % 2])) {
            let channel = |letter: &str| &ours[&format!("{layer}0{part}.{letter}")];
            let pixels = matte.iter_mut().zip(channel(ids)).zip(channel(shares));
            pixels.filter(|((_, own), _)| own.to_bits() == id).for_each(|((sum, _), share)| *sum += share);
        }
        assert!(matte.iter().any(|share| *share > 0.0), "{name} is seen");
        let mut blender = named("AFTERIMAGE_BPY");
        let theirs =
            made_by(&place, blender.arg(script("blender_cryptomatte.py")).args([layer, &name]), &path);
        assert_same(&name, &matte, &theirs["Matte.V"]);
        std::fs::remove_dir_all(place.path("read one.0002")).unwrap();
    }
}

/// FFmpeg knows pictures: the main one, and layers of three channels.
#[test]
#[cfg_attr(not(ffmpeg), ignore = "needs FFmpeg: set AFTERIMAGE_FFMPEG")]
fn ffmpeg_reads_every_layer_of_three_channels() {
    let place = Place::new();
    let (path, ours) = frame(&place, "");
    let layers = ours.keys().filter_map(|name| name.strip_suffix(".R"));
    // those of Cryptomattes have four
    let layers: Vec<&str> = layers.filter(|layer| !ours.contains_key(&format!("{layer}.A"))).collect();
    assert!(layers.len() >= 10, "{layers:?}");
    let vectors = ["N", "P", "denoise_normal"].map(|layer| (layer, ["X", "Y", "Z"], "gbrpf32le"));
    let colors = layers.into_iter().map(|layer| (layer, ["R", "G", "B"], "gbrpf32le"));
    for (layer, channels, format) in colors.chain(vectors).chain([("", ["R", "G", "B"], "gbrapf32le")]) {
        let mut ffmpeg = named("AFTERIMAGE_FFMPEG");
        ffmpeg.args(["-v", "error", "-layer", layer, "-i"]).arg(&path);
        let bytes = said(ffmpeg.args(["-f", "rawvideo", "-pix_fmt", format, "-"]));
        let values: Vec<f32> =
            bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
        // in its order: green, blue, red
        for (channel, values) in [1, 2, 0].into_iter().zip(values.chunks(PIXELS)) {
            let name = [layer, channels[channel]].join(if layer.is_empty() { "" } else { "." });
            assert_same(&name, &ours[&name], values);
        }
    }
}

/// ImageMagick knows the main picture alone, and Debian's has whole numbers of 16 bits.
#[test]
#[cfg_attr(not(imagemagick), ignore = "needs ImageMagick with OpenEXR: set AFTERIMAGE_CONVERT")]
fn imagemagick_reads_the_picture() {
    let place = Place::new();
    for (path, ours) in frames(&place) {
        let mut convert = named("AFTERIMAGE_CONVERT");
        // the values as they are: without this it would encode them for a screen
        convert.arg(&path).args(["-set", "colorspace", "sRGB", "-depth", "16", "-endian", "LSB", "rgba:-"]);
        let bytes = said(&mut convert);
        assert_eq!(bytes.len(), PIXELS * 8);
        for (place, bytes) in bytes.chunks_exact(2).enumerate() {
            let value = f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0;
            let name = ["R", "G", "B", "A"][place % 4];
            let wanted = ours[name][place / 4].clamp(0.0, 1.0);
            assert!((value - wanted).abs() < 1e-5, "{name} of pixel {}: {value}, not {wanted}", place / 4);
        }
    }
}
