// OpenVDB's own morph of one level set into another.

#include "grids.h"

#include <openvdb/tools/LevelSetMorph.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <stdexcept>

namespace hfvdb {

using openvdb::FloatGrid;

namespace {

// What OpenVDB asks whether to stop, from any of its threads.
class Interrupter {
public:
    explicit Interrupter(const Cancel& cancel)
        : mCancel(cancel)
    {
    }
    void start(const char*) {}
    void end() {}
    bool wasInterrupted(int = -1) const { return mCancel.is_set(); }

private:
    const Cancel& mCancel;
};

const FloatGrid& level_set_of(const Grid& grid)
{
    return static_cast<const FloatGrid&>(*grid.parts().grid);
}

} // namespace

std::shared_ptr<Grid> with_distances(const Grid& topology, rust::Slice<const float> distances)
{
    const FloatGrid::Ptr grid = level_set_of(topology).deepCopy();
    const openvdb::tree::LeafManager<openvdb::FloatTree> leaves(grid->tree());
    if (distances.size() != 512 * leaves.leafCount()) throw std::length_error("a level set has other leaves");
    tbb::parallel_for(std::size_t(0), leaves.leafCount(), [&](std::size_t block) {
        auto& leaf = leaves.leaf(block);
        leaf.allocate();
        float* values = leaf.buffer().data();
        for (std::size_t voxel = 0; voxel < 512; ++voxel) values[voxel] = flip_sign(distances[512 * block + voxel]);
    });
    return share(grid);
}

std::shared_ptr<Grid> morphed(const Grid& source, const Grid& target, double duration, const Cancel& cancel)
{
    const FloatGrid::Ptr grid = level_set_of(source).deepCopy();
    Interrupter interrupter(cancel);
    openvdb::tools::LevelSetMorphing<FloatGrid, Interrupter> morphing(*grid, level_set_of(target), &interrupter);
    morphing.advect(0.0f, float(duration));
    return share(grid);
}

} // namespace hfvdb
