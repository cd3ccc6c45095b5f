//! How much memory a job may take where nobody says: most of what the system, its control groups and the limits of the
//! process leave.

use std::fs;
use std::path::{Path, PathBuf};

use rustix::process::{Resource, getrlimit};

use super::Bytes;

/// 80 % of the least of: free memory, what the control groups of the process (version 1 or 2) leave, and what its
/// limits of address space and of data leave. No limit where nothing of this can be told.
pub fn default_limit() -> Bytes {
    let resource = |resource| getrlimit(resource).current;
    let limits = Limits { address_space: resource(Resource::As), data: resource(Resource::Data) };
    share(left(Path::new("/"), &limits))
}

/// Limits of the process, in bytes; `None` where there is none.
struct Limits {
    /// `RLIMIT_AS`, as `ulimit -v` sets it: all that is mapped.
    address_space: Option<u64>,
    /// `RLIMIT_DATA`, as `ulimit -d` sets it: what is mapped and written by the process alone.
    data: Option<u64>,
}

/// The share of what is left that a job may take: the rest is for what estimates do not see.
fn share(left: Option<u64>) -> Bytes {
    Bytes(left.unwrap_or(u64::MAX) / 5 * 4)
}

/// What is left, with the system's files (`proc`, `sys`) under a folder.
fn left(root: &Path, limits: &Limits) -> Option<u64> {
    let status = fs::read_to_string(root.join("proc/self/status")).unwrap_or_default();
    let of_process =
        |limit: Option<u64>, used: &str| limit.map(|limit| limit.saturating_sub(kibibytes(&status, used).unwrap_or(0)));
    let free = fs::read_to_string(root.join("proc/meminfo")).ok();
    let free = free.and_then(|text| kibibytes(&text, "MemAvailable:"));
    let address_space = of_process(limits.address_space, "VmSize:");
    let data = of_process(limits.data, "VmData:");
    [free, control_groups(root), address_space, data].into_iter().flatten().min()
}

/// A line such as `MemAvailable:   1024 kB`, in bytes.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kibibytes| kibibytes.saturating_mul(1024))
}

/// What the least limit of the process's control groups leaves.
fn control_groups(root: &Path) -> Option<u64> {
    let text = fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mut least = None;
    for line in text.lines() {
        // 0::/group of version 2, 5:memory,hugetlb:/group of version 1.
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (fields.next(), fields.next()) else { continue };
        let files = match controllers {
            "" => &VERSION_2,
            _ if controllers.split(',').any(|controller| controller == "memory") => &VERSION_1,
            _ => continue,
        };
        // A limit of any group above holds too. In a container the group's own folder may stand at the top.
        for group in Path::new(group.trim_start_matches('/')).ancestors() {
            least = [least, files.left(&root.join(files.folder).join(group))].into_iter().flatten().min();
        }
    }
    least
}

/// Where a version of control groups keeps its numbers.
struct GroupFiles {
    folder: &'static str,
    limit: &'static str,
    used: &'static str,
    /// The entry of `memory.stat` that counts pages of files not in use. They count as used, and are given back before
    /// anything fails: a farm's machine that has written frames is full of them.
    reclaimable: &'static str,
}

const VERSION_2: GroupFiles =
    GroupFiles { folder: "sys/fs/cgroup", limit: "memory.max", used: "memory.current", reclaimable: "inactive_file " };
const VERSION_1: GroupFiles = GroupFiles {
    folder: "sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    reclaimable: "total_inactive_file ",
};

