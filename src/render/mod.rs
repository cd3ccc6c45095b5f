//! Pictures: ray casting, contact sheets, PNG.
