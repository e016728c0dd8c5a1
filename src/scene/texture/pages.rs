//! Texels of pictures that would take too much memory: they are in a file, in pages, of which those that were asked for last are held.
//!
//! A page is a square of a level. Filtered textures ask few of them: those of the level that fits each place. What a page holds does
//! not depend on when it is read, so pictures are the same with any budget.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock, Weak};

use half::f16;
use serde::Serialize;

use super::texel::Texel;

/// Texels along the edge of a page.
const EDGE: usize = 64;

/// Budget where nobody sets one.
const DEFAULT_BUDGET: u64 = 512 << 20;

/// A file of pages, and the pages that are held. The file has no name, and goes with the last picture in it.
#[derive(Debug)]
pub struct Pager {
    file: File,
    /// End of the file.
    end: AtomicU64,
    budget: AtomicU64,
    held: AtomicU64,
    read: AtomicU64,
    /// Pages that are held, in the order in which they were read or last looked at.
    queue: Mutex<VecDeque<(Weak<PagedLevel>, usize)>>,
    levels: Mutex<Vec<Weak<PagedLevel>>>,
    /// First error of reading.
    fault: OnceLock<String>,
}

/// Use of a pager's pages so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct PageCounts {
    /// Bytes of all pages.
    pub bytes: u64,
    /// Bytes of those that are held.
    pub held: u64,
    /// Number of texels that were asked for.
    pub asked: u64,
    /// Number of pages that were read.
    pub read: u64,
}

/// Texels of a level, in pages.
#[derive(Debug)]
pub struct PagedLevel {
    pager: Arc<Pager>,
    /// Place of the first page in the file.
    offset: u64,
    width: usize,
    count: usize,
    /// Pages side by side.
    columns: usize,
    texel_bytes: usize,
    slots: Box<[Slot]>,
    asked: AtomicU64,
}

/// Place of a page in memory.
#[derive(Debug, Default)]
struct Slot {
    page: RwLock<Option<Box<[u8]>>>,
    /// True if it was asked for since it was last looked at.
    is_used: AtomicBool,
}

impl Pager {
    /// Creates a file without pages in the folder for temporary files.
    ///
    /// # Errors Those of the system.
    pub fn new() -> io::Result<Arc<Self>> {
        Ok(Arc::new(Self {
            file: tempfile::tempfile()?,
            end: AtomicU64::new(0),
            budget: AtomicU64::new(DEFAULT_BUDGET),
            held: AtomicU64::new(0),
            read: AtomicU64::new(0),
            queue: Mutex::default(),
            levels: Mutex::default(),
            fault: OnceLock::new(),
        }))
    }

    /// Writes a level of `width` x `height` texels, `bytes` row by row, behind all others. One thread at a time calls it.
    ///
    /// # Errors Those of the system: a full disk.
    pub fn store(
        self: &Arc<Self>,
        [width, height]: [u32; 2],
        texel_bytes: usize,
        bytes: &[u8],
    ) -> io::Result<Arc<PagedLevel>> {
        let (width, height) = (width as usize, height as usize);
        let [columns, rows] = [width, height].map(|edge| edge.div_ceil(EDGE));
        let offset = self.end.load(Ordering::Relaxed);
        let mut page = vec![0; EDGE * EDGE * texel_bytes];
        let mut file = &self.file;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            page.fill(0);
            let across = EDGE.min(width - column * EDGE);
            for y in 0..EDGE.min(height - row * EDGE) {
                let from = ((row * EDGE + y) * width + column * EDGE) * texel_bytes;
                let to = y * EDGE * texel_bytes;
                page[to..to + across * texel_bytes]
                    .copy_from_slice(&bytes[from..from + across * texel_bytes]);
            }
            file.write_all(&page)?;
        }
        let pages = columns * rows;
        self.end.store(offset + (pages * page.len()) as u64, Ordering::Relaxed);
        let slots = (0..pages).map(|_| Slot::default()).collect();
        let (pager, count, asked) = (Arc::clone(self), width * height, AtomicU64::new(0));
        let paged = Arc::new(PagedLevel { pager, offset, width, count, columns, texel_bytes, slots, asked });
        lock(&self.levels).push(Arc::downgrade(&paged));
        Ok(paged)
    }

    /// Sets the number of bytes of pages that are held. One page is always held.
    pub fn set_budget(&self, bytes: u64) {
        self.budget.store(bytes, Ordering::Relaxed);
    }

    /// Use of the pages so far.
    pub fn counts(&self) -> PageCounts {
        let levels = lock(&self.levels);
        let asked =
            levels.iter().filter_map(Weak::upgrade).map(|level| level.asked.load(Ordering::Relaxed)).sum();
        let load = |count: &AtomicU64| count.load(Ordering::Relaxed);
        PageCounts { bytes: load(&self.end), held: load(&self.held), asked, read: load(&self.read) }
    }

    /// First error of reading pages, if there was one: pictures are wrong since then.
    pub fn fault(&self) -> Option<&str> {
        self.fault.get().map(String::as_str)
    }

    /// Counts a page that was read, and lets others go that were not asked for of late, as the budget wants it.
    fn admit(&self, level: &Arc<PagedLevel>, number: usize) {
        let mut queue = lock(&self.queue);
        queue.push_back((Arc::downgrade(level), number));
        self.held.fetch_add(level.page_bytes() as u64, Ordering::Relaxed);
        while self.held.load(Ordering::Relaxed) > self.budget.load(Ordering::Relaxed) && queue.len() > 1 {
            let Some((level, number)) = queue.pop_front() else { break };
            let Some(level) = level.upgrade() else { continue };
            let slot = &level.slots[number];
            if slot.is_used.swap(false, Ordering::Relaxed) {
                queue.push_back((Arc::downgrade(&level), number));
            } else {
                *slot.page.write().unwrap_or_else(PoisonError::into_inner) = None;
                self.held.fetch_sub(level.page_bytes() as u64, Ordering::Relaxed);
            }
        }
    }
}

