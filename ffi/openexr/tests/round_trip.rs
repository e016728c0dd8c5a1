//! Does a file hold what was given to the writer, and do others read it?

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs::File;
use std::path::Path;
use std::process::Command;

use openexr::{Attribute, Channel, Compression, Data, Error, Image, Placed, SampleType, read};
use tempfile::tempdir;

const WIDTH: u32 = 37;
const HEIGHT: u32 = 45; // no multiple of 16 or 32: the last chunk is short

/// Values that a half holds exactly.
fn exact_halves() -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(|index| (index % 2048) as f32 * 0.25 - 100.0).collect()
}

/// Values that need all 24 bits of a float, and do not compress.
fn noise() -> Vec<f32> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 * 1.2345e-3
    };
    (0..WIDTH * HEIGHT).map(|_| next()).collect()
}

fn numbers() -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(|index| (index * 1000) as f32).collect()
}

/// Writes to a new file.
fn write(path: &Path, image: &Image<'_>) -> Result<(), Error> {
    openexr::write(&File::create(path).unwrap(), path, image)
}

fn image<'a>(channels: Vec<Channel<'a>>, compression: Compression) -> Image<'a> {
    Image { width: WIDTH, height: HEIGHT, placed: None, channels, attributes: Vec::new(), compression }
}

#[test]
fn halves_in_memory_come_back_whatever_they_are_stored_as() {
    use half::f16;
    let halves: Vec<f16> = exact_halves().into_iter().map(f16::from_f32).collect();
    let folder = tempdir().unwrap();
    let path = folder.path().join("halves.exr");
    let data = Data::Halves(&halves);
    let channels = vec![
        Channel { name: "as float", stored: SampleType::Float, data },
        Channel { name: "as half", stored: SampleType::Half, data },
    ];
    write(&path, &image(channels, Compression::Zips)).unwrap();
    let back = read(&path).unwrap();
    assert!(back.channels.iter().all(|channel| channel.data == exact_halves()));
    let mut spoilt = halves.clone();
    spoilt[WIDTH as usize + 3] = f16::NAN;
    let channels = vec![Channel { name: "R", stored: SampleType::Half, data: Data::Halves(&spoilt) }];
    let text = write(&path, &image(channels, Compression::Zips)).unwrap_err().to_string();
    assert!(text.contains("\"R\"") && text.contains("(3, 1)"), "{text}");
}

#[test]
fn planes_of_all_types_come_back_with_every_compression() {
    let (half, float, uint) = (exact_halves(), noise(), numbers());
    let folder = tempdir().unwrap();
    let methods = [Compression::None, Compression::Zips, Compression::Zip, Compression::Piz];
    for compression in methods {
        let path = folder.path().join(format!("{compression:?}.exr"));
        let channels = vec![
            Channel { name: "object.V", stored: SampleType::Uint, data: Data::Floats(&uint) },
            Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&half) },
            Channel { name: "P.X", stored: SampleType::Float, data: Data::Floats(&float) },
        ];
        write(&path, &image(channels, compression)).unwrap();
        let back = read(&path).unwrap();
        assert_eq!((back.width, back.height), (WIDTH, HEIGHT));
        assert_eq!(back.compression, Some(compression));
        let names: Vec<&str> = back.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["P.X", "R", "object.V"], "sorted by name");
        let kinds: Vec<SampleType> = back.channels.iter().map(|channel| channel.stored).collect();
        assert_eq!(kinds, [SampleType::Float, SampleType::Half, SampleType::Uint]);
        assert!(back.channel("P.X").unwrap().data == float, "{compression:?}");
        assert!(back.channel("R").unwrap().data == half, "{compression:?}");
        assert!(back.channel("object.V").unwrap().data == uint, "{compression:?}");
    }
}

