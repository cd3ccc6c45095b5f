//! One thing that is wrong with a file.

use std::fmt;

use serde::Serialize;

use super::programs::Client;
use crate::terminal;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Programs show it wrong, or not at all.
    Error,
    /// Some programs may.
    Warning,
    /// It is good to know.
    Note,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The program it is about; `None` for all.
    pub client: Option<Client>,
    /// The grid it is about; `None` for the file.
    pub grid: Option<String>,
    /// What it is, and what to do.
    pub problem: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(client) = self.client {
            write!(f, "for {client}: ")?;
        }
        match &self.grid {
            Some(grid) => write!(f, "grid '{}': {}", terminal::one_line(grid), terminal::one_line(&self.problem)),
            None => f.write_str(&terminal::one_line(&self.problem)),
        }
    }
}
