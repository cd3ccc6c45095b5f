// OpenVDB's own morph of one level set into another.

#include "grids.h"

#include <openvdb/tools/LevelSetMorph.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
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

// Calls `visit` with the origin and the edge of each tile inside. OpenVDB's own iterator over a whole tree counts from the
// root's first entry to the present one at each step.
template <typename Node, typename Visit>
void visit_inside(const Node& node, const Visit& visit)
{
    using Child = typename Node::ChildNodeType;
    for (auto entry = node.cbeginChildAll(); entry; ++entry) {
        float value = 0.0f;
        if (const Child* child = entry.probeChild(value)) {
            if constexpr (Child::LEVEL > 0) visit_inside(*child, visit);
        } else if (value < 0.0f) {
            visit(entry.getCoord(), int(Child::DIM));
        }
    }
}

void store_origin(std::int32_t* target, const openvdb::Coord& origin)
{
    for (int axis = 0; axis < 3; ++axis) target[axis] = origin[axis];
}

} // namespace

std::shared_ptr<Grid> morphed(const Grid& source, const Grid& target, double duration, const Cancel& cancel)
{
    const FloatGrid::Ptr grid = level_set_of(source).deepCopy();
    Interrupter interrupter(cancel);
    openvdb::tools::LevelSetMorphing<FloatGrid, Interrupter> morphing(*grid, level_set_of(target), &interrupter);
    morphing.advect(0.0f, float(duration));
    return share(grid);
}

Counts count(const Grid& level_set)
{
    const openvdb::FloatTree& tree = level_set_of(level_set).tree();
    Counts counts{tree.leafCount(), 0};
    visit_inside(tree.root(), [&](const openvdb::Coord&, int) { ++counts.tiles; });
    return counts;
}

void copy(const Grid& level_set, Target& target)
{
    const openvdb::FloatTree& tree = level_set_of(level_set).tree();
    const openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(tree);
    const Counts counts = count(level_set);
    if (target.origins.size() != 3 * counts.blocks || target.masks.size() != 8 * counts.blocks
        || target.values.size() != 512 * counts.blocks || target.tiles.size() != 4 * counts.tiles) {
        throw std::length_error("a level set does not fit into what was made for it");
    }
    tbb::parallel_for(std::size_t(0), counts.blocks, [&](std::size_t block) {
        const auto& leaf = leaves.leaf(block);
        store_origin(target.origins.data() + 3 * block, leaf.origin());
        for (openvdb::Index word = 0; word < 8; ++word) {
            target.masks[8 * block + word] = leaf.getValueMask().template getWord<std::uint64_t>(word);
        }
        std::copy_n(leaf.buffer().data(), 512, target.values.data() + 512 * block);
    });
    std::int32_t* tile = target.tiles.data();
    visit_inside(tree.root(), [&](const openvdb::Coord& origin, int edge) {
        store_origin(tile, origin);
        tile[3] = edge;
        tile += 4;
    });
}

} // namespace hfvdb