impl PagedLevel {
    /// Number of texels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Bytes of a texel.
    pub fn bytes_of_texel(&self) -> usize {
        self.texel_bytes
    }

    /// Pager of the pages.
    pub fn pager(&self) -> &Arc<Pager> {
        &self.pager
    }

    /// A texel, by its number.
    pub fn get(self: &Arc<Self>, texel: usize) -> Texel {
        let (x, y) = (texel % self.width, texel / self.width);
        let (number, at) = (y / EDGE * self.columns + x / EDGE, y % EDGE * EDGE + x % EDGE);
        let slot = &self.slots[number];
        self.asked.fetch_add(1, Ordering::Relaxed);
        if let Some(page) = &*slot.page.read().unwrap_or_else(PoisonError::into_inner) {
            // most pages in use are marked already: a write would take the line from other threads
            if !slot.is_used.load(Ordering::Relaxed) {
                slot.is_used.store(true, Ordering::Relaxed);
            }
            return self.texel_of(page, at);
        }
        let mut page = slot.page.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(page) = &*page {
            // another thread has read it meanwhile
            return self.texel_of(page, at);
        }
        let read = self.read(number);
        let texel = self.texel_of(&read, at);
        *page = Some(read);
        drop(page);
        self.pager.admit(self, number);
        texel
    }

    fn page_bytes(&self) -> usize {
        EDGE * EDGE * self.texel_bytes
    }

    fn read(&self, number: usize) -> Box<[u8]> {
        let mut page = vec![0; self.page_bytes()].into_boxed_slice();
        let offset = self.offset + (number * self.page_bytes()) as u64;
        if let Err(error) = self.pager.file.read_exact_at(&mut page, offset) {
            let _ = self.pager.fault.set(format!("the file of texture pages cannot be read: {error}"));
        }
        self.pager.read.fetch_add(1, Ordering::Relaxed);
        page
    }

    fn texel_of(&self, page: &[u8], at: usize) -> Texel {
        let bytes = &page[at * self.texel_bytes..(at + 1) * self.texel_bytes];
        match *bytes {
            [r, g, b, a] => Texel::Bytes([r, g, b, a]),
            _ => Texel::Halves(std::array::from_fn(|channel| {
                f16::from_ne_bytes([bytes[2 * channel], bytes[2 * channel + 1]])
            })),
        }
    }
}

/// Pages are equal if they are the same ones.
impl PartialEq for PagedLevel {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    const SIZE: [u32; 2] = [150, 70];
    const COUNT: usize = 150 * 70;

    /// Bytes of texels, each another one.
    fn texels() -> Vec<[u8; 4]> {
        (0..COUNT as u32).map(|i| [i as u8, (i >> 8) as u8, 7, 255]).collect()
    }

    fn stored(pager: &Arc<Pager>) -> Arc<PagedLevel> {
        pager.store(SIZE, 4, texels().as_flattened()).unwrap()
    }

    fn assert_holds(paged: &Arc<PagedLevel>, texel: usize) {
        assert_eq!(paged.get(texel), Texel::Bytes(texels()[texel]), "{texel}");
    }

    #[test]
    fn pages_hold_what_was_stored() {
        let pager = Pager::new().unwrap();
        let levels = [(); 2].map(|()| stored(&pager));
        let halves: Vec<[f16; 4]> =
            texels().iter().map(|texel| texel.map(f32::from).map(f16::from_f32)).collect();
        let of_halves = pager.store(SIZE, 8, bytemuck::cast_slice(&halves)).unwrap();
        pager.set_budget(0);
        for texel in (0..COUNT).step_by(37) {
            levels.iter().for_each(|level| assert_holds(level, texel));
            assert_eq!(of_halves.get(texel), Texel::Halves(halves[texel]));
        }
        assert_eq!(pager.fault(), None);
    }

    #[test]
    fn no_more_is_held_than_the_budget() {
        let pager = Pager::new().unwrap();
        let paged = stored(&pager);
        let page = (EDGE * EDGE * 4) as u64;
        assert_eq!(pager.counts(), PageCounts { bytes: 6 * page, ..PageCounts::default() });
        pager.set_budget(2 * page);
        // corners of the six pages, twice
        let corners = [0, 70, 149, 65 * 150, 65 * 150 + 70, 65 * 150 + 149].repeat(2);
        corners.into_iter().for_each(|texel| assert_holds(&paged, texel));
        let PageCounts { held, asked, read, .. } = pager.counts();
        assert!(held <= 2 * page && asked == 12 && read > 6, "{held} {asked} {read}");
        pager.set_budget(6 * page);
        let asks = || (0..COUNT).step_by(13).for_each(|texel| assert_holds(&paged, texel));
        asks();
        let read = pager.counts().read;
        asks();
        assert_eq!((pager.counts().read, pager.counts().held), (read, 6 * page), "all are held");
    }

    #[test]
    fn many_threads_see_the_same() {
        let pager = Pager::new().unwrap();
        let paged = stored(&pager);
        pager.set_budget(EDGE as u64);
        std::thread::scope(|scope| {
            for thread in 0..4 {
                let paged = &paged;
                scope.spawn(move || {
                    (0..2000)
                        .map(|i| (i * 7919 + thread * 1001) % COUNT)
                        .for_each(|texel| assert_holds(paged, texel));
                });
            }
        });
    }
}
