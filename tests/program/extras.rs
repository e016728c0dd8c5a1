//! What becomes of a run's frames beside their files: contact sheets and movies.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use afterimage::output::look::on_screen;
use afterimage::output::png::srgb_byte;
use afterimage::settings::{Look, View};
use image::GenericImageView;

use crate::runs;
use crate::runs::{Place, Ran, analytic};

/// `render` of the analytic shot with a program called ffmpeg that packs nothing: it writes what it reads.
fn with_ffmpeg(place: &Place, options: &str) -> Ran {
    fs::create_dir_all(place.path("bin")).unwrap();
    let program = place.path("bin/ffmpeg");
    fs::write(&program, "#!/bin/sh\n[ \"$1\" = -version ] || exec cat\n").unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/usr/bin:/bin", place.path("bin").display());
    Ran::new(place.command(analytic(), options).env("PATH", path).output().unwrap())
}

#[test]
fn all_frames_of_a_run_are_on_its_sheet_and_in_its_movie() {
    let place = Place::new();
    let options = "--layers none --samples 1 --size 64x36 -o f/a.####.exr";
    with_ffmpeg(&place, &format!("{options} --frames 1-2")).done();
    let all = format!("{options} --frames 1-4 --resume --contact-sheet --movie m/turn.mp4");
    let ran = with_ffmpeg(&place, &all).done();
    assert!(
        ran.stderr.contains("2 frames are there") && ran.stdout.contains("turn.mp4, 4 frames"),
        "{ran:?}"
    );
    let names = ["a.0001.exr", "a.0002.exr", "a.0003.exr", "a.0004.exr", "analytic.contact.png"];
    assert_eq!(place.names("f"), names);
    // the movie is raw: eight bits of red, green and blue
    let movie = fs::read(place.path("m/turn.mp4")).unwrap();
    let frame = 64 * 36 * 3;
    assert_eq!(movie.len(), 4 * frame);
    let sheet = image::open(place.path("f/analytic.contact.png")).unwrap().into_rgb8();
    let small =
        |number: usize| image::RgbImage::from_raw(64, 36, movie[number * frame..][..frame].to_vec()).unwrap();
    for number in 0..4 {
        let small = small(number);
        let is_here = |x, y| *sheet.view(x, y, 64, 36).to_image() == *small;
        let places = (0..=sheet.width() - 64).flat_map(|x| (0..=sheet.height() - 36).map(move |y| (x, y)));
        assert!(places.into_iter().any(|(x, y)| is_here(x, y)), "frame {number} is not on the sheet");
    }
    // nothing to render is left, and both are made again
    fs::remove_file(place.path("m/turn.mp4")).unwrap();
    fs::remove_file(place.path("f/analytic.contact.png")).unwrap();
    with_ffmpeg(&place, &all).done();
    assert_eq!(fs::read(place.path("m/turn.mp4")).unwrap(), movie);
    assert_eq!(image::open(place.path("f/analytic.contact.png")).unwrap().into_rgb8(), sheet);
    // previews show what frames show
    with_ffmpeg(&place, &format!("{all} --png")).done();
    assert_eq!(fs::read(place.path("m/turn.mp4")).unwrap(), movie);
}