impl GroupFiles {
    /// What one group leaves; `None` where it has no limit. (`max` is no number.)
    fn left(&self, group: &Path) -> Option<u64> {
        let number = |path: PathBuf| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
        let limit = number(group.join(self.limit))?;
        let used = number(group.join(self.used)).unwrap_or(0);
        let statistics = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
        let reclaimable = statistics.lines().find_map(|line| line.strip_prefix(self.reclaimable)?.trim().parse().ok());
        Some(limit.saturating_sub(used.saturating_sub(reclaimable.unwrap_or(0))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Limits = Limits { address_space: None, data: None };

    /// A system with 8000 KiB free, of these files.
    fn system(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let free = ("proc/meminfo", "MemTotal:       16000 kB\nMemAvailable:    8000 kB\n");
        for (name, text) in files.iter().chain([&free]) {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    fn left_in(files: &[(&str, &str)]) -> Option<u64> {
        left(system(files).path(), &NONE)
    }

    #[test]
    fn free_memory_where_nothing_else_limits() {
        assert_eq!(left_in(&[]), Some(8_192_000));
        assert_eq!(left_in(&[("proc/self/cgroup", "0::/\n"), ("sys/fs/cgroup/memory.max", "max\n")]), Some(8_192_000));
        assert_eq!(left_in(&[("proc/self/cgroup", "nonsense\n3:\n0::\n4:cpu:/x\n")]), Some(8_192_000));
        let empty = tempfile::tempdir().unwrap();
        assert_eq!(left(empty.path(), &NONE), None);
        assert_eq!(share(Some(1000)), Bytes(800));
        assert!(share(None).0 > 1 << 60);
    }

    #[test]
    fn groups_of_version_2_up_to_the_root() {
        let group = |limit: &'static str| {
            left_in(&[
                ("proc/self/cgroup", "0::/farm/job/step\n"),
                ("sys/fs/cgroup/farm/memory.max", "5000000\n"),
                ("sys/fs/cgroup/farm/memory.current", "2000000\n"),
                ("sys/fs/cgroup/farm/memory.stat", "anon 1500000\ninactive_file 500000\nactive_file 0\n"),
                ("sys/fs/cgroup/farm/job/memory.max", "max\n"),
                ("sys/fs/cgroup/farm/job/step/memory.max", limit),
                ("sys/fs/cgroup/farm/job/step/memory.current", "1000000\n"),
            ])
        };
        // The group two above holds: 5 MB less 2 MB in use, of which half a megabyte is given back.
        assert_eq!(group("9000000\n"), Some(3_500_000));
        assert_eq!(group("3000000\n"), Some(2_000_000));
        assert_eq!(group("400000\n"), Some(0), "more in use than allowed");
    }

    #[test]
    fn groups_of_version_1() {
        let files = [
            ("proc/self/cgroup", "12:cpu:/x\n5:memory,hugetlb:/slurm/job_7\n0::/\n"),
            ("sys/fs/cgroup/memory/slurm/job_7/memory.limit_in_bytes", "4000000\n"),
            ("sys/fs/cgroup/memory/slurm/job_7/memory.usage_in_bytes", "1000000\n"),
            ("sys/fs/cgroup/memory/slurm/job_7/memory.stat", "inactive_file 9\ntotal_inactive_file 200000\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n"),
            ("sys/fs/cgroup/cpu/x/memory.limit_in_bytes", "1\n"),
        ];
        assert_eq!(left_in(&files), Some(3_200_000));
        // In a container the group's path is that of the machine, and its files stand at the top.
        let files = [
            ("proc/self/cgroup", "5:memory:/docker/abc\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "4000000\n"),
        ];
        assert_eq!(left_in(&files), Some(4_000_000));
    }

    #[test]
    fn limits_of_the_process() {
        let system = system(&[("proc/self/status", "Name:\thfvdb\nVmSize:\t    1000 kB\nVmData:\t     500 kB\n")]);
        let with = |address_space, data| left(system.path(), &Limits { address_space, data });
        assert_eq!(with(Some(3 << 20), None), Some((3 << 20) - 1_024_000));
        assert_eq!(with(Some(3 << 20), Some(2 << 20)), Some((2 << 20) - 512_000));
        assert_eq!(with(Some(1), None), Some(0));
    }

    #[test]
    fn the_machine_that_runs_this_has_some() {
        let limit = default_limit().0;
        assert!(limit > 0 && limit < u64::MAX / 5 * 4, "{limit}");
    }
}
