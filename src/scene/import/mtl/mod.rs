//! Reads MTL files, and tells what their statements mean to the programs that wrote them.
//!
//! Not through tobj's reader: that one stops the program at a colour of two numbers, and does not know
//! the lines. The format's meaning follows Wavefront's description of it (`illum` 0 to 10).

mod exporter;
mod map_statement;
mod meaning;
pub mod statements;
mod unused_statements;

use std::collections::HashSet;
use std::path::Path;

use glam::Vec3;

pub(in crate::scene) use self::exporter::Exporter;
use self::statements::Statements;
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::import::obj::lines::{Lines, readable, split_keyword, words};
use crate::scene::material::LARGEST_COLOR;
use crate::scene::surface::Parameter;

/// Content of an MTL file.
#[derive(Debug, Default)]
pub(crate) struct MtlFile {
    /// Program that wrote it.
    pub exporter: Exporter,
    /// Materials in the order of the file.
    pub materials: Vec<Statements>,
    /// Values that make no sense: the line, and the value taken instead.
    pub oddities: Vec<(usize, String)>,
    /// Statements that have no effect here, although they have one in other programs: of each kind the first
    /// line, and the consequence.
    pub unused: Vec<(usize, String)>,
    /// Digest of the file's bytes.
    pub digest: Digest,
}

