// What the benches compare with.
#pragma once

#include "rust/cxx.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace rivals {

// Leaves made from blocks, linked and encoded by hand-written C++ on so many threads of its own, no border crossed:
// returns the bytes they take, which are gone afterwards. `seconds` gets the time to make them, not to destroy them: by
// the clock, and of the processor.
std::size_t encode_in_cpp(rust::Slice<const std::int32_t> origins, rust::Slice<const std::uint64_t> masks,
    rust::Slice<const float> values, float background, std::size_t threads, std::array<double, 2>& seconds);

// A file's grids and metadata as OpenVDB has them, values and all.
class LibraryFrame {
public:
    explicit LibraryFrame(rust::Str path);
    ~LibraryFrame();
    // Writes them by OpenVDB's own writer, and syncs the file.
    void write(rust::Str path) const;

private:
    struct Parts;
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<LibraryFrame> read_with_library(rust::Str path);

// A tree that is filled by one call a voxel.
class VoxelTree {
public:
    explicit VoxelTree(float background);
    ~VoxelTree();
    void set(std::int32_t x, std::int32_t y, std::int32_t z, float value);
    // The bytes that its leaves take, encoded by OpenVDB on one thread, not compressed.
    std::size_t encode() const;

private:
    struct Parts;
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<VoxelTree> new_voxel_tree(float background);

// A grid of OpenVDB's, negative inside. Lengths below are in world units, half widths 3 voxels; balls come as x, y, z
// and radius of each.
class RivalGrid {
public:
    struct Parts;
    explicit RivalGrid(std::unique_ptr<Parts> parts);
    ~RivalGrid();
    Parts& parts() const { return *mParts; }
    std::uint64_t active_voxels() const;
    std::size_t leaves() const;
    // Copies all leaves into slices of 3, 8 and 512 items a leaf.
    void blocks(
        rust::Slice<std::int32_t> origins, rust::Slice<std::uint64_t> masks, rust::Slice<float> values) const;

private:
    std::unique_ptr<Parts> mParts;
};

// A grid of active values, 512 a leaf.
std::unique_ptr<RivalGrid> dense_grid(
    rust::Slice<const std::int32_t> origins, rust::Slice<const float> values, double voxel_size);

// The loop that a user writes: F of all voxels of the box [-1, 1]³ by plain R₀, kept by an accessor where it is less
// than 3 voxels.
std::unique_ptr<RivalGrid> accessor_loop(rust::Slice<const double> balls, rust::Slice<const double> holes,
    std::int32_t resolution, std::size_t threads);

// A level set a ball, joined and taken away one after another.
std::unique_ptr<RivalGrid> spheres_by_csg(
    rust::Slice<const double> balls, rust::Slice<const double> holes, double voxel_size);

// levelSetRebuild and sdfToSdf.
std::unique_ptr<RivalGrid> rebuild(const RivalGrid& dense);
std::unique_ptr<RivalGrid> sweep(const RivalGrid& dense);

// Level sets around the origin, and LevelSetMorphing with its defaults, which returns its steps.
std::unique_ptr<RivalGrid> sphere_level_set(double radius, double voxel_size);
std::unique_ptr<RivalGrid> cube_level_set(double edge, double voxel_size);
std::size_t morph(RivalGrid& source, const RivalGrid& target, double from, double to);

// A level set with colours on its active voxels.
class ColouredGrid {
public:
    struct Parts;
    explicit ColouredGrid(std::unique_ptr<Parts> parts);
    ~ColouredGrid();
    const Parts& parts() const { return *mParts; }
    std::uint64_t active_voxels() const;
    float value(std::int32_t x, std::int32_t y, std::int32_t z) const;

private:
    std::unique_ptr<Parts> mParts;
};

// meshToVolume of triangles, and the colour of each voxel's closest point by the grid of polygons that it fills.
std::unique_ptr<ColouredGrid> mesh_to_volume(rust::Slice<const float> positions,
    rust::Slice<const std::uint32_t> triangles, rust::Slice<const float> colours, double voxel_size);

// The grids `surface` and `Cd` of a file.
std::unique_ptr<ColouredGrid> read_coloured(rust::Str path);

// volumeToMesh with colours sampled at its vertices; returns how many triangles it makes.
std::size_t volume_to_mesh(const ColouredGrid& grid, double adaptivity);

} // namespace rivals
