//! Environments in shot files: what they mean, and what is said about maps that cannot be used.

use afterimage::scene::environment::Sky;
use afterimage::scene::{Background, Environment};
use glam::Vec3;
use tempfile::TempDir;

use crate::small_shot::*;

/// A map of 8 x 4 texels that is red at -Z.
fn map_in(folder: &TempDir, name: &str) {
    let mut picture = image::Rgb32FImage::new(8, 4);
    (0..32).for_each(|at| picture.put_pixel(at % 8, at / 8, image::Rgb([0.0, 0.0, 0.25])));
    for (x, y) in [(3, 1), (4, 1), (3, 2), (4, 2)] {
        picture.put_pixel(x, y, image::Rgb([2.0, 0.0, 0.0]));
    }
    picture.save_with_format(folder.path().join(name), image::ImageFormat::Hdr).unwrap();
}

#[test]
fn environments_are_maps_skies_or_the_background() {
    let folder = folder();
    map_in(&folder, "Round.hdr");
    let with = |keys: &str| load_in(folder.path(), &format!("[environment]\n{keys}{REST}"), true).unwrap();
    let of = |keys: &str| with(keys).scene.environment.unwrap();

    let shot = with("map = \"maps\\\\round.HDR\"\n");
    let map = shot.scene.environment.as_ref().unwrap();
    assert_eq!((map.radiance(Vec3::NEG_Z), map.visible), (2.0 * Vec3::X, true));
    assert!(shot.files.contains(&folder.path().join("Round.hdr")), "{:?}", shot.files);
    assert!(shot.warnings.is_empty() && map.sun().is_none());
    let turned = of("map = \"Round.hdr\"\nrotation = 90\npower = 0.5\nvisible = false\n");
    assert!(turned.radiance(Vec3::NEG_X).abs_diff_eq(Vec3::X, 1e-4) && !turned.visible);

    assert_eq!(shot.settings.paths, 16, "or it would light nothing");
    assert_eq!(with("sky = {}\n[indirect]\npaths = 0\n").settings.paths, 0);

    let plain = Sky::default();
    assert_eq!(of("sky = {}\n"), Environment::from_sky(&plain));
    assert_eq!((plain.elevation, plain.azimuth, plain.turbidity), (45.0, 135.0, 3.0), "as documented");
    assert_eq!(plain.ground, Vec3::splat(0.2), "as documented");
    let sky = Sky { elevation: 10.0, azimuth: -30.0, turbidity: 2.5, ground: Vec3::new(0.0, 0.5, 1.0) };
    let expected = Environment::from_sky(&sky).rotated(5.0).times(2.0);
    let keys = "elevation = 10\nazimuth = -30\nturbidity = 2.5\nground = [0, 0.5, 1]\n";
    assert_eq!(of(&format!("rotation = 5\npower = 2\n[environment.sky]\n{keys}")), expected);
    let inline = keys.trim_end().replace('\n', ", ");
    assert_eq!(of(&format!("power = 2\nsky = {{ {inline} }}\nrotation = 5\n")), expected);

    let background = Background { zenith: Vec3::Z, ..Background::uniform(Vec3::ONE) };
    let keys = "power = 3\n[background]\nzenith = [0, 0, 1]\nhorizon = [1, 1, 1]\n";
    assert_eq!(of(keys), Environment::from_background(&background).times(3.0));
}

#[test]
fn maps_that_cannot_be_used_are_errors_that_name_them() {
    let folder = folder();
    let text = format!("[environment]\nmap = \"a.hdr\"\n{REST}");
    let told = || load_in(folder.path(), &text, false).unwrap_err().to_string();
    for (bytes, words) in
        [(&b""[..], "is empty"), (b"no picture", "is neither"), (b"#?RADIANCE\n", "cannot be read")]
    {
        std::fs::write(folder.path().join("a.hdr"), bytes).unwrap();
        assert!(told().contains("/a.hdr: the environment map ") && told().contains(words), "{}", told());
    }
    let odd = image::Rgb32FImage::new(3, 4);
    odd.save_with_format(folder.path().join("a.hdr"), image::ImageFormat::Hdr).unwrap();
    let shot = load_in(folder.path(), &text, true).unwrap();
    assert!(shot.warnings[0].to_string().contains("twice as wide as high"), "{:?}", shot.warnings);
    assert!(shot.scene.environment.unwrap().is_black());
}
