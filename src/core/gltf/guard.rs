//! Calls of decoders by other authors.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// The result of a decoder for bytes of unknown origin; None if it panics. Those that are used here return errors, but
/// they are young, and a file must not end the program. All that the decoder has made is dropped then.
pub(super) fn guarded<T>(decode: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(decode)).ok()
}
