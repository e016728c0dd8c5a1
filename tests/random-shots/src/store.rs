//! Samples through a file, as `--save-store` and `--load-store` send them.

use std::error::Error;
use std::path::Path;

use afterimage::digest::Digest;
use afterimage::frame::{Renderer, Snapshot};
use afterimage::output::fingerprint::Fingerprint;
use afterimage::output::store_file::{self, Header, StoreFile};
use afterimage::scene::Scene;

/// The samples of the frame rendered last, written and read again; none before the first frame.
pub fn through_file(
    renderer: &Renderer<'_>,
    scene: &Scene,
    folder: &Path,
) -> Result<Option<Snapshot>, Box<dyn Error>> {
    let Some((moment, pictures)) = renderer.samples() else { return Ok(None) };
    let path = folder.join("samples.store");
    let shape = renderer.shape();
    let digest = Digest::new(b"a random shot");
    let header = Header {
        fingerprint: Fingerprint { version: digest, shot: digest, inputs: digest, settings: digest },
        frame: moment.frame,
        sampling: String::new(),
        ancestry: String::new(),
        rendered: moment.rendered,
    };
    store_file::write(&path, &header, &pictures, shape.layout)?;
    let pictures = StoreFile::open(&path)?.read(&shape, scene)?;
    Ok(Some(Snapshot { moment, pictures }))
}
