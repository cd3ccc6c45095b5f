// A grid's tree from blocks: nodes, leaves with values or without, tiles. Leaves are made on all threads.

#include "grids.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>

namespace hfvdb {

using openvdb::Coord;
using openvdb::Index;
using openvdb::Vec3s;

namespace {

constexpr std::size_t MASK_WORDS = 8;
// Leaves a thread takes at a time: fewer cost scheduling, more leave threads idle at the end.
constexpr std::size_t LEAVES_A_TASK = 64;
// The numbers in a leaf: a vector is three.
template <typename Leaf>
constexpr std::size_t LEAF_FLOATS = Leaf::SIZE * sizeof(typename Leaf::ValueType) / sizeof(float);

Coord coordinate(rust::Slice<const std::int32_t> numbers, std::size_t index)
{
    return {numbers[index], numbers[index + 1], numbers[index + 2]};
}

// A leaf that says which of its voxels are active. Without values it has no buffer: those of a file go from the blocks
// straight into it.
template <typename Leaf>
std::unique_ptr<Leaf> make_leaf(
    Coord origin, const std::uint64_t* mask, const float* values, const typename Leaf::ValueType& background)
{
    auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), origin, background, false);
    for (std::size_t word = 0; word < MASK_WORDS; ++word) {
        leaf->getValueMask().template getWord<std::uint64_t>(Index(word)) = mask[word];
    }
    if (values) {
        leaf->allocate();
        std::copy_n(values, LEAF_FLOATS<Leaf>, reinterpret_cast<float*>(leaf->buffer().data()));
    }
    return leaf;
}

// The ends of the runs of blocks that share one node with 2^log2_edge voxels along an edge.
std::vector<std::size_t> runs(rust::Slice<const std::int32_t> origins, int log2_edge)
{
    std::vector<std::size_t> starts{0};
    const std::size_t count = origins.size() / 3;
    for (std::size_t block = 1; block < count; ++block) {
        const Coord here = coordinate(origins, 3 * block), before = coordinate(origins, 3 * block - 3);
        if ((here >> std::size_t(log2_edge)) != (before >> std::size_t(log2_edge))) starts.push_back(block);
    }
    starts.push_back(count);
    return starts;
}

// Blocks stand sorted as the tree holds them, so each node's blocks are a run: nodes of the two upper levels are
// filled without a lock.
template <typename Tree>
void link_leaves(Tree& tree, const Blocks& blocks)
{
    using Leaf = typename Tree::LeafNodeType;
    using Upper = typename Tree::RootNodeType::ChildNodeType;
    using Lower = typename Upper::ChildNodeType;
    const std::size_t count = blocks.origins.size() / 3;
    if (count == 0) return;

    if (!blocks.values.empty() && blocks.values.size() != LEAF_FLOATS<Leaf> * count) {
        throw std::runtime_error("blocks without values");
    }

    std::vector<std::unique_ptr<Leaf>> leaves(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, LEAVES_A_TASK), [&](const auto& range) {
        for (std::size_t block = range.begin(); block != range.end(); ++block) {
            const float* values = blocks.values.empty() ? nullptr : blocks.values.data() + LEAF_FLOATS<Leaf> * block;
            leaves[block] = make_leaf<Leaf>(coordinate(blocks.origins, 3 * block),
                blocks.masks.data() + MASK_WORDS * block, values, tree.background());
        }
    });

    const std::vector<std::size_t> lower_runs = runs(blocks.origins, Lower::TOTAL);
    std::vector<std::unique_ptr<Lower>> lowers(lower_runs.size() - 1);
    tbb::parallel_for(std::size_t(0), lowers.size(), [&](std::size_t run) {
        lowers[run] = std::make_unique<Lower>(coordinate(blocks.origins, 3 * lower_runs[run]), tree.background());
        for (std::size_t block = lower_runs[run]; block != lower_runs[run + 1]; ++block) {
            lowers[run]->addLeaf(leaves[block].release());
        }
    });

    for (std::unique_ptr<Lower>& lower : lowers) {
        Upper* upper = tree.root().template probeNode<Upper>(lower->origin());
        if (!upper) {
            upper = new Upper(lower->origin(), tree.background());
            tree.root().addChild(upper);
        }
        upper->addChild(lower.release());
    }
}

