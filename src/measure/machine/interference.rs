//! Measures how much other work on the machine disturbed a timing.

use std::fs;
use std::ops::Add;

use serde::{Deserialize, Serialize};

/// CPU time that this process lost to others, or to its own threads if they outnumber the cores.
/// Values that the operating system does not report are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Interference {
    /// Seconds that a hypervisor took from all cores of this machine (proc_stat(5), steal).
    pub stolen: f64,
    /// Seconds during which a thread of this process was ready to run but waited for a core, summed
    /// over the threads (/proc/PID/task/TID/schedstat).
    pub waited: f64,
    /// Number of times that a thread of this process was preempted (proc_pid_status(5)).
    pub switches: u64,
}

impl Add for Interference {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            stolen: self.stolen + other.stolen,
            waited: self.waited + other.waited,
            switches: self.switches + other.switches,
        }
    }
}

impl Interference {
    /// Totals so far: stolen time since the machine booted, the other values since each of the
    /// live threads started.
    pub(crate) fn so_far() -> Self {
        let (waited, switches) = threads()
            .fold((0.0, 0), |(waited, switches), thread| (waited + thread.0, switches + thread.1));
        Self { stolen: stolen().unwrap_or(0.0), waited, switches }
    }

    /// The increase since `earlier`. It is correct only if no thread has ended in between.
    pub(crate) fn since(self, earlier: Self) -> Self {
        Self {
            stolen: (self.stolen - earlier.stolen).max(0.0),
            waited: (self.waited - earlier.waited).max(0.0),
            switches: self.switches.saturating_sub(earlier.switches),
        }
    }
}

/// Linux reports CPU times in hundredths of a second, whatever the tick rate of the kernel.
const TICKS_PER_SECOND: f64 = 100.0;

/// Stolen seconds of all cores: the eighth number after `cpu` in the first line.
fn stolen() -> Option<f64> {
    let stat = fs::read_to_string("/proc/stat").ok()?;
    Some(ticks(&stat, 1)?.nth(7)? / TICKS_PER_SECOND)
}

/// Seconds that other processes have kept cores busy since the machine booted, summed over all
/// cores, and the number of cores. Both include cores that this process may not use. Other
/// processes are all except this one and its children that have ended. Returns `None` if the
/// operating system does not report the times.
pub(crate) fn busy_seconds_of_others() -> Option<(f64, usize)> {
    let (stat, own) =
        (fs::read_to_string("/proc/stat").ok()?, fs::read_to_string("/proc/self/stat").ok()?);
    Some(((busy(&stat)? - of_process(&own)?) / TICKS_PER_SECOND, cores(&stat)))
}

/// Number of cores: the lines that start with `cpu` and a number.
fn cores(stat: &str) -> usize {
    let number = |line: &str| line.strip_prefix("cpu").is_some_and(|rest| !rest.starts_with(' '));
    stat.lines().filter(|line| number(line)).count()
}

/// The numbers of the first line, from word number `first` on.
fn ticks(stat: &str, first: usize) -> Option<impl Iterator<Item = f64>> {
    let words = stat.lines().next()?.split_whitespace().skip(first);
    Some(words.filter_map(|word| word.parse().ok()))
}

/// Busy time: user, nice, system, and both kinds of interrupts, which follow after idle and iowait
/// (proc_stat(5)).
fn busy(stat: &str) -> Option<f64> {
    let all: Vec<f64> = ticks(stat, 1)?.collect();
    [0, 1, 2, 5, 6].iter().map(|&place| all.get(place)).sum()
}

/// User and system time of the process and of its children (proc_pid_stat(5), fields 14 to 17).
/// Parsing starts after the name, field 2, because a name can contain any characters.
fn of_process(stat: &str) -> Option<f64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    Some(ticks(after_name, 11)?.take(4).sum())
}

/// Seconds waited and number of preemptions of each thread.
fn threads() -> impl Iterator<Item = (f64, u64)> {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    tasks.map(|task| {
        let read = |name: &str| fs::read_to_string(task.path().join(name)).unwrap_or_default();
        (waited(&read("schedstat")).unwrap_or(0.0), switches(&read("status")).unwrap_or(0))
    })
}

/// Seconds waited: the second number, in nanoseconds.
fn waited(schedstat: &str) -> Option<f64> {
    let nanoseconds: u64 = schedstat.split_whitespace().nth(1)?.parse().ok()?;
    Some(nanoseconds as f64 * 1e-9)
}

fn switches(status: &str) -> Option<u64> {
    let name = "nonvoluntary_ctxt_switches:";
    status.lines().find_map(|line| line.strip_prefix(name))?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_parsed() {
        assert_eq!(waited("1203 2000000000 7\n"), Some(2.0));
        assert_eq!(waited(""), None);
        let status = "Name:\ta\nvoluntary_ctxt_switches:\t3\nnonvoluntary_ctxt_switches:\t5\n";
        assert_eq!(switches(status), Some(5));
        let stat = "cpu  10 20 30 400 50 6 7 8 9 10\ncpu0 1 2 3 4 5 6 7 8 9 10\n";
        assert_eq!(ticks(stat, 1).unwrap().nth(7), Some(8.0));
        assert_eq!(busy(stat), Some(10.0 + 20.0 + 30.0 + 6.0 + 7.0));
        assert_eq!(busy("cpu 1 2"), None);
        assert_eq!((cores(stat), cores("cpu 1\ncpu0 1\ncpu1 1\nintr 9\n")), (1, 2));
        let own = "1 (a) b) R 2 3 4 5 6 7 8 9 10 11 14 15 16 17 18 19";
        assert_eq!(of_process(own), Some(14.0 + 15.0 + 16.0 + 17.0));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn threads_that_outnumber_the_cores_are_preempted() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let (before, seen) = (Interference::so_far(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            for _ in 0..4 * cores {
                scope.spawn(|| {
                    while !seen.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                });
            }
            // Four threads per core cannot all run without being preempted.
            for _ in 0..10_000 {
                std::thread::sleep(std::time::Duration::from_millis(10));
                if Interference::so_far().since(before).switches > 0 {
                    seen.store(true, Ordering::Relaxed);
                    return;
                }
            }
            seen.store(true, Ordering::Relaxed);
            panic!("{:?}", Interference::so_far().since(before));
        });
    }
}
