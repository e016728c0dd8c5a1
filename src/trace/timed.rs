//! A clock around a tracer: the time that rays take, by kind.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use super::{Coherence, HitBatch, Occluders, Purpose, RayBatch, Search, Tracer};
use crate::stats::TracingSeconds;

/// Passes rays to another tracer and adds up the time. The kind of a ray is inferred from the frame loop's
/// call: a coherent search for the closest hit is one for primary rays.
///
/// The clock is read twice a batch, which is nothing beside up to a thousand rays.
pub struct Timed<'a> {
    tracer: &'a dyn Tracer,
    primary: AtomicU64,
    verification: AtomicU64,
    shadow: AtomicU64,
    bounced: AtomicU64,
}

impl<'a> Timed<'a> {
    /// Starts with no time spent.
    pub fn new(tracer: &'a dyn Tracer) -> Self {
        let [primary, verification, shadow, bounced] = [const { AtomicU64::new(0) }; 4];
        Self { tracer, primary, verification, shadow, bounced }
    }

    /// Time spent so far, on all threads together.
    pub fn seconds(&self) -> TracingSeconds {
        let of = |nanoseconds: &AtomicU64| nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9;
        TracingSeconds {
            primary: of(&self.primary),
            verification: of(&self.verification),
            shadow: of(&self.shadow),
            bounced: of(&self.bounced),
        }
    }
}

fn clocked(nanoseconds: &AtomicU64, work: impl FnOnce()) {
    let start = Instant::now();
    work();
    let spent = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
    nanoseconds.fetch_add(spent, Ordering::Relaxed);
}

impl Tracer for Timed<'_> {
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let kind = match search.coherence {
            Coherence::Coherent => &self.primary,
            Coherence::Bounced | Coherence::SharedOrigin | Coherence::Incoherent => &self.bounced,
        };
        clocked(kind, || self.tracer.closest(rays, search, hits));
    }

    fn blocked(
        &self,
        rays: &RayBatch,
        by: Occluders,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    ) {
        let kind = match (purpose, coherence) {
            // rays to the sky, off rough surfaces
            (Purpose::Sight, Coherence::Incoherent) => &self.bounced,
            (Purpose::Sight, _) => &self.verification,
            (Purpose::Shadow | Purpose::LinkedShadow(_), _) => &self.shadow,
        };
        clocked(kind, || self.tracer.blocked(rays, by, purpose, coherence, blocked));
    }
}
