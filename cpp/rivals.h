// What the benches compare the border with. Compiled only with the cargo feature `rivals`.
#pragma once

#include "rust/cxx.h"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace hfvdb {

// Leaves made from blocks and linked by hand-written C++ on so many threads of its own, no border crossed: returns the
// active voxels of the tree, which is gone afterwards; `seconds` is the time to make it, not to destroy it.
std::uint64_t link_in_cpp(rust::Slice<const std::int32_t> origins, rust::Slice<const std::uint64_t> masks,
    rust::Slice<const float> values, float background, std::size_t threads, double& seconds);

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
