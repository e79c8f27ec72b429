//! Time of the processor that threads have had (Linux; 0 elsewhere): other load does not count in it.

/// Nanoseconds of the processor that this thread has had.
pub(crate) fn own_ns() -> u64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let had = stat.split_whitespace().next().and_then(|s| s.parse().ok());
    had.unwrap_or(0)
}

/// Nanoseconds of the processor that workers have had, all together.
pub(crate) fn worker_ns() -> u64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else {
        return 0;
    };
    tasks
        .flatten()
        .filter(|t| {
            std::fs::read_to_string(t.path().join("comm"))
                .is_ok_and(|name| name.starts_with("relievo-worker"))
        })
        .filter_map(|t| std::fs::read_to_string(t.path().join("schedstat")).ok())
        .filter_map(|s| s.split_whitespace().next()?.parse::<u64>().ok())
        .sum()
}
