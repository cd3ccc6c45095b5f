//! The bridge itself: every function that crosses the border. All are bulk: whole grids or whole files.

#![allow(unsafe_code, missing_docs, unused_qualifications)]

use std::sync::atomic::{AtomicBool, Ordering};

#[cxx::bridge(namespace = "hfvdb")]
pub(super) mod ffi {
    /// What a [`Meta`] holds.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum MetaKind {
        Text,
        Bool,
        Int32,
        Int64,
        Float,
        Double,
        /// Anything else, shown as text; read only.
        Other,
    }

    /// One metadata item; the field that `kind` names is the value.
    struct Meta {
        key: String,
        kind: MetaKind,
        text: String,
        integer: i64,
        real: f64,
    }

    /// What every grid has.
    struct Head<'a> {
        name: &'a str,
        /// The class as OpenVDB spells it.
        grid_class: &'a str,
        /// The vector type as OpenVDB spells it, or empty.
        vector_type: &'a str,
        /// World units.
        voxel_size: f64,
        /// Values are stored in 16 bits in the file.
        half: bool,
        metadata: &'a [Meta],
    }

    /// Where a grid's blocks and tiles stand.
    struct Blocks<'a> {
        /// Three numbers a block.
        origins: &'a [i32],
        /// Eight words a block.
        masks: &'a [u64],
        /// 512 values a block, of vectors three numbers each; or none, for leaves without values.
        values: &'a [f32],
        /// Four numbers a tile: its least corner and its edge.
        tiles: &'a [i32],
        tiles_active: bool,
    }

    /// A run of leaves to be encoded.
    struct Leaves<'a> {
        /// What each leaf has before its values, one after the other.
        heads: &'a [u8],
        /// Where each leaf's part of `heads` ends.
        head_ends: &'a [usize],
        /// The values to be compressed.
        values: &'a [f32],
        /// Where each leaf's values end.
        value_ends: &'a [usize],
    }

    /// What a grid's head says of its leaves.
    struct LeafSizes<'a> {
        /// How each leaf keeps its inactive values.
        masks: &'a [i8],
        /// The bytes of each leaf's compressed values.
        sizes: &'a [i64],
        /// The bytes of all leaves.
        bytes: i64,
    }

    /// What a level set holds.
    #[derive(Clone, Copy, Debug)]
    struct Counts {
        blocks: usize,
        /// Tiles inside.
        tiles: usize,
    }

    /// Where a level set's blocks and the tiles inside are copied to.
    struct Target<'a> {
        /// Three numbers a block.
        origins: &'a mut [i32],
        /// Eight words a block.
        masks: &'a mut [u64],
        /// 512 values a block.
        values: &'a mut [f32],
        /// Four numbers a tile: its least corner and its edge.
        tiles: &'a mut [i32],
    }

    /// How buffers are compressed in the file.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Codec {
        None,
        Zip,
        Blosc,
    }

    extern "Rust" {
        type Cancel<'a>;
        fn is_set(self: &Cancel) -> bool;
    }

    unsafe extern "C++" {
        include!("border.h");

        /// The version of the library that is linked.
        fn library_version() -> String;
        /// At most so many threads work inside OpenVDB from now on, in this process.
        fn set_thread_limit(threads: usize) -> Result<()>;

        /// A grid: immutable once it is made.
        type Grid;
        /// The nodes, leaves and tiles of a grid of numbers: one value a tile, of vectors three numbers.
        fn float_grid(head: &Head, blocks: &Blocks, background: f32, tile_values: &[f32]) -> Result<SharedPtr<Grid>>;
        fn vector_grid(
            head: &Head,
            blocks: &Blocks,
            background: [f32; 3],
            tile_values: &[f32],
        ) -> Result<SharedPtr<Grid>>;

        /// Makes the parts of a file.
        type Writer;
        fn new_writer(codec: Codec) -> Result<UniquePtr<Writer>>;
        /// What stands before the first of so many grids: each time with another identifier.
        fn file_head(self: Pin<&mut Writer>, metadata: &[Meta], grids: i32) -> Result<UniquePtr<CxxString>>;
        /// Compresses leaves into `target`; returns the bytes they take there. `sizes` are those of each leaf's
        /// compressed values.
        fn leaves(self: &Writer, grid: &Grid, leaves: &Leaves, sizes: &mut [i64], target: &mut [u8]) -> Result<usize>;
        /// What a grid's head says of all but its values.
        type Nodes;
        fn nodes(self: &Writer, grid: &Grid) -> Result<UniquePtr<Nodes>>;
        /// What stands before the first leaf of a grid that starts at that byte of the file.
        fn grid_head(self: &Writer, nodes: &Nodes, leaves: &LeafSizes, position: i64) -> Result<UniquePtr<CxxString>>;

        /// A grid of 32-bit numbers or vectors as NanoVDB has it; `half` for codes of 16 bits, of numbers alone.
        type Nano;
        fn to_nano(grid: &Grid, half: bool) -> Result<UniquePtr<Nano>>;
        /// A file of such grids.
        type NanoFile;
        fn new_nano_file(codec: Codec) -> Result<UniquePtr<NanoFile>>;
        /// The bytes of one more grid.
        fn add(self: Pin<&mut NanoFile>, nano: &Nano) -> Result<UniquePtr<CxxString>>;
        /// What stands before the grids that were added.
        fn head(self: &NanoFile) -> Result<UniquePtr<CxxString>>;

        /// What OpenVDB makes of a level set on its way to another in so much of its time; anything once it is to stop.
        fn morphed(source: &Grid, target: &Grid, duration: f64, cancel: &Cancel) -> Result<SharedPtr<Grid>>;
        /// How much `copy` gives.
        fn count(level_set: &Grid) -> Result<Counts>;
        /// A level set's blocks and the tiles inside, its values negative there.
        fn copy(level_set: &Grid, target: &mut Target) -> Result<()>;
    }
}

/// What OpenVDB asks, from any of its threads, whether to stop.
pub(super) struct Cancel<'a>(pub(super) &'a AtomicBool);

impl Cancel<'_> {
    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

// SAFETY: a `Grid` never changes once it is made, and OpenVDB's trees may be read from many threads at once. Nothing
// is loaded late: no file is read.
unsafe impl Send for ffi::Grid {}
unsafe impl Sync for ffi::Grid {}
// SAFETY: a `Writer` changes only through a unique reference; its other functions have streams of their own.
unsafe impl Send for ffi::Writer {}
unsafe impl Sync for ffi::Writer {}
// SAFETY: `Nodes` are bytes and metadata of their own, and a grid that may be read from any thread.
unsafe impl Send for ffi::Nodes {}
