//! Memory of the process and the machine, where the system reports it (Linux).

pub(super) const GIB_PER_BYTE: f64 = 1.0 / (1024.0 * 1024.0 * 1024.0);

/// Runs `f`, and returns the peak growth of the process meanwhile in bytes.
pub(super) fn peak_of<T>(f: impl FnOnce() -> T) -> (T, Option<f64>) {
    // Resets the peak to the present size.
    let reset = std::fs::write("/proc/self/clear_refs", "5").is_ok();
    let before = field("/proc/self/status", "VmRSS:");
    let value = f();
    let peak = field("/proc/self/status", "VmHWM:");
    let grown = before.zip(peak).filter(|_| reset).map(|(before, peak)| peak - before);
    (value, grown)
}

/// Returns how much memory can be allocated without swapping.
pub(super) fn free_gib() -> Option<f64> {
    field("/proc/meminfo", "MemAvailable:").map(|bytes| bytes * GIB_PER_BYTE)
}

/// Returns the peak size of the process since the last [`peak_of`], or since its start.
pub(super) fn peak_gib() -> Option<f64> {
    field("/proc/self/status", "VmHWM:").map(|bytes| bytes * GIB_PER_BYTE)
}

/// Reads the bytes in a line such as `VmRSS:  120 kB`.
fn field(path: &str, key: &str) -> Option<f64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kib: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024.0 * kib)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_peak_counts_memory_that_was_freed_again() {
        let size = 64 << 20;
        let (sum, peak) = peak_of(|| std::hint::black_box(vec![1u8; size]).len());
        assert_eq!(sum, size);
        assert!(peak.is_none_or(|peak| peak > 0.9 * size as f64), "{peak:?}");
    }
}
