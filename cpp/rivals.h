// What the benches compare the border with. Compiled only with the cargo feature `rivals`.
#pragma once

#include "rust/cxx.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace hfvdb {

class Frame;

// Seconds that all threads of the process have run.
double processor_seconds();

// Leaves made from blocks and linked by hand-written C++ on so many threads of its own, no border crossed: returns the
// active voxels of the tree, which is gone afterwards. `seconds` gets the time to make it, not to destroy it: by the
// clock, and of the processor.
std::uint64_t link_in_cpp(rust::Slice<const std::int32_t> origins, rust::Slice<const std::uint64_t> masks,
    rust::Slice<const float> values, float background, std::size_t threads, std::array<double, 2>& seconds);

// A frame written by OpenVDB's own writer, and synced.
void write_with_library(const Frame& frame, rust::Str path);

// A tree that is filled by one call a voxel.
class VoxelTree {
public:
    explicit VoxelTree(float background);
    ~VoxelTree();
    void set(std::int32_t x, std::int32_t y, std::int32_t z, float value);
    std::uint64_t active_voxels() const;

private:
    struct Parts;
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<VoxelTree> new_voxel_tree(float background);

} // namespace hfvdb
