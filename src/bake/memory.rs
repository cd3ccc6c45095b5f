//! How much memory a job may take: asked for by the user, or most of what the system has left.

use std::fmt;
use std::fs;
use std::str::FromStr;

/// A number of bytes, read from texts such as `8G`, `512M` or `2GiB`; printed with a binary unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 7] = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        let mut value = self.0 as f64;
        let mut unit = 0;
        while value >= 1024.0 && unit + 1 < UNITS.len() {
            value /= 1024.0;
            unit += 1;
        }
        if unit == 0 { write!(f, "{} bytes", self.0) } else { write!(f, "{value:.1} {}", UNITS[unit]) }
    }
}

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is no amount of memory; write one such as 8G, 512M or 2.5GiB");
        let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        let number = text[..split].parse::<f64>().map_err(|_| wrong())?;
        let power = match text[split..].trim().to_ascii_lowercase().as_str() {
            "" | "b" => 0,
            "k" | "kb" | "kib" => 1,
            "m" | "mb" | "mib" => 2,
            "g" | "gb" | "gib" => 3,
            "t" | "tb" | "tib" => 4,
            _ => return Err(wrong()),
        };
        let bytes = number * 1024f64.powi(power);
        if bytes < 1.0 || bytes >= u64::MAX as f64 {
            return Err(wrong());
        }
        Ok(Self(bytes as u64))
    }
}

/// What a job may take where nobody says otherwise: 80 % of the least of free memory, what the control group has
/// left, and the address-space limit of the process.
pub fn default_limit() -> Bytes {
    let least = [free_memory(), cgroup_memory(), address_space()].into_iter().flatten().min();
    Bytes(least.unwrap_or(u64::MAX) / 5 * 4)
}

/// `MemAvailable` of /proc/meminfo.
fn free_memory() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    Some(kib * 1024)
}

/// What the least limit of this process's control groups (version 2, or 1) leaves.
fn cgroup_memory() -> Option<u64> {
    let number = |path: String| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let text = fs::read_to_string("/proc/self/cgroup").ok()?;
    let mut least = None;
    for line in text.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (fields.next(), fields.next()) else { continue };
        let (root, limit, used) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max", "memory.current"),
            "memory" => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes"),
            _ => continue,
        };
        // A limit of any group above holds too.
        for path in std::path::Path::new(group).ancestors() {
            let folder = format!("{root}{}", path.display());
            let left = number(format!("{folder}/{limit}"))
                .map(|limit| limit.saturating_sub(number(format!("{folder}/{used}")).unwrap_or(0)));
            least = [least, left].into_iter().flatten().min();
        }
    }
    least
}

/// The address-space limit less what is mapped already.
fn address_space() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    let pages = fs::read_to_string("/proc/self/statm").ok()?.split(' ').next()?.parse::<u64>().ok()?;
    Some(limit.saturating_sub(pages * rustix::param::page_size() as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_and_printed() {
        assert_eq!("8G".parse(), Ok(Bytes(8 << 30)));
        assert_eq!("1.5 MiB".parse(), Ok(Bytes(3 << 19)));
        assert_eq!("77".parse(), Ok(Bytes(77)));
        for wrong in ["", "G", "-1G", "0", "8X", "1e9", "99999999999999T", "1.2.3G"] {
            assert!(wrong.parse::<Bytes>().is_err(), "{wrong}");
        }
        assert_eq!(Bytes(3 << 29).to_string(), "1.5 GiB");
    }

    #[test]
    fn the_default_is_below_what_is_free() {
        let limit = default_limit().0;
        assert!(limit > 0 && limit <= free_memory().unwrap_or(u64::MAX));
    }
}
