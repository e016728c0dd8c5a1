//! Prefetching: tells the processor which memory is needed soon, so that it is fetched while other work goes
//! on. Nothing but time depends on it; on processors without such an instruction, nothing happens.

/// Number of bytes that caches fetch together.
pub const LINE: usize = 64;

/// Prefetches `values`, which are read or written over soon.
#[inline(always)]
pub fn prefetch<T>(values: &[T]) {
    let in_line = (LINE / size_of::<T>()).max(1);
    values.iter().step_by(in_line).for_each(fetch);
    // if the first value is not at the beginning of its line, the last one may be in one line more
    if let [_, .., last] = values {
        fetch(last);
    }
}

/// Fetches into the second-level cache: there may be more than fits into the first.
#[cfg(all(target_arch = "x86_64", target_feature = "sse"))]
#[inline(always)]
fn fetch<T>(value: &T) {
    safe_arch::prefetch_t1(value);
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse")))]
fn fetch<T>(_: &T) {}
