//! Memory with random access: large pages where the system has them, and prefetches.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use memmap2::MmapMut;

/// Prefetches the cache line at the start of `value`. A mere optimisation, which does nothing on processors other than
/// x86.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    safe_arch::prefetch_t0(value);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// The bytes of cache that a core reads with little delay.
pub(super) const CACHE: usize = 4 << 20;

/// The bytes of cache that all cores share.
pub(super) const SHARED_CACHE: usize = 64 << 20;

/// A list of fixed length. A large one is in large pages, since the processor's cache of page addresses (TLB) covers
/// too few small ones.
#[derive(Debug)]
pub(super) enum Table<T> {
    Small(Vec<T>),
    Large(MmapMut, PhantomData<T>),
}

/// The size of a large page in bytes.
const LARGE: usize = 2 << 20;

impl<T: Pod> Table<T> {
    pub fn zeroed(len: usize) -> Self {
        let bytes = len * size_of::<T>();
        match (bytes >= LARGE).then(|| MmapMut::map_anon(bytes)) {
            Some(Ok(map)) => {
                // A system without large pages uses small ones.
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
