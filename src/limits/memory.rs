//! How much memory the process may use.

use std::fs;
use std::path::Path;

/// That of the machine or of the process's control groups, whichever is least, in bytes; without a limit
/// where the operating system does not tell.
pub(super) fn of_process() -> u64 {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| total(&text));
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = groups.lines().find_map(|line| line.strip_prefix("0::/"));
    let root = Path::new("/sys/fs/cgroup");
    let folder = root.join(group.unwrap_or_default());
    let within = folder.ancestors().take_while(|folder| folder.starts_with(root));
    let limits = within.filter_map(|folder| {
        fs::read_to_string(folder.join("memory.max")).ok()?.trim().parse().ok()
    });
    limits.chain(machine).min().unwrap_or(u64::MAX)
}

/// The machine's memory by the text of `/proc/meminfo`.
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
}
