//! Vectors whose memory a thread lends out again and again.

use std::alloc::{Layout, dealloc};
use std::cell::RefCell;
use std::fmt;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};

/// A vector with memory of the thread's pool, to which it returns: what is made for each tile costs no allocation once the
/// pool holds enough. [`Scratch::release`] empties the pool.
///
/// Only the memory is used again, so items may have any type and lifetime.
///
/// ```
/// use trochoid_memory::Scratch;
///
/// let samples = vec![0.25_f32; 4];
/// for _ in 0..3 {
///     let rows: Scratch<&[f32]> = samples.chunks(2).collect();
///     let sums: Scratch<f32> = rows.iter().map(|row| row.iter().sum()).collect();
///     assert_eq!(sums[..], [0.5, 0.5]);
/// }
/// Scratch::release();
/// ```
pub struct Scratch<T> {
    items: ManuallyDrop<Vec<T>>,
}

/// Memory of a vector that holds nothing.
struct Spare {
    start: *mut u8,
    /// Number of items for which there is room: not 0.
    room: usize,
}

/// Vectors of one thread whose items have the same size and alignment; the one that was used last, which is likely to be in
/// the cache, comes last.
struct Shelf {
    item: Layout,
    spare: Vec<Spare>,
}

#[derive(Default)]
struct Shelves(Vec<Shelf>);

thread_local! {
    static POOL: RefCell<Shelves> = RefCell::default();
}

impl Shelves {
    fn of(&mut self, item: Layout) -> &mut Shelf {
        let index = self.0.iter().position(|shelf| shelf.item == item).unwrap_or_else(|| {
            self.0.push(Shelf { item, spare: Vec::new() });
            self.0.len() - 1
        });
        &mut self.0[index]
    }
}

impl Shelf {
    /// Returns the last vector with room for some items, or else the last one.
    fn take(&mut self, count: usize) -> Option<Spare> {
        let last = self.spare.len().checked_sub(1)?;
        let index = self.spare.iter().rposition(|spare| spare.room >= count).unwrap_or(last);
        Some(self.spare.remove(index))
    }
}

impl Drop for Shelf {
    fn drop(&mut self) {
        for Spare { start, room } in self.spare.drain(..) {
            // It is the layout with which the vector asked for the memory, so it is not too large.
            if let Ok(layout) = Layout::from_size_align(self.item.size() * room, self.item.align()) {
                #[allow(unsafe_code)]
                // SAFETY: the memory is that of a vector with room for `room` items, which `Scratch::drop` gave up, so it came
                // from the global allocator with exactly this layout, and nothing else owns it.
                unsafe {
                    dealloc(start, layout);
                }
            }
        }
    }
}

impl Scratch<()> {
    /// Frees the memory that the pool of the current thread holds.
    pub fn release() {
        // Taken out first: the pool is not borrowed while memory is freed.
        let _ = POOL.try_with(|pool| pool.try_borrow_mut().map(|mut pool| std::mem::take(&mut *pool)));
    }
}

impl<T> Scratch<T> {
    /// Borrows an empty vector.
    pub fn new() -> Self {
        Self::with_room(0)
    }

    /// Borrows an empty vector: one with room for some items, if the pool has one.
    pub fn with_room(count: usize) -> Self {
        let layout = Layout::new::<T>();
        let take = |pool: &RefCell<Shelves>| pool.try_borrow_mut().ok()?.of(layout).take(count);
        let spare = if layout.size() == 0 { None } else { POOL.try_with(take).ok().flatten() };
        let items = match spare {
            #[allow(unsafe_code)]
            // SAFETY: the shelf holds memory of vectors whose items had this size and alignment, with room for `room` of
            // them. It was taken from the shelf, so nothing else owns it, and no item of it is used.
            Some(Spare { start, room }) => unsafe { Vec::from_raw_parts(start.cast(), 0, room) },
            None => Vec::new(),
        };
        Self { items: ManuallyDrop::new(items) }
    }

