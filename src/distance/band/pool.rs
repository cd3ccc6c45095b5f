//! Scratch memory that outlives a parallel loop, for the next one.

use std::{
    ops::{Deref, DerefMut},
    sync::{Mutex, PoisonError},
};

/// Values that are costly to make, and to move; as many as were ever in use at once.
pub struct Pool<T> {
    /// Each with the thread that had it last.
    free: Mutex<Vec<(Option<usize>, Box<T>)>>,
}

impl<T> Pool<T> {
    pub fn new() -> Self {
        Self { free: Mutex::new(Vec::new()) }
    }

    /// One that is free, the one that this thread had last if that is; or a new one. It comes back when dropped.
    pub fn take(&self, make: impl FnOnce() -> T) -> Taken<'_, T> {
        let thread = rayon::current_thread_index();
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let own = free.iter().rposition(|(last, _)| *last == thread).or(free.len().checked_sub(1));
        let kept = own.map(|place| free.swap_remove(place).1);
        drop(free);
        Taken { value: Some(kept.unwrap_or_else(|| Box::new(make()))), pool: self }
    }
}

/// A value in use.
pub struct Taken<'a, T> {
    /// `None` only while it is dropped.
    value: Option<Box<T>>,
    pool: &'a Pool<T>,
}

impl<T> Deref for Taken<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value.as_ref().expect("there until dropped")
    }
}

impl<T> DerefMut for Taken<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.value.as_mut().expect("there until dropped")
    }
}

impl<T> Drop for Taken<'_, T> {
    fn drop(&mut self) {
        let given_back = self.value.take().map(|value| (rayon::current_thread_index(), value));
        self.pool.free.lock().unwrap_or_else(PoisonError::into_inner).extend(given_back);
    }
}