float value_at(rust::Slice<const float> values, std::size_t tile, float)
{
    return values[tile];
}

Vec3s value_at(rust::Slice<const float> values, std::size_t tile, const Vec3s&)
{
    return Vec3s(values.data() + 3 * tile);
}

template <typename Tree>
void add_tiles(Tree& tree, const Blocks& blocks, rust::Slice<const float> values)
{
    const std::size_t components = sizeof(typename Tree::ValueType) / sizeof(float);
    if (values.size() * 4 != blocks.tiles.size() * components) throw std::runtime_error("tiles without values");
    for (std::size_t at = 0; at < blocks.tiles.size(); at += 4) {
        const std::int32_t edge = blocks.tiles[at + 3];
        const Index level = edge == 8 ? 1 : edge == 128 ? 2 : 3;
        const auto value = value_at(values, at / 4, tree.background());
        tree.addTile(level, coordinate(blocks.tiles, at), value, blocks.tiles_active);
    }
}

template <typename GridType>
std::shared_ptr<Grid> make_grid(const Head& head, const Blocks& blocks, const typename GridType::ValueType& background,
    rust::Slice<const float> tile_values)
{
    start_library();
    auto grid = GridType::create(background);
    insert_metadata(*grid, head.metadata);
    grid->setName(std::string(head.name));
    grid->setGridClass(openvdb::GridBase::stringToGridClass(std::string(head.grid_class)));
    if (!head.vector_type.empty()) {
        grid->setVectorType(openvdb::GridBase::stringToVecType(std::string(head.vector_type)));
    }
    grid->setSaveFloatAsHalf(head.half);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(head.voxel_size));
    link_leaves(grid->tree(), blocks);
    add_tiles(grid->tree(), blocks, tile_values);
    if (grid->tree().leafCount() != blocks.origins.size() / 3) {
        throw std::runtime_error("grid '" + std::string(head.name) + "' has tiles where it has blocks");
    }
    return share(grid);
}

} // namespace

Grid::Grid(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Grid::~Grid() = default;

rust::String library_version()
{
    return rust::String(openvdb::getLibraryVersionString());
}

void start_library()
{
    openvdb::initialize();
}

void set_thread_limit(std::size_t threads)
{
    static std::mutex lock;
    static std::unique_ptr<tbb::global_control> control;
    const std::lock_guard<std::mutex> guard(lock);
    control.reset();
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, threads);
}

void insert_metadata(openvdb::MetaMap& map, rust::Slice<const Meta> items)
{
    for (const Meta& item : items) {
        const std::string key(item.key);
        switch (item.kind) {
        case MetaKind::Text:
        case MetaKind::Other:
            map.insertMeta(key, openvdb::StringMetadata(std::string(item.text)));
            break;
        case MetaKind::Bool:
            map.insertMeta(key, openvdb::BoolMetadata(item.integer != 0));
            break;
        case MetaKind::Int32:
            map.insertMeta(key, openvdb::Int32Metadata(std::int32_t(item.integer)));
            break;
        case MetaKind::Int64:
            map.insertMeta(key, openvdb::Int64Metadata(item.integer));
            break;
        case MetaKind::Float:
            map.insertMeta(key, openvdb::FloatMetadata(float(item.real)));
            break;
        case MetaKind::Double:
            map.insertMeta(key, openvdb::DoubleMetadata(item.real));
            break;
        }
    }
}

std::shared_ptr<Grid> float_grid(const Head& head, const Blocks& blocks, float background, rust::Slice<const float> tile_values)
{
    return make_grid<openvdb::FloatGrid>(head, blocks, background, tile_values);
}

std::shared_ptr<Grid> vector_grid(
    const Head& head, const Blocks& blocks, std::array<float, 3> background, rust::Slice<const float> tile_values)
{
    return make_grid<openvdb::Vec3SGrid>(head, blocks, Vec3s(background.data()), tile_values);
}

} // namespace hfvdb
