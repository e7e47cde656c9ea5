//! Memory limits of the machine that the program runs on.

/// Returns three quarters of the memory of this machine, or of the container that the process runs in, in bytes: a
/// limit that leaves memory to other programs. 4 GiB if the system does not report its memory.
///
/// ```
/// let mut settings = trochoid::Settings::default();
/// settings.memory_limit = trochoid::memory_share();
/// assert!(settings.memory_limit > 1 << 20);
/// ```
pub fn memory_share() -> u64 {
    let memory = sysinfo::MemoryRefreshKind::nothing().with_ram();
    let system = sysinfo::System::new_with_specifics(sysinfo::RefreshKind::nothing().with_memory(memory));
    let contained = system.cgroup_limits().map(|limits| limits.total_memory);
    let total = contained.into_iter().chain([system.total_memory()]).filter(|bytes| *bytes > 0).min();
    total.map_or(4 << 30, |bytes| bytes / 4 * 3)
}
