//! One frame as one EXR file: a single scanline part that holds all layers, or a part for each.

use std::fmt;
use std::fs::File;
use std::path::Path;
use std::sync::mpsc::Sender;
use std::time::SystemTime;

use rayon::ThreadPool;

use openexr::{Attribute, Channel, Compression, Data, Image, Placed, SampleType};

use super::fingerprint::{self, Fingerprint};
use super::metadata::{FRAME_KEY, FrameMeta, attributes};
use super::staged::{WriteError, write_whole};
use crate::film::{Film, Plane, PlaneKind, Values};
use crate::settings::{self, FileFormat, PixelRect, Settings};

/// Reason why a frame was not written.
#[derive(Debug)]
pub enum ExrError {
    /// The file could not be written.
    Write(WriteError),
    /// A plane breaks a rule of the format, or OpenEXR failed.
    Encode(openexr::Error),
}

impl From<WriteError> for ExrError {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

impl From<openexr::Error> for ExrError {
    fn from(error: openexr::Error) -> Self {
        match error {
            openexr::Error::File { path, source, .. } => Self::Write(WriteError { path, source }),
            error => Self::Encode(error),
        }
    }
}

impl fmt::Display for ExrError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Write(error) => error.fmt(f),
            Self::Encode(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExrError {}

/// Data window and display window of a frame's pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Windows {
    /// Pixels in the file.
    pub data: PixelRect,
    /// Columns and rows of the picture, whose first pixel is (0, 0). Compositors call it display window, or format.
    pub picture: [u32; 2],
}

impl Windows {
    /// Windows of all pixels of a picture of this size, and no others.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { data: PixelRect { x: 0, y: 0, width, height }, picture: [width, height] }
    }

    /// Windows for `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self { data: settings.data_window(), picture: [settings.width, settings.height] }
    }
}

/// Threads that pack a frame, and a message when they are done.
#[derive(Debug, Default)]
pub struct Packing<'t> {
    /// Pool of the threads that pack. None: that of the calling thread.
    pub threads: Option<&'t ThreadPool>,
    /// Receives a message when packing is done, and only the disk is waited for.
    pub done: Option<Sender<()>>,
}

/// Writes all planes and the metadata to `path`, whole or not at all. ZIPS, which loses nothing and
/// is what compositors read fastest.
///
/// # Errors
/// A plane holds a NaN or an infinity, has a name that EXR does not allow or the wrong size, or the
/// file cannot be written. The error names the file and says what to do; no file is left behind.
pub fn write_exr(path: &Path, film: &Film, meta: &FrameMeta) -> Result<(), ExrError> {
    let windows = Windows::whole([film.width, film.height]);
    write_planes(path, windows, film.planes.iter(), meta, FileFormat::default(), Packing::default())
}

/// Picture of one of several eyes, or of the only one.
#[derive(Debug)]
pub struct View<'p> {
    /// Name of the view, `left` or `right`; none for the only eye.
    pub name: Option<&'static str>,
    /// Planes, in any order.
    pub planes: Vec<&'p Plane>,
    /// Metadata for the header.
    pub meta: FrameMeta,
}

/// Writes these planes like [`write_exr`], with the pixels in `windows`, and the file in this `format`.
///
/// # Errors As [`write_exr`].
pub fn write_planes<'p>(
    path: &Path,
    windows: Windows,
    planes: impl Iterator<Item = &'p Plane>,
    meta: &FrameMeta,
    format: FileFormat,
    packing: Packing<'_>,
) -> Result<(), ExrError> {
    let view = View { name: None, planes: planes.collect(), meta: meta.clone() };
    write_views(path, windows, &[view], format, packing)
}

