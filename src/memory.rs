//! Memory that is left for this process, and tests if something fits into it before it is begun.
//!
//! An allocation that fails ends the program at once, and the system may end a process that takes more than
//! its share. So large amounts that are known beforehand (for frames, models, textures, files) are checked
//! here first, and refused with their size and advice. The limits are those of the process (`ulimit -v`,
//! `ulimit -d`), of its control groups, and the memory that the machine has left. Without any of these there
//! is no limit.

use std::path::{Path, PathBuf};
use std::{fmt, fs};

use crate::stats::entry;

/// Reciprocal of the share that is added to the memory needed: allocators round up, and lists grow by
/// doubling.
const MARGIN: u64 = 20;

/// Limit on the memory of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Limit on addresses, `ulimit -v`: counts memory that is only reserved, too.
    AddressSpace,
    /// Limit on data, `ulimit -d`.
    Data,
    /// Limit of a container or a service.
    ControlGroup,
    /// Memory of the machine.
    Machine,
}

/// Number of bytes that are left until a limit.
pub type Headroom = (Limit, u64);

/// Something that takes memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name in messages.
    pub what: String,
    /// Its size in bytes, at most, as far as that is known.
    pub bytes: u64,
    /// Advice on needing less: one way, or several with commas between them, the best one first.
    pub remedy: &'static str,
}

impl Part {
    /// Creates a part of this name and size.
    pub fn new(what: impl Into<String>, bytes: u64, remedy: &'static str) -> Self {
        Self { what: what.into(), bytes, remedy }
    }
}

/// Memory that is needed beside that which the process has already.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Need {
    /// Parts of the memory.
    pub parts: Vec<Part>,
    /// Addresses, in bytes, that libraries reserve and hardly touch: they count against
    /// [`Limit::AddressSpace`], and the first part of them against [`Limit::Data`].
    pub reserved: [u64; 2],
}

/// Reason why something is not begun.
#[derive(Debug, Clone, PartialEq)]
pub struct TooLittle {
    need: Need,
    left: Headroom,
}

impl Need {
    /// Need of one part alone.
    pub fn new(part: Part) -> Self {
        Self { parts: vec![part], ..Self::default() }
    }

    /// Sum of this and `other`, needed at the same time; threads of libraries serve both.
    pub fn and(mut self, other: Self) -> Self {
        for part in other.parts {
            match self.parts.iter_mut().find(|known| known.what == part.what) {
                Some(known) => known.bytes = known.bytes.saturating_add(part.bytes),
                None => self.parts.push(part),
            }
        }
        let ([data, addresses], [more, others]) = (self.reserved, other.reserved);
        Self { reserved: [data.saturating_add(more), addresses.max(others)], ..self }
    }

    /// Bytes of all parts.
    pub fn bytes(&self) -> u64 {
        self.parts.iter().fold(0, |sum, part| sum.saturating_add(part.bytes))
    }

    /// Checks that it fits into the memory left.
    pub fn check(&self, left: &[Headroom]) -> Result<(), TooLittle> {
        let bytes = self.bytes();
        let wanted = |limit: Limit| {
            let [data, addresses] = self.reserved;
            let reserved = match limit {
                Limit::AddressSpace => data.saturating_add(addresses),
                Limit::Data => data,
                // the estimate may be a fifth too large, and the memory left for these limits is an estimate
                // itself
                Limit::ControlGroup | Limit::Machine => return bytes - bytes / 6,
            };
            bytes.saturating_add(bytes / MARGIN).saturating_add(reserved)
        };
        let too_little = left.iter().filter(|(limit, left)| wanted(*limit) > *left);
        match too_little.max_by_key(|(limit, left)| wanted(*limit) - *left) {
            None => Ok(()),
            Some(left) => Err(TooLittle { need: self.clone(), left: *left }),
        }
    }
}