/// Preview, contact sheet and movie of a frame have its exposure and view, from previews or EXR files; its light stays.
#[test]
fn a_look_reaches_all_pictures_for_screens_and_no_exr() {
    let place = Place::new();
    let look = Look { exposure: 1.5, view: View::Agx };
    let options = "--layers none --samples 1 --size 64x36 --frames 1 -o";
    place.render(&format!("{options} plain/a.####.exr --png")).done();
    let looked = "--exposure 1.5 --view agx --contact-sheet --movie";
    with_ffmpeg(&place, &format!("{options} f/a.####.exr {looked} f/of_exr.mp4")).done();
    let frame = openexr::read(&place.path("f/a.0001.exr")).unwrap();
    // headers have the time of writing, which may differ
    let plain = openexr::read(&place.path("plain/a.0001.exr")).unwrap();
    for name in ["R", "G", "B", "A"] {
        assert_eq!(frame.channel(name).unwrap().data, plain.channel(name).unwrap().data, "{name}");
    }
    let planes = ["R", "G", "B"].map(|name| &frame.channel(name).unwrap().data);
    let on_screen = on_screen(look);
    let wanted: Vec<u8> =
        (0..64 * 36).flat_map(|at| on_screen(planes.map(|plane| plane[at])).map(srgb_byte)).collect();
    assert_eq!(fs::read(place.path("f/of_exr.mp4")).unwrap(), wanted);
    let wanted = image::RgbImage::from_raw(64, 36, wanted).unwrap();
    let on_sheet = || {
        let sheet = image::open(place.path("f/analytic.contact.png")).unwrap().into_rgb8();
        *sheet.view(8, 8, 64, 36).to_image() == *wanted
    };
    assert!(on_sheet());

    // the preview of another look is none of this run's
    with_ffmpeg(&place, &format!("{options} f/a.####.exr --png")).done();
    let plain = image::open(place.path("plain/a.0001.png")).unwrap().into_rgb8();
    assert_eq!(image::open(place.path("f/a.0001.png")).unwrap().into_rgb8(), plain);
    let again = format!("{options} f/a.####.exr --png --resume {looked} f/of_png.mp4");
    let ran = with_ffmpeg(&place, &again).done();
    assert!(ran.stderr.contains("without the preview that is asked for"), "{}", ran.stderr);
    assert_eq!(image::open(place.path("f/a.0001.png")).unwrap().into_rgb8(), wanted);
    assert!(on_sheet() && fs::read(place.path("f/of_png.mp4")).unwrap() == *wanted);
    assert!(with_ffmpeg(&place, &again).done().stderr.contains("1 frames are there"));
}

#[test]
fn what_cannot_be_made_is_told_before_anything_is_rendered() {
    let place = Place::new();
    let render = |options: &str| {
        let mut command =
            place.command(analytic(), &format!("--frames 1 --size 8x8 -o f/a.####.exr {options}"));
        Ran::new(command.env("PATH", "").output().unwrap())
    };
    render("--movie a.mp4").failed(&["FFmpeg", "apt-get install ffmpeg", "--movie"]);
    for (options, words) in [
        ("--movie a.mov", [".mp4", ".gif"]),
        ("--contact-sheet a.jpg", ["--contact-sheet a.jpg", ".png"]),
        ("--png --contact-sheet f/a.0001.png", ["--contact-sheet", "a frame of this run"]),
        ("--stats a.png --contact-sheet a.png", ["--stats", "same file"]),
    ] {
        let ran = render(options);
        assert!(ran.code == 2 && words.iter().all(|word| ran.stderr.contains(word)), "{options}: {ran:?}");
    }
    render("--contact-sheet /dev/null/a.png").failed(&["/dev/null"]);
    assert_eq!(place.names(""), [""; 0]);
}

