//! The memory limit: by default a share of what is free, and the last words where it is reached.

use std::{
    fs,
    io::{self, IsTerminal as _, Write as _},
    path::Path,
    process,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
};

use sheer_core::text::{MemorySize, quoted};

use crate::{
    allocator::{self, Shortage},
    output, video,
};

/// What may be taken of free memory if the user says nothing, in quarters: the rest is for others, and for
/// what the system keeps of files.
const QUARTERS: u64 = 3;

/// What counts as free on systems that are not asked: less than machines have on which people render.
const UNKNOWN_BYTES: u64 = 8 << 30;

/// The limit in bytes, and what is being done: for the last words.
static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);
static TASK: Mutex<String> = Mutex::new(String::new());

/// Makes a failed allocation an error: a message and exit code 1.
pub(crate) fn end_when_exhausted() {
    allocator::end_with(end);
}

/// Limits what the program takes: to what was asked for, or to a share of what is free.
pub(crate) fn limit(asked_for: Option<MemorySize>) {
    let limit =
        asked_for.unwrap_or_else(|| MemorySize(free().map_or(UNKNOWN_BYTES, |free| free.0) / 4 * QUARTERS));
    LIMIT.store(limit.0, Ordering::Relaxed);
    allocator::set_limit(limit.0);
}

/// What may be taken without others having to give any up; none where the system is not asked.
pub(crate) fn free() -> Option<MemorySize> {
    free_bytes(Path::new("/")).map(MemorySize)
}

/// What the limit leaves for scenes.
pub(crate) fn left_by_the_program() -> MemorySize {
    MemorySize(LIMIT.load(Ordering::Relaxed).saturating_sub(allocator::UNCOUNTED_BYTES))
}

/// Says what is being done from now on.
pub(crate) fn start(task: &str) {
    if let Ok(mut current) = TASK.lock() {
        *current = quoted(task);
    }
}

/// The last words.
fn end(shortage: Shortage, asked_for: usize) -> ! {
    // Whoever holds one of these locks may be who has no memory.
    let task = TASK.try_lock().map(|task| task.clone()).unwrap_or_default();
    let task = if task.is_empty() { task } else { format!("{task}: ") };
    let asked_for = MemorySize(asked_for as u64);
    let problem = match shortage {
        Shortage::Limit => {
            let limit = MemorySize(LIMIT.load(Ordering::Relaxed));
            format!("the memory limit of {limit} is reached; raise --memory-limit if there is more")
        }
        Shortage::System => "the system has no memory left; end other programs".to_owned(),
    };
    output::wait_for_writing();
    let _nobody_misses_the_encoder = video::abandon();
    let mut stderr = io::stderr();
    // The bar of a terminal stays, above the message.
    let line = if stderr.is_terminal() { "\n" } else { "" };
    let _ = writeln!(
        stderr,
        "{line}sheer: error: {task}{problem}, or make scene or picture smaller (another {asked_for} were asked for)"
    );
    process::exit(1)
}

/// Bytes that may be taken without others having to give any up: of the machine, of the control groups that
/// the program is in, and of its own address space; the least of them. None where the system has no such
/// files. `root` is where its files are.
fn free_bytes(root: &Path) -> Option<u64> {
    let read = |path: &str| fs::read_to_string(root.join(path)).ok();
    let available = kilobytes(&read("proc/meminfo")?, "MemAvailable:")?;
    let groups = read("proc/self/cgroup").unwrap_or_default();
    let of_groups = groups.lines().flat_map(|line| free_of_groups(root, line));
    // The address space: what `ulimit -v` leaves.
    let of_process = || {
        let limits = read("proc/self/limits")?;
        let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
        let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
        Some(limit.saturating_sub(kilobytes(&read("proc/self/status")?, "VmSize:")?))
    };
    of_groups.chain(of_process()).chain([available]).min()
}

