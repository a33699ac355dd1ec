//! How much memory the maps may take.

use super::args::BytesArg;

/// The bytes that were allowed, else those that are free; `None` where the system does not tell.
pub(super) fn budget(allowed: Option<BytesArg>) -> Option<u64> {
    if let Some(BytesArg(bytes)) = allowed {
        return Some(bytes);
    }
    if !sysinfo::IS_SUPPORTED_SYSTEM {
        return None;
    }
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let free = system.available_memory();
    // A container may have less than the machine.
    let free = system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory));
    (free > 0).then_some(free)
}