impl fmt::Display for TooLittle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MOST_NAMED: usize = 3;
        /// Reciprocal of the share of a part from which on its advice is given.
        const LEAST_REMEDIED: u64 = 10;
        let mut parts: Vec<&Part> = self.need.parts.iter().collect();
        parts.sort_by_key(|part| std::cmp::Reverse(part.bytes));
        parts.truncate(MOST_NAMED);
        let named: Vec<String> =
            parts.iter().map(|part| format!("{} {}", part.what, Bytes(part.bytes))).collect();
        let mut remedies: Vec<&str> = Vec::new();
        // a small part is no help
        let large = parts.iter().filter(|part| part.bytes >= self.need.bytes() / LEAST_REMEDIED);
        for remedy in large.flat_map(|part| part.remedy.split(", ")) {
            if !remedies.contains(&remedy) {
                remedies.push(remedy);
            }
        }
        let (limit, left) = self.left;
        let (needed, left) = (Bytes(self.need.bytes()), Bytes(left));
        let reserved = match (limit, self.need.reserved.iter().sum()) {
            (Limit::AddressSpace, reserved @ 1..) => format!(" and {} of addresses", Bytes(reserved)),
            _ => String::new(),
        };
        write!(f, "about {needed} of memory{reserved} are needed ({}), and ", named.join(", "))?;
        match limit {
            Limit::AddressSpace => write!(f, "{left} are left of the limit on addresses (ulimit -v)")?,
            Limit::Data => write!(f, "{left} are left of the limit on data (ulimit -d)")?,
            Limit::ControlGroup => write!(f, "{left} are left of the control group's limit")?,
            Limit::Machine => write!(f, "{left} are available")?,
        }
        let last = remedies.pop().unwrap_or("a higher limit");
        match remedies.as_slice() {
            [] => write!(f, ": try {last}"),
            others => write!(f, ": try {} or {last}", others.join(", ")),
        }
    }
}

/// Size in bytes, formatted for people.
#[derive(Debug, Clone, Copy)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MIB: u64 = 1 << 20;
        match self.0 {
            bytes if bytes >= 1024 * MIB => write!(f, "{:.1} GiB", bytes as f64 / (1024 * MIB) as f64),
            bytes => write!(f, "{} MiB", bytes.div_ceil(MIB)),
        }
    }
}

/// Memory that is left now, for each limit that exists.
pub fn left() -> Vec<Headroom> {
    let text = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let mut left = of_process(&text("/proc/self/limits"), &text("/proc/self/status"));
    left.extend(of_groups(&text("/proc/self/cgroup"), Path::new("/sys/fs/cgroup")));
    left.extend(of_machine(&text("/proc/meminfo")));
    left
}

/// Reads the limits of a process from Linux's lists of its limits and of its state.
fn of_process(limits: &str, status: &str) -> Vec<Headroom> {
    let kinds =
        [(Limit::AddressSpace, "Max address space", "VmSize:"), (Limit::Data, "Max data size", "VmData:")];
    let left = kinds.into_iter().filter_map(|(kind, name, used)| {
        let limit = limits.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?;
        Some((kind, limit.parse::<u64>().ok()?.saturating_sub(entry(status, used)?)))
    });
    left.collect()
}

/// Reads the memory that the machine has: available memory, with swap space.
fn of_machine(meminfo: &str) -> Option<Headroom> {
    let swap = entry(meminfo, "SwapFree:").unwrap_or(0);
    Some((Limit::Machine, entry(meminfo, "MemAvailable:")?.saturating_add(swap)))
}

/// Reads the limits of the control groups in `membership` (`/proc/self/cgroup`), which are mounted at `root`:
/// each may have a limit, and so may all that it is in.
fn of_groups(membership: &str, root: &Path) -> Option<Headroom> {
    let lefts = membership.lines().flat_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next().unwrap_or_default(), fields.next().unwrap_or_default());
        let (folder, version) = match controllers {
            "" => (root.to_path_buf(), &UNIFIED),
            some if some.split(',').any(|name| name == "memory") => (root.join("memory"), &SEPARATE),
            _ => return Vec::new(),
        };
        let path = Path::new(path.trim_start_matches('/'));
        // a container sees its own group where the outermost one is mounted
        path.ancestors().filter_map(|group| version.left(&folder.join(group))).collect()
    });
    lefts.min().map(|left| (Limit::ControlGroup, left))
}

/// Names of a group's files.
struct Group {
    limit: &'static str,
    used: &'static str,
    /// Entries of its `memory.stat` for files in memory and the like, which are given up where memory is
    /// short.
    cached: &'static [&'static str],
}

/// Files of version 2 of control groups.
const UNIFIED: Group = Group {
    limit: "memory.max",
    used: "memory.current",
    cached: &["inactive_file ", "active_file ", "slab_reclaimable "],
};

/// Files of version 1.
const SEPARATE: Group = Group {
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    cached: &["total_inactive_file ", "total_active_file "],
};

