// Grids from blocks: one copy of the values, leaves made on all threads.

#include "grids.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <stdexcept>

namespace hfvdb {

using openvdb::Coord;
using openvdb::Index;
using openvdb::Vec3s;

namespace {

constexpr std::size_t VOXELS = 512;
constexpr std::size_t MASK_WORDS = 8;
// Leaves a thread takes at a time: fewer cost scheduling, more leave threads idle at the end.
constexpr std::size_t LEAVES_A_TASK = 64;

bool finite(float value)
{
    return std::abs(value) <= std::numeric_limits<float>::max();
}

// Without a branch, so that it is done on vectors.
bool all_finite(const float* values, std::size_t count)
{
    unsigned bad = 0;
    for (std::size_t index = 0; index < count; ++index) bad |= unsigned(!finite(values[index]));
    return bad == 0;
}

// How blocks are filled, for each kind of grid. `fill` gets a block's 512 values, its mask, and where to put them.
struct LevelSetValues {
    using Value = float;
    static constexpr std::size_t COMPONENTS = 1;
    const float* source;
    float background;

    // Inactive distances lie at or beyond the background, so limiting all of them is enough; the mask is not needed.
    void fill(const float* block, const std::uint64_t*, float* target) const
    {
        for (std::size_t voxel = 0; voxel < VOXELS; ++voxel) {
            target[voxel] = std::min(std::max(flip_sign(block[voxel]), -background), background);
        }
    }
};

// Active values as they are, the background elsewhere.
template <typename ValueType, std::size_t Components>
struct ChannelValues {
    using Value = ValueType;
    static constexpr std::size_t COMPONENTS = Components;
    const float* source;
    ValueType background;

