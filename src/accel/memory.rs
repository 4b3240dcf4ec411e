//! Memory that is read here and there: in pages as large as the system has, and asked for some time before it is needed.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use memmap2::MmapMut;

/// Has the cache line at the start of `value` brought near. Without effect but on time, and without that on processors that are not x86.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    safe_arch::prefetch_t0(value);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Bytes of what a core has in reach without much waiting.
pub(super) const CACHE: usize = 4 << 20;

/// A list whose length stays. Of pages of the usual size a processor remembers too few to cover a large one.
#[derive(Debug)]
pub(super) enum Table<T> {
    Small(Vec<T>),
    Large(MmapMut, PhantomData<T>),
}

/// In bytes: of a large page.
const LARGE: usize = 2 << 20;

impl<T: Pod> Table<T> {
    pub fn zeroed(len: usize) -> Self {
        let bytes = len * size_of::<T>();
        match (bytes >= LARGE).then(|| MmapMut::map_anon(bytes)) {
            Some(Ok(map)) => {
                // Where there are none the usual ones will do.
                #[cfg(target_os = "linux")]
                let _ = map.advise(memmap2::Advice::HugePage);
                Self::Large(map, PhantomData)
            }
            _ => Self::Small(vec![T::zeroed(); len]),
        }
    }
}

impl<T: Pod> Clone for Table<T> {
    fn clone(&self) -> Self {
        let mut table = Self::zeroed(self.len());
        table.copy_from_slice(self);
        table
    }
}

impl<T: Pod> Deref for Table<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Small(list) => list,
            Self::Large(map, _) => bytemuck::cast_slice(map),
        }
    }
}

impl<T: Pod> DerefMut for Table<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Small(list) => list,
            Self::Large(map, _) => bytemuck::cast_slice_mut(map),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_any_size_keep_their_values() {
        for len in [0, 1, LARGE / 8 - 1, LARGE / 8, LARGE / 8 + 1] {
            let mut table = Table::<u64>::zeroed(len);
            assert!(table.len() == len && table.iter().all(|&value| value == 0));
            table.iter_mut().zip(7..).for_each(|(value, index)| *value = index);
            let copy = table.clone();
            table.fill(0);
            assert!(copy.len() == len && copy.iter().copied().eq(7..7 + len as u64));
        }
    }
}