impl Group {
    /// Number of bytes that are left in the group at `folder`; `None` without a limit.
    fn left(&self, folder: &Path) -> Option<u64> {
        let text = |name: &str| fs::read_to_string(PathBuf::from(folder).join(name)).ok();
        let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
        let (limit, used) = (number(self.limit)?, number(self.used)?);
        let stat = text("memory.stat").unwrap_or_default();
        let cached = self.cached.iter().filter_map(|name| {
            stat.lines().find_map(|line| line.strip_prefix(name))?.trim().parse::<u64>().ok()
        });
        Some(limit.saturating_sub(used.saturating_sub(cached.sum())))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    const MIB: u64 = 1 << 20;

    #[test]
    fn the_limits_of_the_process_count_what_it_has() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max data size             unlimited            unlimited            bytes     \n\
                      Max address space         1048576              unlimited            bytes     \n";
        let status = "VmPeak:\t 900 kB\nVmSize:\t     600 kB\nVmData:\t     100 kB\n";
        assert_eq!(of_process(limits, status), [(Limit::AddressSpace, 424 * 1024)]);
        let data = limits.replace("size             unlimited", "size             51200    ");
        assert_eq!(of_process(&data, status)[1], (Limit::Data, 0), "more than the limit is used");
        assert_eq!(of_process("", status), []);
    }

    #[test]
    fn the_machine_has_what_is_available_and_swap() {
        let meminfo = "MemTotal:  24684092 kB\nMemAvailable:   1000 kB\nSwapFree:        24 kB\n";
        assert_eq!(of_machine(meminfo), Some((Limit::Machine, MIB)));
        assert_eq!(of_machine(""), None);
    }

    #[test]
    fn the_least_of_all_groups_counts() {
        let root = tempfile::tempdir().unwrap();
        let group = |path: &str, files: &[(&str, &str)]| {
            let folder = root.path().join(path);
            fs::create_dir_all(&folder).unwrap();
            files.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
        };
        group("a/b", &[("memory.max", "max\n"), ("memory.current", "10\n")]);
        group("a", &[("memory.max", "5000\n"), ("memory.current", "3000\n")]);
        let left = |membership: &str| of_groups(membership, root.path());
        assert_eq!(left("0::/a/b\n"), Some((Limit::ControlGroup, 2000)));
        group("a", &[("memory.stat", "anon 1\ninactive_file 300\nactive_file 200\n")]);
        assert_eq!(left("0::/a/b\n"), Some((Limit::ControlGroup, 2500)), "files in memory may go");
        assert_eq!(left("0::/\n"), None);

        let files = [("memory.limit_in_bytes", "900\n"), ("memory.usage_in_bytes", "100\n")];
        group("memory/docker/x", &files);
        let both = "9:name=systemd:/docker/x\n4:memory,hugetlb:/docker/x\n0::/a/b\n";
        assert_eq!(left(both), Some((Limit::ControlGroup, 800)));
        group("memory", &[("memory.limit_in_bytes", "500\n"), ("memory.usage_in_bytes", "100\n")]);
        assert_eq!(left("4:memory:/elsewhere\n"), Some((Limit::ControlGroup, 400)), "in a container");
    }

    #[test]
    fn what_does_not_fit_is_told_with_what_is_large_and_what_to_do() {
        let part = |what: &str, mib: u64, remedy| Part::new(what, mib * MIB, remedy);
        let parts = vec![
            part("threads", 10, "fewer --threads"),
            part("samples", 1848, "a smaller --size, fewer --samples"),
            part("picture", 300, "a smaller --size, fewer --layers"),
            part("rays", 50, "a smaller model"),
        ];
        let need = Need { parts, reserved: [128 * MIB, 64 * MIB] };
        let enough = (2208 + 2208 / MARGIN + 1) * MIB;
        let cases = [
            (Limit::AddressSpace, enough + 192 * MIB),
            (Limit::Data, enough + 128 * MIB),
            (Limit::ControlGroup, 1841 * MIB),
            (Limit::Machine, 1841 * MIB),
        ];
        assert_eq!(need.check(&cases), Ok(()));
        assert_eq!(need.check(&[]), Ok(()));
        for (limit, left) in cases {
            let error = need.check(&[(Limit::Machine, u64::MAX), (limit, left - 2 * MIB)]).unwrap_err();
            assert_eq!(error.left.0, limit);
        }
        let error = need.check(&[(Limit::Data, 1300 * MIB), (Limit::ControlGroup, 100 * MIB)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "about 2.2 GiB of memory are needed (samples 1.8 GiB, picture 300 MiB, rays 50 MiB), and 100 MiB are left \
             of the control group's limit: try a smaller --size, fewer --samples or fewer --layers"
        );
    }

    #[test]
    fn there_is_room_for_this_test() {
        let little = Need::new(Part::new("this", MIB, "nothing"));
        assert_eq!(little.check(&left()), Ok(()));
        let much = Need::new(Part::new("this", u64::MAX, "nothing"));
        assert!(left().is_empty() || much.check(&left()).is_err());
    }
}