    /// Borrows a vector of `count` times the same item.
    pub fn of(item: T, count: usize) -> Self
    where
        T: Clone,
    {
        let mut all = Self::with_room(count);
        all.resize(count, item);
        all
    }
}

impl<T> Drop for Scratch<T> {
    fn drop(&mut self) {
        #[allow(unsafe_code)]
        // SAFETY: the vector is taken once, since nothing uses `self` after this.
        let mut items = unsafe { ManuallyDrop::take(&mut self.items) };
        items.clear();
        let layout = Layout::new::<T>();
        if layout.size() == 0 || items.capacity() == 0 {
            return;
        }
        let mut items = ManuallyDrop::new(items);
        let spare = Spare { start: items.as_mut_ptr().cast(), room: items.capacity() };
        let push = |pool: &RefCell<Shelves>| match pool.try_borrow_mut() {
            Ok(mut pool) => {
                pool.of(layout).spare.push(spare);
                true
            }
            Err(_) => false,
        };
        // Not while the thread ends.
        if !POOL.try_with(push).unwrap_or(false) {
            drop(ManuallyDrop::into_inner(items));
        }
    }
}

impl<T> Deref for Scratch<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.items
    }
}

impl<T> DerefMut for Scratch<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.items
    }
}

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Clone> Clone for Scratch<T> {
    fn clone(&self) -> Self {
        self.iter().cloned().collect()
    }
}

impl<T: fmt::Debug> fmt::Debug for Scratch<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: PartialEq> PartialEq for Scratch<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T> FromIterator<T> for Scratch<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let items = items.into_iter();
        let mut all = Self::with_room(items.size_hint().0);
        all.extend(items);
        all
    }
}

impl<'s, T> IntoIterator for &'s Scratch<T> {
    type Item = &'s T;
    type IntoIter = std::slice::Iter<'s, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

impl<'s, T> IntoIterator for &'s mut Scratch<T> {
    type Item = &'s mut T;
    type IntoIter = std::slice::IterMut<'s, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn memory_is_used_again_by_items_of_the_same_layout() {
        Scratch::release();
        let first = Scratch::of(1.5_f32, 100);
        let place = first.as_ptr() as usize;
        drop(first);
        // Of another size, of another alignment, and while the first is lent.
        let (wide, bytes) = (Scratch::of(7_u64, 100), Scratch::of([0_u8; 4], 100));
        assert!(wide.as_ptr() as usize != place && bytes.as_ptr() as usize != place);
        let again: Scratch<u32> = (0..50).collect();
        let other = Scratch::of(0_i32, 100);
        assert_eq!((again.as_ptr() as usize, again.len(), again[49]), (place, 50, 49));
        assert!(again.capacity() >= 100 && other.as_ptr() as usize != place);
        assert!((other.len(), &other[..3]) == (100, &[0; 3]));
    }

    #[test]
    fn items_are_dropped_and_memory_may_move_between_threads() {
        let held = Rc::new(());
        let nested: Scratch<Scratch<Rc<()>>> = (1..9).map(|count| Scratch::of(held.clone(), count)).collect();
        assert_eq!(Rc::strong_count(&held), 1 + 36);
        drop(nested);
        assert_eq!(Rc::strong_count(&held), 1);
        let there = std::thread::spawn(|| Scratch::of(1_u16, 1000)).join().unwrap();
        let place = there.as_ptr() as usize;
        drop(there);
        assert_eq!(Scratch::<u16>::new().as_ptr() as usize, place);
        Scratch::release();
        assert_eq!(Scratch::<u16>::new().capacity(), 0);
    }

    #[test]
    fn items_without_size_need_no_memory() {
        let nothing = Scratch::of((), 5);
        assert_eq!(nothing.len(), 5);
        drop(nothing);
        assert_eq!(Scratch::<()>::new().len(), 0);
        let [far, near]: [Scratch<u128>; 2] = Default::default();
        assert_eq!(far, near);
        assert_eq!(format!("{:?}", Scratch::of(2, 3)), "[2, 2, 2]");
    }
}
