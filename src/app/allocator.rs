//! Makes the C library of Linux return memory to the system. No other module sets this.
#![allow(unsafe_code)]

/// The size in bytes above which freed allocations are returned to the system.
///
/// Left to itself glibc raises this bound to the largest piece that was ever freed, at most 32 MB. Later films,
/// textures and hierarchies below that size then come from the heaps of single threads, and allocations behind them
/// keep these heaps from shrinking: in a long session the program grew though no more memory was in use. Allocations
/// above the bound are few, so that asking the system for each costs nothing that could be measured.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const GIVEN_BACK_ABOVE: libc::c_int = 1 << 20;

/// Keeps the memory of long runs low. To be called before other threads are started.
pub fn keep_memory_low() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: `mallopt` changes a parameter of the allocator, which glibc guards by a lock of its own; it touches no
    // memory of ours. Where it fails, everything stays as it was.
    let _ = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, GIVEN_BACK_ABOVE) };
}

/// Returns freed pages in all threads' heaps to the system. It takes milliseconds for each 100 MB: to be called after
/// large data in small allocations was freed.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: `malloc_trim` moves nothing that is in use, and glibc guards it by the locks of its heaps.
    let _ = unsafe { libc::malloc_trim(0) };
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests {
    use super::*;

    /// Resident memory in kB.
    fn resident() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        line.and_then(|line| line.split_whitespace().next()?.parse().ok())
            .unwrap_or(0)
    }

    #[test]
    fn large_pieces_go_back_though_small_ones_lie_behind_them() {
        keep_memory_low();
        // Freeing this piece would raise the bound.
        drop(vec![1u8; 30 << 20]);
        let before = resident();
        let pairs: Vec<_> = (0..20).map(|_| (vec![1u8; 8 << 20], Box::new([1u8; 64]))).collect();
        let (large, small): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        let between = resident();
        drop(large);
        let after = resident();
        // 160 MB; other tests of this process run meanwhile.
        assert!(between > before + 100_000, "{before} {between}");
        assert!(after + 100_000 < between, "{between} {after}");
        assert_eq!(small.len(), 20);
    }
}
