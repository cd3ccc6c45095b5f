//! Files by frame: `vdb = "sim.####.vdb"`, with `frame_offset` and `outside_frames`.

use std::sync::Arc;

use super::Building;
use crate::node::argument::{Argument, Arguments};
use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::reader::Fields;
use crate::text::sequence::{self, FileSequence, OutsideFrames};

impl<'r, 'a> Building<'r, 'a> {
    /// The files by frame that a key names; none where it names a file.
    #[allow(clippy::option_option, reason = "an error that was said, one file, or several")]
    pub(super) fn sequence(&self, key: &str, fields: &Fields<'r, 'a>) -> Option<Option<FileSequence>> {
        let value = fields.value(key)?;
        // What is no text is said where the file is read.
        let Some(text) = value.text() else { return Some(None) };
        let base = self.surroundings.namespaces.base(value.span).unwrap_or(&self.surroundings.base);
        let found = sequence::find(text, value.span, base, &self.surroundings.variables, self.shot.range);
        let found = found.and_then(|found| match found {
            Some(files) if self.shot.still => {
                let [first, last] = files.ends();
                let problem = format!("`{}` is a file by frame, and the scene has no `frames`", clip(&files.name));
                Err(Diagnostic::error(value.span, problem)
                    .help(format!("write frames = \"{first}-{last}\" at its top")))
            }
            found => Ok(found),
        });
        found.map_err(|problem| self.reader.say(problem)).ok()
    }

    /// Says which file of a sequence stands for which frame. Whether all is well.
    pub(super) fn in_time(&self, arguments: &mut Arguments, fields: &Fields<'r, 'a>) -> bool {
        let offset = arguments.whole(FRAME_OFFSET.name).copied();
        let outside = match arguments.choice(OUTSIDE_FRAMES.name) {
            Some(&"hold") => OutsideFrames::Hold,
            Some(&"loop") => OutsideFrames::Loop,
            _ => OutsideFrames::Error,
        };
        let files = arguments.0.iter_mut().find_map(|(_, value)| match value {
            Argument::Files(files) => Some(files),
            _ => None,
        });
        let Some(files) = files else {
            // It has a default wherever files may be by frame. Of what is no file something was said.
            let takes_files =
                offset.is_some() && arguments.0.iter().any(|(_, value)| matches!(value, Argument::File(_)));
            let given = [FRAME_OFFSET.name, OUTSIDE_FRAMES.name].into_iter().filter(|_| takes_files);
            let Some((name, entry)) = given.filter_map(|name| Some((name, fields.entry(name)?))).next() else {
                return true;
            };
            let problem = Diagnostic::error(entry.key_span, format!("`{name}` goes with files by frame"));
            self.reader.say(problem.help("name them with a frame token, as in \"sim.####.vdb\"; or leave it out"));
            return false;
        };
        match FileSequence::clone(files).timed(offset.unwrap_or(0), outside) {
            Ok(timed) => {
                *files = Arc::new(timed);
                true
            }
            Err(problem) => {
                self.reader.say(problem);
                false
            }
        }
    }
}
