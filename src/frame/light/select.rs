//! Lists of what random numbers have chosen.

/// Lists in `selected` the numbers below `count` that are wanted. Where chance decides that, no processor foresees it: a loop over
/// this list is faster than one that asks for each number.
#[inline(always)]
pub fn select(selected: &mut Vec<u32>, count: usize, is_wanted: impl Fn(usize) -> bool) {
    selected.resize(count, 0);
    let mut used = 0;
    for number in 0..count {
        // written over by the next one if it is not wanted
        selected[used] = number as u32;
        used += usize::from(is_wanted(number));
    }
    selected.truncate(used);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_wanted_is_listed_in_order() {
        let mut selected = vec![7; 20];
        select(&mut selected, 10, |number| number % 3 == 0);
        assert_eq!(selected, [0, 3, 6, 9]);
        select(&mut selected, 3, |number| number == 2);
        assert_eq!(selected, [2]);
        select(&mut selected, 5, |_| true);
        assert_eq!(selected, [0, 1, 2, 3, 4]);
        select(&mut selected, 0, |_| true);
        assert!(selected.is_empty());
    }
}
