//! System limits (`ulimit`) below which the program would be killed without a message.

use rustix::process::{Resource, getrlimit};

/// The smallest stack in bytes. The deepest scenes that are read fit into it.
const LEAST_STACK: u64 = 1 << 20;

/// The smallest address space in bytes, and the bytes of it for each thread's stack and heap.
const LEAST_SPACE: u64 = 1 << 30;
const SPACE_OF_THREAD: u64 = 16 << 20;

/// An error if the limits of the process are too low to begin.
pub fn check() -> Result<(), String> {
    let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u64);
    let limits = [
        (Resource::Stack, LEAST_STACK, "stack", "s"),
        (
            Resource::As,
            LEAST_SPACE + threads * SPACE_OF_THREAD,
            "address space",
            "v",
        ),
    ];
    let too_small = |(resource, least, what, option)| {
        let limit = getrlimit(resource).current?;
        (limit < least).then(|| message(limit, least, what, option))
    };
    limits.into_iter().find_map(too_small).map_or(Ok(()), Err)
}

fn message(limit: u64, least: u64, what: &str, option: &str) -> String {
    let [limit, least] = [limit, least].map(|bytes| bytes >> 10);
    format!(
        "the program may use {limit} KiB of {what}, and needs {least} at least: `ulimit -{option} {least}` raises the limit"
    )
}
