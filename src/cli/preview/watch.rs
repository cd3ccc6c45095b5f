//! A picture that follows its scene: made again whenever the scene, or a file that it names, was saved.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use super::Arguments;
use crate::bake::Interrupt;
use crate::cli::failure::Failure;
use crate::cli::options::Global;
use crate::cli::signals;
use crate::disk;
use crate::node::{self, Source};
use crate::terminal;
use crate::text::Overrides;

/// How often files are looked at. (Not told of by the system: that does not reach over networks.)
const PAUSE: Duration = Duration::from_millis(100);

/// What a file was like: when it was changed, and its size.
type Stamp = Option<(SystemTime, u64)>;

/// Calls `show` now and after each change, until it is interrupted. What is wrong with the scene is said, and the next save
/// waited for.
pub fn follow(
    arguments: &Arguments,
    interrupt: &Interrupt,
    global: &Global,
    show: impl Fn() -> Result<(), Failure>,
) -> Result<(), Failure> {
    let scene = &arguments.inputs[0];
    let Source::Path(path) = Source::of_argument(scene) else {
        return Err(Failure::usage(format!(
            "--watch follows a file, and `{scene}` is built in; `hfvdb scenes {scene} > {scene}.toml` makes one of it"
        )));
    };
    let mut watched = files(arguments, &path);
    loop {
        let start = Instant::now();
        match show() {
            Ok(()) if !global.quiet && !global.json => {
                crate::cli::say(&format!("{:.2} s; waiting for changes", start.elapsed().as_secs_f64()));
            }
            Ok(()) => {}
            Err(failure) if interrupt.is_raised() => return Err(failure),
            Err(failure) => failure.report(global.json),
        }
        loop {
            if interrupt.is_raised() {
                return Err(signals::interrupted());
            }
            std::thread::sleep(PAUSE);
            let now: BTreeMap<PathBuf, Stamp> = watched.keys().map(|path| (path.clone(), stamp(path))).collect();
            // A file that is away is about to be replaced: editors do so.
            if now != watched && now.get(&path).is_some_and(Option::is_some) {
                watched = files(arguments, &path);
                break;
            }
        }
    }
}

/// The scene and the files that it names, as they are now.
fn files(arguments: &Arguments, scene: &Path) -> BTreeMap<PathBuf, Stamp> {
    let overrides = Overrides { set: arguments.changes.set.clone(), variant: arguments.changes.variant.clone() };
    // Before the scene is read: what is saved while it is read counts as a change.
    let own = (scene.to_path_buf(), stamp(scene));
    let named = node::load(&Source::Path(scene.into()), &overrides).map(|model| model.files()).unwrap_or_default();
    named.into_iter().map(|path| (path.clone(), stamp(&path))).chain([own]).collect()
}

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Writes a page beside a picture that shows it anew whenever it was replaced, and asks the desktop to open it.
pub fn open(picture: &Path) -> Result<(), Failure> {
    let page = picture.with_extension("html");
    let name = picture.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let text = PAGE.replace("NAME", &name.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;"));
    disk::write_whole(&page, text.as_bytes()).map_err(|error| Failure::work(error.to_string()))?;
    let opened = std::process::Command::new("xdg-open")
        .arg(&page)
        .stdin(std::process::Stdio::null())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn();
    if opened.is_err() {
        crate::cli::say(&format!("open {} in a browser: it shows each new picture", terminal::path(&page)));
    }
    Ok(())
}

/// Twice a second the picture is asked for under a new address, and shown once it is there.
const PAGE: &str = r#"<!doctype html>
<meta charset="utf-8">
<title>NAME</title>
<style>html, body { height: 100%; margin: 0; background: #ced1d6 } img { width: 100%; height: 100%; object-fit: contain }</style>
<img alt="" src="NAME">
<script>
const shown = document.querySelector("img"), source = shown.getAttribute("src");
setInterval(() => {
  const next = new Image();
  next.onload = () => { shown.src = next.src };
  next.src = encodeURI(source) + "?" + Date.now();
}, 500);
</script>
"#;
