//! Costs of the frames that a run has rendered, for the table's summary and the statistics.

use crate::cli::say::table;
use crate::settings::Build;
use crate::stats::{Eyes, FrameStats, FullEstimate, Memory, Totals};
use crate::stereo::Eye;

/// Costs of the frames of a run.
#[derive(Default)]
pub struct Record {
    /// Frames that were written.
    pub frames: Vec<FrameStats>,
    /// Frames of the run-up.
    pub run_up: Vec<FrameStats>,
    full: Option<FullEstimate>,
    full_rays: f64,
}

impl Record {
    /// Keeps `stats`; returns the estimate that goes with the frame.
    pub fn add(&mut self, stats: &FrameStats, written: bool) -> Option<FullEstimate> {
        self.full = FullEstimate::from_base(stats).or(self.full);
        if written {
            self.full_rays += self.full.map_or(0.0, |full| full.rays(stats));
            self.frames.push(stats.clone());
        } else {
            self.run_up.push(stats.clone());
        }
        self.full
    }

    /// Sums of the frames that were written.
    pub fn totals(&self) -> Totals {
        Totals::new(&self.frames)
    }

    /// Summary below the table of frames.
    pub fn summary(&self, memory: Memory, (build, build_seconds): (Build, f64), wall_seconds: f64) -> String {
        let run_up = Totals::new(&self.run_up);
        table::summary(&table::Summary {
            frames: self.frames.iter().filter(|frame| frame.eye != Some(Eye::Right)).count(),
            eyes: Eyes::new(&self.frames),
            totals: &self.totals(),
            full_rays: self.full_rays,
            run_up: (!self.run_up.is_empty()).then_some((self.run_up.len(), &run_up)),
            memory,
            build,
            build_seconds,
            wall_seconds,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{RayCounts, SampleCounts};

    fn stats(base: u64, good: u64, shadow: u64) -> FrameStats {
        FrameStats {
            samples: SampleCounts { base, good, ..SampleCounts::default() },
            rays: RayCounts { primary: base, verification: good, shadow, ..RayCounts::default() },
            ..FrameStats::default()
        }
    }

    #[test]
    fn run_up_is_apart_but_its_base_frame_serves_the_estimate() {
        let mut record = Record::default();
        record.add(&stats(10, 0, 20), false);
        let full = record.add(&stats(0, 10, 5), true);
        assert_eq!((record.frames.len(), record.run_up.len()), (1, 1));
        assert_eq!((full.is_some(), record.full_rays), (true, 30.0));
        assert_eq!(record.totals().samples.base, 0);
        assert!(record.summary(Memory::default(), (Build::Best, 0.0), 1.0).contains("about 50.0 %"));
    }
}