#[test]
fn a_part_for_each_layer_comes_back_with_every_compression() {
    let (half, float, uint) = (exact_halves(), noise(), numbers());
    let folder = tempdir().unwrap();
    for compression in [Compression::None, Compression::Zips, Compression::Zip, Compression::Piz] {
        let path = folder.path().join(format!("{compression:?}.exr"));
        let channel = |name, stored, data| Channel { name, stored, data: Data::Floats(data) };
        let channels = vec![
            channel("P.Y", SampleType::Float, &float),
            channel("Z", SampleType::Float, &float),
            channel("P.X", SampleType::Float, &half),
            channel("object.V", SampleType::Uint, &uint),
            channel("R", SampleType::Half, &half),
            channel("A", SampleType::Half, &half),
        ];
        let mut image = image(channels.clone(), compression);
        image.attributes = all_attributes();
        openexr::write_parts(&File::create(&path).unwrap(), &path, &image).unwrap();
        let mut names = Vec::new();
        for number in 0..openexr::part_count(&path).unwrap() {
            let mut planes = vec![Vec::new(); 2];
            let visit = |channel: usize, lines: &[f32]| planes[channel].extend_from_slice(lines);
            let part = openexr::scan_part(&path, number, visit).unwrap();
            let head = openexr::read_header_of(&path, number).unwrap();
            assert_eq!((&head.part_name, &head.channels), (&part.part_name, &part.channels));
            assert_eq!(part.compression, Some(compression));
            assert_eq!(part.attribute("timeCode"), Some(&all_attributes()[10].1));
            for (read, values) in part.channels.iter().zip(&planes) {
                let given = channels.iter().find(|channel| channel.name == read.name).unwrap();
                let Data::Floats(data) = given.data else { unreachable!("all are floats") };
                assert!(data == values, "{compression:?}, {}", read.name);
                assert_eq!(read.stored, given.stored);
                names.push(format!("{} {}", part.part_name, read.name));
            }
        }
        assert_eq!(names, ["rgba A", "rgba R", "P P.X", "P P.Y", "Z Z", "object object.V"]);
        assert!(openexr::read_header_of(&path, 4).is_err(), "there is no fifth part");
    }
}

#[test]
fn pixels_may_lie_anywhere_in_and_around_the_picture() {
    let folder = tempdir().unwrap();
    let (path, values) = (folder.path().join("part.exr"), exact_halves());
    let channels = || vec![Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&values) }];
    for compression in [Compression::None, Compression::Zips, Compression::Zip, Compression::Piz] {
        for (first, picture) in [([-7, -40], [64, 64]), ([1000, 500], [1920, 1080]), ([-2, 3], [1, 1])] {
            let image = Image { placed: Some(Placed { first, picture }), ..image(channels(), compression) };
            for write in [openexr::write, openexr::write_parts] {
                write(&File::create(&path).unwrap(), &path, &image).unwrap();
                let back = read(&path).unwrap();
                assert_eq!((back.origin, [back.width, back.height]), (first, [WIDTH, HEIGHT]));
                assert_eq!(back.display, [0, 0, picture[0] as i32 - 1, picture[1] as i32 - 1]);
                assert_eq!(back.channels[0].data, values, "{compression:?} {first:?}");
            }
        }
    }
    let impossible = [([i32::MAX, 0], [1, 1]), ([0, 0], [0, 1]), ([0, 0], [u32::MAX, 1])];
    for (first, picture) in impossible {
        let image = Image { placed: Some(Placed { first, picture }), ..image(channels(), Compression::Zips) };
        assert!(
            write(&path, &image).unwrap_err().to_string().contains("cannot lie"),
            "{first:?} {picture:?}"
        );
    }
}

#[test]
fn one_pixel_and_one_line_are_images() {
    let folder = tempdir().unwrap();
    for (width, height) in [(1, 1), (1, 7), (3, 1)] {
        let path = folder.path().join("small.exr");
        let data = vec![0.5; (width * height) as usize];
        let channels = vec![Channel { name: "Y", stored: SampleType::Half, data: Data::Floats(&data) }];
        let compression = Compression::Zips;
        let image = Image { width, height, placed: None, channels, attributes: Vec::new(), compression };
        write(&path, &image).unwrap();
        assert_eq!(read(&path).unwrap().channels[0].data, data);
    }
}

