//! `hfvdb schema`: the scene format for editors.

use super::failure::Failure;
use crate::node;

/// Runs the command.
pub fn run() -> Result<(), Failure> {
    super::print_json(&node::schema())
}
