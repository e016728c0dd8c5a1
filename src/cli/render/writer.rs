//! Writing of finished frames, and what the run tells about them.

use std::time::Instant;

use rayon::ThreadPool;

use super::record::Record;
use crate::cli::failure::Failure;
use crate::cli::frames::resume::Fingerprints;
use crate::cli::frames::target::Target;
use crate::cli::frames::writing::{Frame, Seen, Waiting};
use crate::cli::say::table;
use crate::cli::say::terminal::Terminal;
use crate::output::exr::Packing;
use crate::stats::{FrameStats, Seconds};

/// Writes frames into their files.
pub struct Writer<'a> {
    /// Their places.
    pub target: &'a Target,
    /// What they are made from.
    pub fingerprints: &'a Fingerprints,
    /// Pool of the threads that render.
    pub pool: &'a ThreadPool,
}

impl Writer<'_> {
    /// Writes a frame if it is to be written, adds the time that rendering waits for that to its statistics,
    /// and reports it.
    pub fn write(
        &self,
        frame: &mut Frame,
        waiting: &Waiting,
        record: &mut Record,
        terminal: &mut Terminal,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let Frame { seen, write, copying, packed } = frame;
        let seconds = seen.last().map_or(Seconds::default(), |seen| seen.finished.stats.seconds);
        let number = seen.first().map_or(0, |seen| seen.finished.stats.frame);
        let file = if *write {
            let made_from = Some(self.fingerprints.made_from(number));
            let packing = Packing { threads: Some(self.pool), done: packed.take() };
            Some(self.target.write(seen, made_from, packing)?)
        } else {
            None
        };
        // one file has both eyes, and the last one waits for it
        let waited = *copying + waiting.seconds(start);
        let (total, waited) = (seconds.total + waited, seconds.write + waited);
        if let Some(last) = seen.last_mut() {
            last.finished.stats.seconds = Seconds { total, write: waited, ..seconds };
        }
        let mut told = FrameStats::default();
        for Seen { finished, .. } in seen {
            let full = record.add(&finished.stats, *write);
            if *write {
                terminal.result(&table::row(&finished.stats, full));
            }
            let total = told.seconds.total + finished.stats.seconds.total;
            told = finished.stats.clone();
            told.seconds.total = total;
        }
        terminal.frame_done(&told, file.as_deref());
        Ok(())
    }
}