/// The number behind a word, in kilobytes, as bytes.
fn kilobytes(text: &str, word: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(word))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// What is free in a control group of the second or first version and in those around it. `line` is one of
/// `/proc/self/cgroup`.
fn free_of_groups(root: &Path, line: &str) -> Vec<u64> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (Some(controllers), Some(group)) = (parts.next(), parts.next()) else { return Vec::new() };
    let (base, limit_file, usage_file, cache_word) = match controllers {
        "" => ("sys/fs/cgroup", "memory.max", "memory.current", "inactive_file "),
        _ if controllers.split(',').any(|controller| controller == "memory") => {
            let base = "sys/fs/cgroup/memory";
            (base, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file ")
        }
        _ => return Vec::new(),
    };
    let base = root.join(base);
    let inside = base.join(group.trim_start_matches('/'));
    let free = |folder: &Path| -> Option<u64> {
        let read = |name: &str| fs::read_to_string(folder.join(name)).ok();
        // "max" is no limit.
        let limit: u64 = read(limit_file)?.trim().parse().ok()?;
        let usage: u64 = read(usage_file)?.trim().parse().ok()?;
        // Files that were read count as used, and are given up when memory is needed.
        let statistics = read("memory.stat").unwrap_or_default();
        let cache = statistics.lines().find_map(|line| line.strip_prefix(cache_word)?.trim().parse().ok());
        Some(limit.saturating_sub(usage.saturating_sub(cache.unwrap_or(0))))
    };
    inside.ancestors().take_while(|folder| folder.starts_with(&base)).filter_map(free).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A system that has these files.
    fn system(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        root
    }

    const MACHINE: (&str, &str) =
        ("proc/meminfo", "MemTotal:       64000000 kB\nMemAvailable:   32000000 kB\nSwapTotal: 0 kB\n");
    const AVAILABLE: u64 = 32_000_000 * 1024;

    fn free(files: &[(&str, &str)]) -> Option<u64> {
        free_bytes(system(&[&[MACHINE], files].concat()).path())
    }

    #[test]
    fn what_is_free_is_the_least_of_all_limits() {
        assert_eq!(free_bytes(system(&[]).path()), None);
        assert_eq!(free(&[]), Some(AVAILABLE));
        // The second version: a group without a limit in one with a limit, of which a part is cache.
        let second = [
            ("proc/self/cgroup", "0::/service/inner\n"),
            ("sys/fs/cgroup/service/inner/memory.max", "max\n"),
            ("sys/fs/cgroup/service/inner/memory.current", "5000\n"),
            ("sys/fs/cgroup/service/memory.max", "9000000\n"),
            ("sys/fs/cgroup/service/memory.current", "4000000\n"),
            ("sys/fs/cgroup/service/memory.stat", "anon 1\ninactive_file 1000000\n"),
        ];
        assert_eq!(free(&second), Some(6_000_000));
        // The first version, as containers see it.
        let first = [
            ("proc/self/cgroup", "7:cpu,cpuacct:/\n5:memory:/\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "8000000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "9000000\n"),
            ("sys/fs/cgroup/memory/memory.stat", "total_inactive_file 2500000\n"),
        ];
        assert_eq!(free(&first), Some(1_500_000));
        // A limit of the address space.
        let limits =
            "Limit  Soft Limit  Hard Limit  Units\nMax address space    3000000000  unlimited  bytes\n";
        let process =
            [("proc/self/limits", limits), ("proc/self/status", "VmPeak: 9 kB\nVmSize:\t 1000000 kB\n")];
        assert_eq!(free(&process), Some(3_000_000_000 - 1_024_000_000));
        let unlimited = limits.replace("3000000000", "unlimited");
        assert_eq!(free(&[("proc/self/limits", &unlimited)]), Some(AVAILABLE));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_system_says_what_is_free() {
        let free = free_bytes(Path::new("/")).unwrap();
        assert!((1 << 20..1 << 50).contains(&free), "{free}");
    }
}
