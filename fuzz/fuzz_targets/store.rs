//! Saved samples and checkpoints, whose checksums are taken as right (`cfg(fuzzing)`), up to the frame that is made of them.
#![no_main]

use std::sync::LazyLock;

use afterimage::changes::Direction;
use afterimage::frame::{Moment, Renderer, Snapshot, ValidDirection};
use afterimage::output::store_file::StoreFile;
use afterimage::scene::Shot;
use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

/// The shot whose samples `afterimage render fuzz/seeds/store.toml --frames 1 --save-store FILE` saves.
static LOADED: LazyLock<Shot> = LazyLock::new(|| {
    let light = "[[light]]\ntype = \"point\"\nposition = [1, 2, 3]\n[[light]]\ntype = \"sphere\"\nposition = [0, 3, 3]\nradius = 0.5\n";
    let more = "[indirect]\npaths = 2\n[environment]\npower = 0.5\n[environment.sky]\nelevation = 30\n";
    let text = format!("{SHOT}[[model]]\nobj = \"m.obj\"\n{light}{more}");
    FOLDER.write("s.toml", text);
    FOLDER.load("s.toml").expect("the shot of this target is right")
});

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.write("a.store", bytes);
    if let Ok(file) = StoreFile::open(&path) {
        let _ = file.check();
    }
    let Ok(file) = StoreFile::open(&path) else { return };
    let (frame, rendered) = (file.header().frame, file.header().rendered);
    let Ok(mut renderer) = Renderer::new(&LOADED.scene, &LOADED.settings) else { return };
    let Ok(pictures) = file.read(&renderer.shape(), &LOADED.scene) else { return };
    let valid = ValidDirection::To(Direction::Forward);
    renderer.restore(Snapshot { moment: Moment { frame, rendered, valid }, pictures });
    let _ = renderer.render(frame.wrapping_add(1), true);
});