    void fill(const float* block, const std::uint64_t* mask, float* target) const
    {
        constexpr std::size_t ROW = 8;
        float fallback[Components];
        std::memcpy(fallback, &background, sizeof fallback);
        for (std::size_t row = 0; row < VOXELS / ROW; ++row) {
            const unsigned active = (mask[row / 8] >> (row % 8 * ROW)) & 0xff;
            const std::size_t at = row * ROW * Components;
            if (active == 0xff) {
                std::memcpy(target + at, block + at, ROW * Components * sizeof(float));
                continue;
            }
            for (std::size_t z = 0; z < ROW; ++z) {
                const float* from = (active >> z) & 1 ? block + at + z * Components : fallback;
                std::memcpy(target + at + z * Components, from, Components * sizeof(float));
            }
        }
    }
};

using FloatValues = ChannelValues<float, 1>;
using VectorValues = ChannelValues<Vec3s, 3>;
static_assert(sizeof(Vec3s) == 3 * sizeof(float), "vectors are three floats");

Coord coordinate(rust::Slice<const std::int32_t> numbers, std::size_t index)
{
    return {numbers[index], numbers[index + 1], numbers[index + 2]};
}

[[noreturn]] void refuse_value(const Head& head, Coord origin, Index offset)
{
    const Coord voxel(origin.x() + int(offset >> 6), origin.y() + int((offset >> 3) & 7), origin.z() + int(offset & 7));
    throw std::runtime_error("grid '" + std::string(head.name) + "' has a value that is not a finite number at voxel ("
        + std::to_string(voxel.x()) + ", " + std::to_string(voxel.y()) + ", " + std::to_string(voxel.z()) + ")");
}

template <typename Leaf, typename Values>
std::unique_ptr<Leaf> make_leaf(const Head& head, Coord origin, const std::uint64_t* mask, const Values& values,
    std::size_t block)
{
    constexpr std::size_t NUMBERS = VOXELS * Values::COMPONENTS;
    // "Partial": the values are not filled in before we do it.
    auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), origin, values.background, false);
    leaf->allocate();
    float* target = reinterpret_cast<float*>(leaf->buffer().data());
    values.fill(values.source + NUMBERS * block, mask, target);
    for (std::size_t word = 0; word < MASK_WORDS; ++word) {
        leaf->getValueMask().template getWord<std::uint64_t>(Index(word)) = mask[word];
    }
    if (!all_finite(target, NUMBERS)) {
        const float* bad = std::find_if_not(target, target + NUMBERS, [](float value) { return finite(value); });
        refuse_value(head, origin, Index(std::size_t(bad - target) / Values::COMPONENTS));
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
template <typename Tree, typename Values>
void link_leaves(Tree& tree, const Head& head, const Blocks& blocks, const Values& values)
{
    using Leaf = typename Tree::LeafNodeType;
    using Upper = typename Tree::RootNodeType::ChildNodeType;
    using Lower = typename Upper::ChildNodeType;
    const std::size_t count = blocks.origins.size() / 3;
    if (count == 0) return;

    std::vector<std::unique_ptr<Leaf>> leaves(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, LEAVES_A_TASK), [&](const auto& range) {
        for (std::size_t block = range.begin(); block != range.end(); ++block) {
            leaves[block] = make_leaf<Leaf>(head, coordinate(blocks.origins, 3 * block),
                blocks.masks.data() + MASK_WORDS * block, values, block);
        }
    });

    const std::vector<std::size_t> lower_runs = runs(blocks.origins, Lower::TOTAL);
    std::vector<std::unique_ptr<Lower>> lowers(lower_runs.size() - 1);
    tbb::parallel_for(std::size_t(0), lowers.size(), [&](std::size_t run) {
        lowers[run] = std::make_unique<Lower>(coordinate(blocks.origins, 3 * lower_runs[run]), values.background);
        for (std::size_t block = lower_runs[run]; block != lower_runs[run + 1]; ++block) {
            lowers[run]->addLeaf(leaves[block].release());
        }
    });

    for (std::unique_ptr<Lower>& lower : lowers) {
        Upper* upper = tree.root().template probeNode<Upper>(lower->origin());
        if (!upper) {
            upper = new Upper(lower->origin(), values.background);
            tree.root().addChild(upper);
        }
        upper->addChild(lower.release());
    }
}

template <typename Tree>
void add_tiles(Tree& tree, const Blocks& blocks, const typename Tree::ValueType& value)
{
    for (std::size_t at = 0; at < blocks.tiles.size(); at += 4) {
        const std::int32_t edge = blocks.tiles[at + 3];
        const Index level = edge == 8 ? 1 : edge == 128 ? 2 : 3;
        tree.addTile(level, coordinate(blocks.tiles, at), value, blocks.tiles_active);
    }
}

template <typename GridType, typename Values>
std::shared_ptr<Grid> make_grid(
    const Head& head, const Blocks& blocks, const Values& values, const typename Values::Value& tile_value)
{
    start_library();
    auto grid = GridType::create(values.background);
    insert_metadata(*grid, head.metadata);
    grid->setName(std::string(head.name));
    grid->setGridClass(openvdb::GridBase::stringToGridClass(std::string(head.grid_class)));
    if (!head.vector_type.empty()) {
        grid->setVectorType(openvdb::GridBase::stringToVecType(std::string(head.vector_type)));
    }
    grid->setSaveFloatAsHalf(head.half);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(head.voxel_size));
    link_leaves(grid->tree(), head, blocks, values);
    add_tiles(grid->tree(), blocks, tile_value);
    if (grid->tree().leafCount() != blocks.origins.size() / 3) {
        throw std::runtime_error("grid '" + std::string(head.name) + "' has tiles where it has blocks");
    }
    return std::make_shared<Grid>(std::make_unique<Grid::Parts>(Grid::Parts{grid}));
}

} // namespace

Grid::Grid(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Grid::~Grid() = default;

Frame::Frame(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Frame::~Frame() = default;

void Frame::add(std::shared_ptr<Grid> grid)
{
    mParts->grids.push_back(grid->parts().grid);
}

std::unique_ptr<Frame> new_frame(rust::Slice<const Meta> metadata)
{
    auto parts = std::make_unique<Frame::Parts>();
    insert_metadata(parts->metadata, metadata);
    return std::make_unique<Frame>(std::move(parts));
}

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

std::shared_ptr<Grid> level_set(
    const Head& head, const Blocks& blocks, rust::Slice<const float> distances, float background)
{
    // Tiles lie inside: they hold the most negative distance.
    return make_grid<openvdb::FloatGrid>(
        head, blocks, LevelSetValues{distances.data(), background}, flip_sign(background));
}

std::shared_ptr<Grid> float_grid(
    const Head& head, const Blocks& blocks, rust::Slice<const float> values, float background, float tile_value)
{
    return make_grid<openvdb::FloatGrid>(head, blocks, FloatValues{values.data(), background}, tile_value);
}

std::shared_ptr<Grid> vector_grid(const Head& head, const Blocks& blocks, rust::Slice<const float> values,
    std::array<float, 3> background, std::array<float, 3> tile_value)
{
    return make_grid<openvdb::Vec3SGrid>(
        head, blocks, VectorValues{values.data(), Vec3s(background.data())}, Vec3s(tile_value.data()));
}

} // namespace hfvdb