fn all_attributes() -> Vec<(String, Attribute)> {
    let mut matrix = [0.0; 16];
    matrix.iter_mut().enumerate().for_each(|(index, element)| *element = index as f32);
    [
        ("comments", Attribute::Text("Ä shot, and a line\nof it".into())),
        ("owner", Attribute::Text(String::new())),
        ("expTime", Attribute::Float(0.02)),
        ("imageCounter", Attribute::Int(-7)),
        ("framesPerSecond", Attribute::Rational { numerator: 24000, denominator: 1001 }),
        ("worldToCamera", Attribute::M44f(matrix)),
        ("adoptedNeutral", Attribute::V2f([0.3127, 0.329])),
        ("originalDataWindowSize", Attribute::V2i([3, -4])),
        ("sunDirection", Attribute::V3f([0.0, -1.0, 0.5])),
        ("chromaticities", Attribute::Chromaticities([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329])),
        ("timeCode", Attribute::TimeCode { time_and_flags: 0x0102_0304, user_data: 9 }),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

#[test]
fn attributes_come_back() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("attributes.exr");
    let data = exact_halves();
    let channels = vec![Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&data) }];
    let mut image = image(channels, Compression::Zips);
    image.attributes = all_attributes();
    write(&path, &image).unwrap();
    let back = read(&path).unwrap();
    for (name, value) in &image.attributes {
        assert_eq!(back.attribute(name), Some(value), "{name}");
    }
    assert_eq!(back.attributes.len(), image.attributes.len());
}

#[test]
fn values_beyond_the_largest_half_become_it() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("large.exr");
    let data = [65504.0, 65519.9, 65520.0, 1e30, -1e30, f32::MAX, -0.0, 1e-30];
    let channels = vec![
        Channel { name: "float", stored: SampleType::Float, data: Data::Floats(&data) },
        Channel { name: "half", stored: SampleType::Half, data: Data::Floats(&data) },
        Channel { name: "uint", stored: SampleType::Uint, data: Data::Floats(&data) },
    ];
    let (compression, attributes) = (Compression::Zips, Vec::new());
    write(&path, &Image { width: 8, height: 1, placed: None, channels, attributes, compression }).unwrap();
    let back = read(&path).unwrap();
    assert_eq!(back.channel("float").unwrap().data, data);
    let most = 65504.0;
    let halves = [most, most, most, most, -most, most, 0.0, 0.0];
    assert_eq!(back.channel("half").unwrap().data, halves);
    let largest = u32::MAX as f32;
    let numbers = [65504.0, 65520.0, 65520.0, largest, 0.0, largest, 0.0, 0.0];
    assert_eq!(back.channel("uint").unwrap().data, numbers);
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempdir().unwrap();
    let (half, float) = (exact_halves(), noise());
    let files: Vec<Vec<u8>> = [1, 3]
        .iter()
        .map(|&threads| {
            let path = folder.path().join(format!("{threads}.exr"));
            let channels = vec![
                Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&half) },
                Channel { name: "Z", stored: SampleType::Float, data: Data::Floats(&float) },
            ];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| write(&path, &image(channels, Compression::Zips))).unwrap();
            std::fs::read(&path).unwrap()
        })
        .collect();
    assert!(files[0] == files[1]);
}

#[test]
#[cfg_attr(not(openexr_tools), ignore = "needs exrheader and exrinfo: set AFTERIMAGE_OPENEXR_TOOLS")]
fn the_tools_of_openexr_accept_the_file() {
    let tools = std::env::var("AFTERIMAGE_OPENEXR_TOOLS").expect("it names a folder with OpenEXR's tools");
    let folder = tempdir().unwrap();
    let path = folder.path().join("tools.exr");
    let (half, float) = (exact_halves(), noise());
    let channels = vec![
        Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&half) },
        Channel { name: "P.X", stored: SampleType::Float, data: Data::Floats(&float) },
    ];
    let mut image = image(channels, Compression::Zips);
    image.attributes = all_attributes();
    write(&path, &image).unwrap();
    for (tool, options) in [("exrheader", &[][..]), ("exrinfo", &["-v", "-s"][..])] {
        let output = Command::new(Path::new(&tools).join(tool)).args(options).arg(&path).output();
        let output = output.unwrap_or_else(|error| panic!("{tool} in {tools}: {error}"));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && output.stderr.is_empty(), "{tool}: {output:?}");
        assert!(said.contains("P.X"), "{tool}: {said}");
    }
}
