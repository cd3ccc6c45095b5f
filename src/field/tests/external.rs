//! Fields of other graphs as operands.