#[test]
fn a_movie_that_ffmpeg_refuses_is_an_error_that_tells_its_words() {
    let place = Place::new();
    fs::write(
        place.path("ffmpeg"),
        "#!/bin/sh\n[ \"$1\" = -version ] && exit\necho no such codec >&2; exit 1\n",
    )
    .unwrap();
    fs::set_permissions(place.path("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/usr/bin:/bin", place.0.path().display());
    let mut command =
        place.command(analytic(), "--frames 1 --size 64x36 --samples 1 -o a.####.exr --movie a.gif");
    Ran::new(command.env("PATH", path).output().unwrap()).failed(&["a.gif", "no such codec"]);
    assert_eq!(place.names(""), ["a.0001.exr", "ffmpeg"]);
}

#[test]
#[cfg_attr(not(ffmpeg), ignore = "needs FFmpeg: set AFTERIMAGE_FFMPEG")]
fn ffmpeg_packs_movies_that_it_can_read() {
    let ffmpeg = std::env::var_os("AFTERIMAGE_FFMPEG").unwrap();
    let place = Place::new();
    for name in ["a.mp4", "a.gif"] {
        let options = format!("--frames 1-5 --size 63x35 --samples 1 --resume -o a.####.exr --movie {name}");
        Ran::new(place.command(analytic(), &options).output().unwrap()).done();
        let mut command = std::process::Command::new(&ffmpeg);
        command.arg("-i").arg(place.path(name)).args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
        let frames = command.output().unwrap().stdout;
        let size = if name == "a.mp4" { 64 * 36 } else { 63 * 35 };
        assert_eq!(frames.len(), 5 * size * 3, "{name}");
        // what is light in a frame is light in the movie
        let first = openexr::read(&place.path("a.0001.exr")).unwrap();
        let [mut sum, mut count] = [0.0; 2];
        for (y, x) in (0..35).flat_map(|y| (0..63).map(move |x| (y, x))) {
            let width = if name == "a.mp4" { 64 } else { 63 };
            let byte = f64::from(frames[(y * width + x) * 3 + 1]);
            let value = afterimage::output::png::srgb_byte(first.channel("G").unwrap().data[y * 63 + x]);
            sum += (byte - f64::from(value)).abs();
            count += 1.0;
        }
        assert!(sum / count < 6.0, "{name}: {}", sum / count);
    }
}

/// A coarse picture shows what the first frame shows, and changes nothing of it.
#[test]
fn a_coarse_picture_comes_before_frames_that_stay_as_they_are() {
    let place = Place::new();
    let options = "--layers all --samples 2 --size 128x72 --frames 3-4 --png";
    place.render(&format!("{options} -o plain/a.####.exr")).done();
    assert!(!place.path("plain/analytic.coarse.png").exists(), "nobody looks at a bar");
    let ran = place.render(&format!("{options} --coarse always -o f/a.####.exr")).done();
    assert!(
        ran.stderr.contains("note: a coarse picture of frame 3")
            && ran.stderr.contains("f/analytic.coarse.png"),
        "{ran:?}"
    );
    for name in ["a.0003.exr", "a.0004.exr"] {
        runs::assert_same(&place.path("f").join(name), &place.path("plain").join(name));
    }
    let preview = |folder: &str| image::open(place.path(folder).join("a.0003.png")).unwrap().into_rgb8();
    assert!(preview("f") == preview("plain"));
    let coarse = image::open(place.path("f/analytic.coarse.png")).unwrap().into_rgb8();
    assert_eq!(coarse.dimensions(), (32, 18));
    // the mean of the pixels that it stands for is near, but at edges
    let small = image::imageops::resize(&preview("f"), 32, 18, image::imageops::FilterType::Triangle);
    let near = coarse
        .pixels()
        .zip(small.pixels())
        .filter(|(a, b)| a.0.iter().zip(b.0).all(|(a, b)| a.abs_diff(b) < 24));
    let near = near.count();
    assert!(near > 32 * 18 * 3 / 4, "{near} of {}", 32 * 18);

    // a part of the picture, in the look that is asked for; `none` makes none
    let cropped = format!("{options} --crop 64x36+32+16 --exposure -20 -o g/a.####.exr");
    place.render(&format!("{cropped} --coarse none")).done();
    assert!(!place.path("g/analytic.coarse.png").exists());
    place.render(&format!("{cropped} --coarse always")).done();
    let coarse = image::open(place.path("g/analytic.coarse.png")).unwrap().into_rgb8();
    assert_eq!(coarse.dimensions(), (16, 9));
    assert!(coarse.pixels().all(|pixel| pixel.0.iter().all(|byte| *byte < 8)), "it is dark");
}

/// What stands in the way of a coarse picture is told, and frames are rendered.
#[test]
fn a_coarse_picture_that_cannot_be_written_ends_nothing() {
    let place = Place::new();
    fs::create_dir_all(place.path("f/analytic.coarse.png")).unwrap();
    let options = "--layers none --samples 1 --size 64x36 --frames 1 --coarse always -o f/a.####.exr";
    let ran = place.render(options).done();
    assert!(
        ran.stderr.contains("warning: no coarse picture: ") && ran.stderr.contains("analytic.coarse.png"),
        "{ran:?}"
    );
    assert!(place.path("f/a.0001.exr").exists());
    // nothing is rendered, and nothing is shown
    fs::remove_dir(place.path("f/analytic.coarse.png")).unwrap();
    place.render(&format!("{options} --resume")).done();
    assert_eq!(place.names("f"), ["a.0001.exr"]);
}
