//! Asking for memory some time before it is needed.

/// Has the cache line at the start of `value` brought near. Without effect but on time, and without that on processors that are not x86.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    safe_arch::prefetch_t0(value);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