/// Writes the pictures of all eyes like [`write_planes`]: one file for all of them, multi-view if they have
/// names.
///
/// # Errors As [`write_exr`], and if there is no view.
pub fn write_views(
    path: &Path,
    windows: Windows,
    views: &[View<'_>],
    format: FileFormat,
    packing: Packing<'_>,
) -> Result<(), ExrError> {
    let now = SystemTime::now();
    let views: Vec<openexr::View> = views
        .iter()
        .map(|view| {
            let attributes = attributes(&view.meta, now);
            let image = image(windows, &view.planes, attributes, compression(format));
            openexr::View { name: view.name.unwrap_or_default(), image }
        })
        .collect();
    let write = |file: &File| match &views[..] {
        [openexr::View { name: "", image }] if format.multipart => openexr::write_parts(file, path, image),
        [openexr::View { name: "", image }] => openexr::write(file, path, image),
        views => openexr::write_views(file, path, views, format.multipart),
    };
    write_whole(path, |file| {
        // only what takes the processors' time: what waits for the disk must not keep one of them
        let written = match packing.threads {
            Some(threads) => threads.install(|| write(file)),
            None => write(file),
        };
        if let Some(done) = &packing.done {
            // nobody may wait for it
            let _ = done.send(());
        }
        written.map_err(ExrError::from)
    })
}

fn image<'p>(
    Windows { data, picture }: Windows,
    planes: &[&'p Plane],
    attributes: Vec<(String, Attribute)>,
    compression: Compression,
) -> Image<'p> {
    let channels = planes.iter().map(|plane| {
        let stored = match plane.kind {
            PlaneKind::Half => SampleType::Half,
            PlaneKind::Float => SampleType::Float,
        };
        let data = match &plane.values {
            Values::Half(values) => Data::Halves(values),
            Values::Float(values) => Data::Floats(values),
        };
        Channel { name: &plane.name, stored, data }
    });
    Image {
        width: data.width,
        height: data.height,
        placed: Some(Placed { first: [data.x, data.y], picture }),
        channels: channels.collect(),
        attributes,
        compression,
    }
}

fn compression(format: FileFormat) -> Compression {
    match format.compression {
        settings::Compression::None => Compression::None,
        settings::Compression::Zips => Compression::Zips,
        settings::Compression::Zip => Compression::Zip,
        settings::Compression::Piz => Compression::Piz,
    }
}

/// Writes planes of any names as floats, whole or not at all: a picture of `size` (columns and rows) that is no frame.
///
/// # Errors
/// As [`write_exr`].
pub fn write_floats(
    path: &Path,
    size: [u32; 2],
    planes: &[(String, Vec<f32>)],
    comments: &str,
) -> Result<(), ExrError> {
    let channels = planes.iter().map(|(name, values)| {
        let (stored, data) = (SampleType::Float, Data::Floats(values));
        Channel { name, stored, data }
    });
    let image = Image {
        width: size[0],
        height: size[1],
        placed: None,
        channels: channels.collect(),
        attributes: vec![("comments".to_owned(), Attribute::Text(comments.replace('\0', " ")))],
        compression: Compression::Zips,
    };
    write_whole(path, |file| openexr::write(file, path, &image).map_err(ExrError::from))
}

/// Returns true if `path` is an EXR file that can be read to its end: the run that wrote it finished the
/// frame.
pub fn is_whole(path: &Path) -> bool {
    let is_whole = |part| openexr::scan_part(path, part, |_, _| {}).is_ok();
    openexr::part_count(path).is_ok_and(|parts| (0..parts).all(is_whole))
}

/// What the header of a frame says about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Head {
    /// Number of the frame.
    pub frame: Option<i32>,
    /// What the frame was made from.
    pub made_from: Option<Fingerprint>,
    /// Fingerprint of the run that made it.
    pub run: Option<Fingerprint>,
}

impl Head {
    /// Reads the header of the frame at `path`. The pixels are not read.
    ///
    /// # Errors It is no EXR file that can be read.
    pub fn read(path: &Path) -> Result<Self, openexr::Error> {
        let head = openexr::read_header(path)?;
        let fingerprint = |key: &str| match head.attribute(key) {
            Some(Attribute::Text(text)) => text.parse().ok(),
            _ => None,
        };
        let frame = match head.attribute(FRAME_KEY) {
            Some(Attribute::Int(frame)) => Some(*frame),
            _ => None,
        };
        Ok(Self { frame, made_from: fingerprint(fingerprint::KEY), run: fingerprint(fingerprint::RUN_KEY) })
    }

