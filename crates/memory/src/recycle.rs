//! Vectors whose memory outlives what they hold.

/// Empties a vector for items that differ from the old ones only in their lifetimes, and keeps its memory: what a loop
/// borrows anew in each turn then costs no allocation.
///
/// ```
/// # use trochoid_memory::emptied;
/// let mut spare: Vec<&'static [f32]> = Vec::with_capacity(8);
/// for turn in 0..3 {
///     let row = vec![turn as f32; 4];
///     let mut rows: Vec<&[f32]> = emptied(spare);
///     rows.push(&row);
///     spare = emptied(rows);
///     assert_eq!(spare.capacity(), 8);
/// }
/// ```
pub fn emptied<A, B>(mut items: Vec<A>) -> Vec<B> {
    const { assert!(size_of::<A>() == size_of::<B>() && align_of::<A>() == align_of::<B>()) };
    items.clear();
    // Collected in place.
    items.into_iter().map(|_| unreachable!("it was emptied")).collect()
}
