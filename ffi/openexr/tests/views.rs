//! Files of several views: what stands in them by OpenEXR's conventions, and what is refused.
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs::File;

use openexr::{
    Attribute, Channel, Compression, Data, Error, Image, SampleType, View, part_count, read, read_header_of,
    write_views,
};

const VALUES: [&[f32]; 2] = [&[1.0, 2.0], &[3.0, 4.0]];

fn view<'a>(name: &'a str, values: &'a [f32]) -> View<'a> {
    let channel = |name| Channel { name, stored: SampleType::Float, data: Data::Floats(values) };
    let attributes = vec![
        ("shot".to_owned(), Attribute::Text("walk".into())),
        ("eye".to_owned(), Attribute::Float(values[0])),
    ];
    let channels = ["R", "Z", "diffuse.R"].map(channel).into();
    let image =
        Image { width: 2, height: 1, placed: None, channels, attributes, compression: Compression::Zips };
    View { name, image }
}

fn written(views: &[View<'_>], parts: bool) -> Result<tempfile::NamedTempFile, Error> {
    let file = tempfile::NamedTempFile::new().unwrap();
    write_views(&File::create(file.path()).unwrap(), file.path(), views, parts).map(|()| file)
}

fn both() -> [View<'static>; 2] {
    [view("left", VALUES[0]), view("right", VALUES[1])]
}

#[test]
fn one_part_names_views_before_the_last_dot() {
    let file = written(&both(), false).unwrap();
    let image = read(file.path()).unwrap();
    let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["R", "Z", "diffuse.left.R", "diffuse.right.R", "right.R", "right.Z"]);
    for (name, values) in
        [("R", 0), ("right.R", 1), ("diffuse.left.R", 0), ("diffuse.right.R", 1), ("right.Z", 1)]
    {
        assert_eq!(image.channel(name).unwrap().data, VALUES[values], "{name}");
    }
    let views = Attribute::Texts(vec!["left".into(), "right".into()]);
    assert_eq!(image.attribute("multiView"), Some(&views));
    assert_eq!(image.attribute("eye"), Some(&Attribute::Float(1.0)));
    assert_eq!(image.attribute("right.eye"), Some(&Attribute::Float(3.0)));
    assert_eq!(image.attribute("right.shot"), None, "both say the same");
}

#[test]
fn parts_have_a_view_each() {
    let file = written(&both(), true).unwrap();
    let parts = (0..part_count(file.path()).unwrap()).map(|part| read_header_of(file.path(), part).unwrap());
    let parts: Vec<_> = parts
        .map(|part| {
            let Some(Attribute::Text(view)) = part.attribute("view").cloned() else { panic!("no view") };
            let Some(Attribute::Float(eye)) = part.attribute("eye") else { panic!("no eye") };
            assert!(part.attribute("multiView").is_none());
            (part.part_name.clone(), view, part.channels[0].name.clone(), *eye)
        })
        .collect();
    let part = |name: &str, view: &str, channel: &str, eye| (name.into(), view.into(), channel.into(), eye);
    let wanted = [
        part("rgba.left", "left", "R", 1.0),
        part("rgba.right", "right", "R", 3.0),
        part("Z.left", "left", "Z", 1.0),
        part("Z.right", "right", "Z", 3.0),
        part("diffuse.left", "left", "diffuse.R", 1.0),
        part("diffuse.right", "right", "diffuse.R", 3.0),
    ];
    assert_eq!(parts, wanted);
}

#[test]
fn what_is_no_view_is_refused() {
    let refused = |views: &[View<'_>], word: &str| {
        for parts in [false, true] {
            let text = written(views, parts).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    };
    refused(&[], "no view");
    refused(&[view("", VALUES[0])], "empty");
    refused(&[view("a.b", VALUES[0])], "dots");
    refused(&[view("left eye", VALUES[0])], "spaces");
    let [left, mut right] = both();
    right.image.compression = Compression::Zip;
    refused(&[left.clone(), right], "another form");
    let two = written(&[left.clone(), left.clone()], false).unwrap_err().to_string();
    assert!(two.contains("twice"), "{two}");
    let mut dotted = left;
    dotted.image.channels[0].name = "a.b.R";
    refused(&[dotted], "one dot");
}
