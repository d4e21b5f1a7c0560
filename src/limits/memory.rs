//! Finds out how much memory the process may use.

use std::fs;
use std::path::Path;

/// The smallest of three values, in bytes: the machine's memory, the limits on the process's
/// control groups, and the limit on its address space. `u64::MAX` if the operating system reports
/// nothing.
///
/// The amount of free memory is not used, because the same render would then be refused at one time
/// and allowed at another.
pub(super) fn of_process() -> u64 {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let machine = total(&read("/proc/meminfo"));
    let space = address_space(&read("/proc/self/limits"));
    let groups = read("/proc/self/cgroup");
    let groups = groups
        .lines()
        .filter_map(group)
        .filter_map(|(root, group, file)| of_group(Path::new(root), group, file));
    groups.chain(machine).chain(space).min().unwrap_or(u64::MAX)
}

/// Parses a line of `/proc/self/cgroup`, version 2 or 1. Returns the mount point of the hierarchy,
/// the path of the group in it, and the name of the file with its memory limit; `None` if the line
/// is not about memory.
fn group(line: &str) -> Option<(&'static str, &str, &'static str)> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (kinds, group) = (parts.next()?, parts.next()?.strip_prefix('/')?);
    match kinds {
        "" => Some(("/sys/fs/cgroup", group, "memory.max")),
        _ if kinds.split(',').any(|kind| kind == "memory") => {
            Some(("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes"))
        }
        _ => None,
    }
}

/// The smallest limit in the files called `file` of a group and its ancestors.
fn of_group(root: &Path, group: &str, file: &str) -> Option<u64> {
    let folder = root.join(group);
    let within = folder.ancestors().take_while(|folder| folder.starts_with(root));
    let limits = within.filter_map(|folder| {
        fs::read_to_string(folder.join(file)).ok()?.trim().parse::<u64>().ok()
    });
    limits.min()
}

/// The soft limit on the address space from the text of `/proc/self/limits`; `None` if it is
/// unlimited.
fn address_space(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The machine's memory in bytes, from the text of `/proc/meminfo`.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read() {
        let text = "MemTotal:        8123456 kB\nMemFree:          123 kB\n";
        assert_eq!(total(text), Some(8_123_456 * 1024));
        assert_eq!(total("MemFree: 1 kB\n"), None);
        assert!(of_process() > 1 << 20);
    }

    #[test]
    fn limits_of_groups_and_address_spaces_are_read() {
        let old = ("/sys/fs/cgroup/memory", "job/step", "memory.limit_in_bytes");
        assert_eq!(group("7:memory:/job/step"), Some(old));
        assert_eq!(group("0::/job:1"), Some(("/sys/fs/cgroup", "job:1", "memory.max")));
        assert_eq!((group("12:cpu,cpuacct:/a"), group("3:memory"), group("")), (None, None, None));

        let root = tempfile::tempdir().unwrap();
        let group = root.path().join("job/step");
        fs::create_dir_all(&group).unwrap();
        fs::write(group.join("memory.max"), "max\n").unwrap();
        assert_eq!(of_group(root.path(), "job/step", "memory.max"), None);
        fs::write(root.path().join("job/memory.max"), "1048576\n").unwrap();
        assert_eq!(of_group(root.path(), "job/step", "memory.max"), Some(1 << 20));

        let line =
            "Max address space         65536                unlimited            bytes     \n";
        assert_eq!(address_space(&format!("Limit  Soft\n{line}")), Some(65_536));
        assert_eq!(address_space(&line.replace("65536", "unlimited")), None);
    }
}
