//! Polygon files, exact closest triangle, inside test. A mesh is a distance object like any other.