    /// Number of another frame than `frame`, if the file has that under the name of this one.
    pub fn other_frame(&self, frame: i32) -> Option<i32> {
        self.frame.filter(|number| *number != frame)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;
    use crate::digest::Digest;

    fn meta() -> FrameMeta {
        let mut world_to_camera = [0.0; 16];
        for (index, element) in [(0, 1.0), (5, 1.0), (10, 1.0), (12, -3.0), (15, 1.0)] {
            world_to_camera[index] = element;
        }
        let (comments, shot) = ("reprojected".to_owned(), "walk".to_owned());
        let (frame, rate) = (1042, (24000, 1001));
        let fingerprint = Some(Fingerprint {
            version: Digest::new(b"1"),
            shot: Digest::new(b"2"),
            inputs: Digest::new(b"3"),
            settings: Digest::new(b"4"),
        });
        let layers = [(String::from("cryptomatte/1234567/name"), String::from("CryptoObject"))].into();
        FrameMeta {
            frame,
            rate,
            world_to_camera,
            world_to_ndc: [0.5; 16],
            comments,
            shot,
            fingerprint,
            layers,
        }
    }

    fn film() -> Film {
        let plane = |name, kind, value| Plane::new(name, kind, &[value; 6]);
        let planes = vec![
            plane("R", PlaneKind::Half, 0.5),
            plane("Z", PlaneKind::Float, 1e6),
            plane("P.X", PlaneKind::Float, 0.1),
            plane("status_good.V", PlaneKind::Half, 1.0),
        ];
        Film { width: 3, height: 2, planes }
    }

    #[test]
    fn planes_and_metadata_arrive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.1042.exr");
        write_exr(&path, &film(), &meta()).unwrap();
        let back = openexr::read(&path).unwrap();
        assert_eq!(back.compression, Some(Compression::Zips));
        for plane in &film().planes {
            let channel = back.channel(&plane.name).unwrap();
            assert_eq!(channel.data, plane.values.to_floats(), "{}", plane.name);
            assert_eq!(channel.stored == SampleType::Half, plane.kind == PlaneKind::Half);
        }
        let rate = Attribute::Rational { numerator: 24000, denominator: 1001 };
        assert_eq!(back.attribute("framesPerSecond"), Some(&rate));
        assert_eq!(back.attribute("imageCounter"), Some(&Attribute::Int(1042)));
        let object = Attribute::Text("CryptoObject".into());
        assert_eq!(back.attribute("cryptomatte/1234567/name"), Some(&object));
        assert_eq!(back.attribute("comments"), Some(&Attribute::Text("reprojected".into())));
        let matrix = Attribute::M44f(meta().world_to_camera);
        assert_eq!(back.attribute("worldToCamera"), Some(&matrix));
        assert!(matches!(back.attribute("chromaticities"), Some(Attribute::Chromaticities(_))));
        let head = Head { frame: Some(1042), made_from: meta().fingerprint, run: None };
        assert_eq!(Head::read(&path).unwrap(), head);
        assert_eq!((head.other_frame(1042), head.other_frame(7)), (None, Some(1042)));
        write_exr(&path, &film(), &FrameMeta { fingerprint: None, ..meta() }).unwrap();
        assert_eq!(Head::read(&path).unwrap(), Head { made_from: None, ..head });
        std::fs::write(&path, "no picture").unwrap();
        assert!(Head::read(&path).is_err() && !is_whole(&path));
    }

    #[test]
    fn a_part_for_each_layer_is_whole_or_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.1042.exr");
        let film = film();
        let format = FileFormat { multipart: true, compression: settings::Compression::Piz };
        let windows = Windows::whole([3, 2]);
        write_planes(&path, windows, film.planes.iter(), &meta(), format, Packing::default()).unwrap();
        assert_eq!(openexr::part_count(&path).unwrap(), 4);
        assert_eq!(openexr::read(&path).unwrap().channels[0].name, "R");
        assert_eq!(openexr::read(&path).unwrap().compression, Some(Compression::Piz));
        assert_eq!(Head::read(&path).unwrap().made_from, meta().fingerprint);
        assert!(is_whole(&path));
        // the last part alone lacks something
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert!(openexr::read(&path).is_ok() && !is_whole(&path));
    }

    #[test]
    fn a_nan_is_named_and_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.0001.exr");
        std::fs::write(&path, "old").unwrap();
        let mut film = film();
        film.planes[2].values.put(4, &[f32::NAN]);
        let text = write_exr(&path, &film, &meta()).unwrap_err().to_string();
        assert!(text.contains("\"P.X\"") && text.contains("(1, 1)"), "{text}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
