//! What went wrong, and the exit code that goes with it.

use super::events;
use crate::{bake, shot, terminal, text};

/// A failure with its exit code.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    message: String,
    /// Whether the message is finished text (a scene's marked errors) that needs no `error:` in front.
    rendered: bool,
    /// Whether stdout has its document already.
    told: bool,
}

impl Failure {
    /// The input or the work failed: 1.
    pub fn work(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into(), rendered: false, told: false }
    }

    /// The command line is wrong by itself: 2.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into(), rendered: false, told: false }
    }

    /// More memory is needed than allowed: 3.
    pub fn memory(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into(), rendered: false, told: false }
    }

    /// A signal ended the work: 128 and its number.
    pub fn interrupted(code: u8) -> Self {
        Self {
            code,
            message: "interrupted; finished frames are whole, nothing half-written is left".into(),
            rendered: false,
            told: false,
        }
    }

    /// Errors of a scene, marked in its text already.
    pub fn rendered(message: String) -> Self {
        Self { code: 1, message, rendered: true, told: false }
    }

    /// The same, where the results are on stdout all the same: no second document with `--json`.
    pub fn with_results(self) -> Self {
        Self { told: true, ..self }
    }

    /// What went wrong, in words.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// With the name of the file that it is about in front.
    pub fn about(mut self, name: &str) -> Self {
        self.message = format!("{}: {}", terminal::one_line(name), self.message);
        self
    }

    /// With more to say.
    pub fn and(mut self, more: &str) -> Self {
        self.message = format!("{}{more}", self.message.trim_end());
        self
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> u8 {
        self.code
    }

    /// Prints the failure: to stderr, and with `--json` as a document on stdout too.
    pub fn report(&self, json: bool) {
        let event = if self.code > 128 { "interrupted" } else { "failed" };
        if events::tell(event, &serde_json::json!({ "exit_code": self.code, "message": self.message })) {
            // A log of events holds nothing else.
        } else if self.rendered {
            super::say_as_is(&terminal::coloured(self.message.trim_end()));
        } else {
            super::say(&format!("error: {}", self.message));
        }
        if json && !self.told {
            let document = serde_json::json!({ "error": { "exit_code": self.code, "message": self.message } });
            // Nothing is left to say when stdout is closed.
            let _ = super::print_json(&document);
        }
    }
}

impl From<bake::PatternError> for Failure {
    fn from(error: bake::PatternError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<text::Diagnostics> for Failure {
    fn from(diagnostics: text::Diagnostics) -> Self {
        Self::rendered(diagnostics.render(terminal::styled() && !events::on()))
    }
}

impl From<shot::Error> for Failure {
    fn from(error: shot::Error) -> Self {
        match error {
            shot::Error::Scene(diagnostics) => diagnostics.into(),
            shot::Error::Memory { needed, limit, voxels } => {
                bake::Error::Memory { needed: bake::Bytes(needed), limit: bake::Bytes(limit), voxels }.into()
            }
            error @ shot::Error::Cancelled => Self::work(error.to_string()),
        }
    }
}

impl From<bake::Error> for Failure {
    fn from(error: bake::Error) -> Self {
        match error {
            bake::Error::Scene(error) => error.into(),
            error @ bake::Error::Memory { .. } => Self::memory(error.to_string()),
            error => Self::work(error.to_string()),
        }
    }
}

impl From<bake::Refusal> for Failure {
    fn from(error: bake::Refusal) -> Self {
        Self::work(error.to_string())
    }
}

impl From<bake::TargetError> for Failure {
    fn from(error: bake::TargetError) -> Self {
        Self::work(error.to_string())
    }
}

impl From<bake::SealedError> for Failure {
    fn from(error: bake::SealedError) -> Self {
        bake::Refusal::Damaged(error).into()
    }
}

impl From<crate::vdb::Error> for Failure {
    fn from(error: crate::vdb::Error) -> Self {
        Self::work(error.to_string())
    }
}