/// Reads the MTL file at `path`.
///
/// # Errors
/// Where it cannot be read.
pub(crate) fn read(path: &Path) -> Result<MtlFile, SceneError> {
    let unreadable =
        |error: InputError| SceneError::new(path, format!("the MTL file cannot be read: {error}"));
    let input = input::open(path, Kind::Materials).map_err(unreadable)?;
    // the text of it, and what is read of it
    let need = Need::new(Part::new("the MTL file", 2 * input.length, "fewer materials"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(unreadable)?;
    let digest = Digest::new(&bytes);
    Ok(MtlFile { digest, ..parse(&readable(bytes)) })
}

/// Reads MTL text. Exporters write values that make no sense, and other programs show their models all the
/// same. So a negative number is replaced by the minimum, a colour that is too large by the maximum, and any
/// other such statement is ignored.
pub(crate) fn parse(text: &[u8]) -> MtlFile {
    let MtlFile { mut materials, mut oddities, mut unused, digest, .. } = MtlFile::default();
    let (mut told, exporter) = (HashSet::new(), Exporter::of(text));
    for (number, line) in Lines::new(text) {
        let (keyword, rest) = split_keyword(&line);
        if keyword.eq_ignore_ascii_case(b"newmtl") {
            let name = String::from_utf8_lossy(rest).into_owned();
            materials.push(Statements { name, line: number, ..Statements::default() });
        } else if let Some(material) = materials.last_mut() {
            let keyword = String::from_utf8_lossy(keyword).to_ascii_lowercase();
            if let Some((key, message)) = unused_statements::message(&keyword)
                && told.insert(key)
            {
                unused.push((number, message));
            }
            let mut replaced = None;
            let taken = statement(material, &keyword, rest, number, &mut replaced);
            let passed_over = taken.err().map(|fault| format!("{fault}; the statement is passed over"));
            oddities.extend(passed_over.or(replaced).map(|message| (number, message)));
        }
    }
    if let Some(material) = materials.iter().find(|material| exporter.filters_nothing(material)) {
        let message = "`Tf` is not used: light passes where `d` is below 1, or `illum` is 4, 6, 7 or 9";
        unused.push((material.line, format!("material `{}`: {message}", material.name)));
    }
    MtlFile { exporter, materials, oddities, unused, digest }
}

/// Reads one statement. Where a number was replaced, `replaced` says so.
fn statement(
    material: &mut Statements,
    keyword: &str,
    rest: &[u8],
    line: usize,
    replaced: &mut Option<String>,
) -> Result<(), String> {
    match keyword {
        "kd" => material.kd = color("Kd", rest, replaced)?.or(material.kd),
        "ka" => material.ka = color("Ka", rest, replaced)?.or(material.ka),
        "ks" => material.ks = color("Ks", rest, replaced)?.or(material.ks),
        "ke" => material.ke = color("Ke", rest, replaced)?.or(material.ke),
        "tf" => material.tf = color("Tf", rest, replaced)?.or(material.tf),
        "ns" => material.ns = Some(number("Ns", rest, replaced)?),
        "ni" => material.ni = Some(number("Ni", rest, replaced)?),
        "d" => material.d = Some(number("d", rest, replaced)?),
        "tr" => material.tr = Some(number("Tr", rest, replaced)?),
        "illum" => material.illum = Some(illumination(rest)?),
        "pr" => material.pr = Some(share("Pr", rest, replaced)?),
        "pm" => material.pm = Some(share("Pm", rest, replaced)?),
        "pc" => material.state(Parameter::CoatWeight, Some(share("Pc", rest, replaced)?)),
        "pcr" => material.state(Parameter::CoatRoughness, Some(share("Pcr", rest, replaced)?)),
        _ => {
            if let Some(used) = map_statement::use_of_keyword(keyword) {
                material.maps[used] = map_statement::map_statement(&String::from_utf8_lossy(rest), line);
            }
        }
    }
    Ok(())
}

/// Reads one number for grey, or three; cut off at [`LARGEST_COLOR`]. `None` for `xyz` and `spectral`, which
/// have no plain RGB.
fn color(key: &str, rest: &[u8], replaced: &mut Option<String>) -> Result<Option<Vec3>, String> {
    let values: Vec<&[u8]> = words(rest).collect();
    let mut value = |word: &[u8]| {
        let value = value(key, word, replaced)?;
        if value > LARGEST_COLOR {
            *replaced =
                Some(format!("`{key}` is {value}, but at most {LARGEST_COLOR} can be kept; that is taken"));
        }
        Ok::<f32, String>(value.min(LARGEST_COLOR))
    };
    match values.as_slice() {
        [b"xyz" | b"spectral", ..] => Ok(None),
        [grey] => Ok(Some(Vec3::splat(value(grey)?))),
        [r, g, b, ..] => Ok(Some(Vec3::new(value(r)?, value(g)?, value(b)?))),
        _ => Err(format!("`{key}` takes three numbers, red, green and blue")),
    }
}

fn number(key: &str, rest: &[u8], replaced: &mut Option<String>) -> Result<f32, String> {
    let word = words(rest).find(|word| *word != b"-halo").ok_or_else(|| format!("`{key}` takes a number"))?;
    value(key, word, replaced)
}

/// Reads a number from 0 to 1.
fn share(key: &str, rest: &[u8], replaced: &mut Option<String>) -> Result<f32, String> {
    let value = number(key, rest, replaced)?;
    if value > 1.0 {
        *replaced = Some(format!("`{key}` is {value}: it must be from 0 to 1; 1 is taken"));
    }
    Ok(value.min(1.0))
}

fn value(key: &str, word: &[u8], replaced: &mut Option<String>) -> Result<f32, String> {
    let word = String::from_utf8_lossy(word);
    let fault = || format!("`{key}` is `{word}`: it must be a finite number, not negative");
    let value = word.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(fault)?;
    let value = value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    if value < 0.0 {
        // an index of 0 means 1: light is not bent
        let least = if key == "Ni" { 1.0 } else { 0.0 };
        *replaced = Some(format!("{}; {least} is taken", fault()));
        return Ok(least);
    }
    Ok(value)
}

fn illumination(rest: &[u8]) -> Result<u32, String> {
    let word = words(rest).next().ok_or("`illum` takes a number")?;
    let word = String::from_utf8_lossy(word);
    let model = word.parse::<f32>().ok().filter(|model| model.fract() == 0.0 && (0.0..=10.0).contains(model));
    model
        .map(|model| model as u32)
        .ok_or_else(|| format!("`illum` is `{word}`: the models are the whole numbers from 0 to 10"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use glam::Vec2;

    use super::*;
    use crate::scene::import::mtl::statements::maps::{MapStatements, MapUse};

    fn stated(statements: &str) -> Statements {
        let file = parse(format!("newmtl m\n{statements}").as_bytes());
        assert_eq!(file.oddities, [], "{statements}");
        file.materials.into_iter().next().unwrap()
    }

    #[test]
    fn statements_that_change_nothing_are_told_once_each() {
        let file = parse(
            b"newmtl a\nmap_Kd k.png\nmap_Ka m.png\nnewmtl b\nmap_Tr r.png\nDECAL a.png\ndecal b.png\n",
        );
        let told: Vec<(usize, &str)> =
            file.unused.iter().map(|(line, message)| (*line, &message[..8])).collect();
        assert_eq!((told, file.oddities.len()), (vec![(3, "`map_Ka`"), (5, "`map_Tr`"), (6, "`decal` ")], 0));
        assert_eq!(parse(b"newmtl a\nPr .5\nmap_Kd k.png").unused, []);
    }

    #[test]
    fn a_filter_of_what_lets_nothing_through_is_told() {
        let unused = |statements: &str| parse(format!("newmtl m\n{statements}").as_bytes()).unused;
        assert!(
            unused("Kd 1 1 1\nTf 1 1 1\nNi 1.45")
                .iter()
                .any(|(line, text)| *line == 1 && text.contains("`Tf`"))
        );
        for used in ["Tf 0 0 0", "Tf 1 1 1\nillum 7", "Tf .5 1 1\nd .5", "Kd 1 1 1"] {
            assert_eq!(unused(used), [], "{used}");
        }
    }

    #[test]
    fn knows_contradictions() {
        assert!(stated("d 1\nTr 1").contradicts_itself());
        assert!(!stated("d .25\nTr .75").contradicts_itself());
        assert!(!stated("d .25").contradicts_itself());
    }

    #[test]
    fn texture_statements_have_options_before_names_with_spaces() {
        let map =
            |statement: &str| stated(&format!("map_Kd {statement}")).maps[MapUse::Color].clone().unwrap();
        let full = map("-s 2 3 1 -o 0.5 0.25 0 -clamp on -bm 0.2 file name 1.png");
        assert_eq!(full.file, "file name 1.png");
        assert_eq!((full.scale, full.offset, full.clamp), (Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.25), true));
        let partly = map("-s 2 tex.png");
        assert_eq!((partly.file.as_str(), partly.scale), ("tex.png", Vec2::new(2.0, 1.0)));
        assert_eq!(map("-blendu on -mm 0 1 -imfchan r -texres 64 a\\b.tga").file, "a\\b.tga");
        assert_eq!(map("wood.jpg -bm 1.5 -clamp on").file, "wood.jpg");
        assert_eq!(map("my -odd- name.jpg").file, "my -odd- name.jpg");
        assert_eq!(map("-o 1 1 1").file, "1");
        assert_eq!(stated("map_Kd").maps, MapStatements::default());
    }

    #[test]
    fn names_keep_their_spaces() {
        let all = parse(b"Kd 9 9 9\nnewmtl  a b \r\n\tKd 1 0 0\r\nnewmtl c").materials;
        assert_eq!(all.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["a b", "c"]);
        assert_eq!((all[0].kd, all[1].line), (Some(Vec3::X), 4));
    }

    #[test]
    fn numbers_out_of_range_count_as_the_next_in_it_and_are_told() {
        for (statement, told) in [
            ("Ns -1.96", "`Ns` is `-1.96`: it must be a finite number, not negative; 0 is taken"),
            ("Ni -1", "`Ni` is `-1`: it must be a finite number, not negative; 1 is taken"),
            ("Kd 0.5 -0.1 1", "`Kd` is `-0.1`: it must be a finite number, not negative; 0 is taken"),
            ("d -1", "`d` is `-1`: it must be a finite number, not negative; 0 is taken"),
            ("Pr -0.5", "`Pr` is `-0.5`: it must be a finite number, not negative; 0 is taken"),
            ("Pr 1.5", "`Pr` is 1.5: it must be from 0 to 1; 1 is taken"),
            ("Pm 100", "`Pm` is 100: it must be from 0 to 1; 1 is taken"),
            ("Ke 1 7e4 0", "`Ke` is 70000, but at most 65504 can be kept; that is taken"),
        ] {
            let file = parse(format!("newmtl m\n\n{statement}").as_bytes());
            assert_eq!(file.oddities, [(3, told.to_string())]);
        }
        let all = parse(b"newmtl m\nNs -1.96\nNi -1\nKd 0.5 -0.1 1\nd -1").materials;
        let expected = (Some(0.0), Some(1.0), Some(Vec3::new(0.5, 0.0, 1.0)), Some(0.0));
        assert_eq!((all[0].ns, all[0].ni, all[0].kd, all[0].d), expected);
    }

    #[test]
    fn statements_that_make_no_sense_are_passed_over_and_told() {
        for bad in [
            "Kd 1 2",
            "Kd nan 0 0",
            "Kd",
            "Ns x",
            "d inf",
            "Ns -inf",
            "illum 11",
            "illum -1",
            "illum 1.5",
            "illum",
            "Ni",
            "Pr nan",
            "Pm rough",
            "Pr",
        ] {
            let file = parse(format!("newmtl m\n\n{bad}").as_bytes());
            let key = bad.split(' ').next().unwrap();
            let [(3, told)] = file.oddities.as_slice() else { panic!("{bad}: {:?}", file.oddities) };
            assert!(told.starts_with(&format!("`{key}`")) && told.ends_with("passed over"), "{told}");
            let nothing = Statements { name: "m".into(), line: 1, ..Statements::default() };
            assert_eq!(file.materials, [nothing], "{bad}");
        }
        assert_eq!(stated("Kd spectral file.rfl 1").kd, None);
    }
}
