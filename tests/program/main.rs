//! Does the program do what it says: what it prints and writes, when it fails, and what is left of a run that was
//! interrupted? docs/architecture/tests.md has the question of each file.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "../small_shot/mod.rs"]
mod small_shot;
#[path = "../toy/mod.rs"]
mod toy;

mod checkpoint;
mod cli;
mod cuts;
mod denoise;
mod diff;
mod disk;
mod extras;
mod farm;
mod faults;
#[cfg(unix)]
mod files;
mod handoff;
mod hostile;
mod info;
mod init;
mod interrupted;
mod key_frames;
#[cfg(target_os = "linux")]
mod memory;
mod output;
mod preview;
mod readers;
mod runs;
mod shared;
mod store_file;
mod verify;
