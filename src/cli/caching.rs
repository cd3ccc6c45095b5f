//! Where measured objects are kept between runs.

use std::path::{Path, PathBuf};

use clap::Args;

use super::paths;
use crate::bake::Bytes;
use crate::node::Cache;

/// Bytes that the cache takes at most where nobody says otherwise.
const LIMIT: u64 = 8 << 30;

/// Where measured objects are kept.
#[derive(Args, Clone, Debug)]
pub struct Caching {
    /// Folder in which measured objects are kept for later runs, shared by processes and machines; HFVDB_CACHE does the
    /// same, and nothing is kept where that is empty [default: hfvdb in the user's cache folder]
    #[arg(long, value_name = "FOLDER", value_parser = paths::path())]
    pub cache: Option<PathBuf>,

    /// Room the cache may take: what was not used for longest goes first [default: 8G]
    #[arg(long, value_name = "BYTES")]
    pub cache_size: Option<Bytes>,

    /// Measure everything anew, and keep nothing
    #[arg(long, conflicts_with_all = ["cache", "cache_size"])]
    pub no_cache: bool,
}

impl Caching {
    /// The cache, if there is to be one and this program can be told from others.
    pub fn open(&self) -> Option<Cache> {
        if self.no_cache {
            return None;
        }
        let of_environment = || match std::env::var_os("HFVDB_CACHE") {
            Some(folder) => (!folder.is_empty()).then(|| folder.into()),
            None => users_folder(),
        };
        let folder = self.cache.clone().or_else(of_environment)?;
        Some(Cache::new(folder, self.cache_size.map_or(LIMIT, |limit| limit.0), &program()?))
    }
}

/// The folder for caches of the user (XDG Base Directory Specification), where there is a user.
fn users_folder() -> Option<PathBuf> {
    let named = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let folder = named("XDG_CACHE_HOME").or_else(|| Some(named("HOME")?.join(".cache")))?;
    Some(folder.join("hfvdb"))
}

/// What tells this program from all others: the linker's identifier of its content.
fn program() -> Option<Vec<u8>> {
    let file = std::fs::File::open(Path::new("/proc/self/exe")).ok()?;
    let content = object::ReadCache::new(file);
    let program = object::File::parse(&content).ok()?;
    object::Object::build_id(&program).ok()?.map(<[u8]>::to_vec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_knows_itself() {
        assert!(program().is_some_and(|identifier| identifier.len() >= 8));
    }
}
