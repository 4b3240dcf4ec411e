//! Finds how much memory the process may use: the machine's, or less under a control group or a resource limit.

#[cfg(target_os = "linux")]
use std::path::{Path, PathBuf};

#[cfg(target_os = "linux")]
use crate::files::{LARGEST_NOTE, read_text};

/// The bytes that are assumed where the system does not report any.
const ASSUMED: u64 = 8 << 30;

/// The bytes of address space for code, stacks and the heaps of threads, most of which never become memory.
#[cfg(target_os = "linux")]
const OWN_SPACE: u64 = 512 << 20;

/// The memory that the process may use, in bytes.
pub fn memory_bytes() -> u64 {
    limits().into_iter().min().unwrap_or(ASSUMED)
}

#[cfg(not(target_os = "linux"))]
fn limits() -> Vec<u64> {
    Vec::new()
}

#[cfg(target_os = "linux")]
fn limits() -> Vec<u64> {
    use rustix::process::{Resource, getrlimit};
    let file = |path: &Path| read_text(path, LARGEST_NOTE).unwrap_or_default();
    let mut limits = Vec::from_iter(physical(&file(Path::new("/proc/meminfo"))));
    limits.extend(
        getrlimit(Resource::As)
            .current
            .map(|space| space.saturating_sub(OWN_SPACE)),
    );
    let groups = file(Path::new("/proc/self/cgroup"));
    limits.extend(group_files(&groups).iter().filter_map(|path| limit(&file(path))));
    limits
}

/// The machine's memory in bytes, from the text of `/proc/meminfo`.
#[cfg(target_os = "linux")]
fn physical(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The files with the limits of the process's control groups and all their ancestors, for both versions of control
/// groups.
#[cfg(target_os = "linux")]
fn group_files(groups: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (parts.next(), parts.next()) else {
            continue;
        };
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|one| one == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let group = Path::new(group.trim_start_matches('/'));
        files.extend(group.ancestors().map(|group| Path::new(root).join(group).join(name)));
    }
    files
}

/// Parses a limit. None if there is no limit: version 2 says `max`, version 1 a number that no machine has.
#[cfg(target_os = "linux")]
fn limit(text: &str) -> Option<u64> {
    text.trim().parse().ok().filter(|&bytes| bytes > 0)
}

#[cfg(target_os = "linux")]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_the_system_are_understood() {
        assert_eq!(
            physical("MemTotal:       24579208 kB\nMemFree: 1 kB\n"),
            Some(24_579_208 * 1024)
        );
        assert_eq!(physical("nothing"), None);
        assert_eq!(limit("max\n"), None);
        assert_eq!(limit("1073741824\n"), Some(1 << 30));
        let paths = |text| -> Vec<String> {
            let files = group_files(text);
            files.iter().map(|path| path.to_string_lossy().into_owned()).collect()
        };
        assert_eq!(
            paths("0::/a/b\n"),
            [
                "/sys/fs/cgroup/a/b/memory.max",
                "/sys/fs/cgroup/a/memory.max",
                "/sys/fs/cgroup/memory.max"
            ]
        );
        assert_eq!(
            paths("3:cpu,cpuacct:/x\n5:memory:/\nnonsense\n"),
            ["/sys/fs/cgroup/memory/memory.limit_in_bytes"]
        );
        assert!(memory_bytes() >= 1 << 20);
    }
}
