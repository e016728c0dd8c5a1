//! Compression of the bytes of one chunk.
//!
//! ZIP and ZIPS are done here and not by the library: OpenEXR 3.1 calls zlib, which needs twice as long
//! as zlib-rs (`examples/write_speed.rs`), and packs under a lock of the whole file.

use flate2::{Compress, Compression as Level, FlushCompress, Status};

/// State of one thread for deflating chunk after chunk.
pub(crate) struct Deflater {
    stream: Compress,
    split: Vec<u8>,
    differences: Vec<u8>,
}

impl Deflater {
    /// Creates a deflater; `level` is zlib's, 1 to 9.
    pub(crate) fn new(level: u32) -> Self {
        let stream = Compress::new(Level::new(level), true);
        Self { stream, split: Vec::new(), differences: Vec::new() }
    }

    /// Deflates the chunk into `deflated`, as ZIP and ZIPS store it. Returns false if that would not be
    /// smaller: then the file format wants the packed bytes themselves.
    pub(crate) fn deflate(&mut self, packed: &[u8], deflated: &mut Vec<u8>) -> bool {
        self.prepare(packed);
        self.stream.reset();
        deflated.clear();
        // The space ends short of the packed size: what does not fit is not worth it.
        deflated.reserve(packed.len());
        let status = self.stream.compress_vec(&self.differences, deflated, FlushCompress::Finish);
        matches!(status, Ok(Status::StreamEnd)) && deflated.len() < packed.len()
    }

    /// Reorders the bytes: first those at even places, then those at odd places, then each minus the one
    /// before it. High bytes of neighbouring samples are alike, and become runs.
    fn prepare(&mut self, packed: &[u8]) {
        let count = packed.len();
        self.split.resize(count, 0);
        self.differences.resize(count, 0);
        let (even, odd) = self.split.split_at_mut(count.div_ceil(2));
        // a loop each: compilers turn such into vector instructions
        let pairs = || packed.chunks_exact(2);
        even.iter_mut().zip(pairs()).for_each(|(even, pair)| *even = pair[0]);
        odd.iter_mut().zip(pairs()).for_each(|(odd, pair)| *odd = pair[1]);
        if let (1, Some(last)) = (count % 2, packed.last()) {
            even[count / 2] = *last;
        }
        let (Some((first, later)), Some((start, differences))) =
            (self.split.split_first(), self.differences.split_first_mut())
        else {
            return;
        };
        *start = *first;
        for ((difference, later), earlier) in differences.iter_mut().zip(later).zip(&self.split) {
            *difference = later.wrapping_sub(*earlier).wrapping_add(128);
        }
    }
}
