// A file's grids to blocks. The bytes lie in memory and were walked: what OpenVDB's reader would trust has been checked.

#include "grids.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <istream>
#include <stdexcept>
#include <streambuf>

namespace hfvdb {

namespace io = openvdb::io;
using openvdb::Coord;
using openvdb::Index;

namespace {

// A stream buffer over bytes that lie elsewhere.
class BytesSource : public std::streambuf {
public:
    explicit BytesSource(rust::Slice<const std::uint8_t> bytes)
    {
        // The get area is never written to.
        char* start = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
        setg(start, start, start + bytes.size());
    }

protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir way, std::ios_base::openmode) override
    {
        const off_type base = way == std::ios_base::beg ? 0
            : way == std::ios_base::cur                 ? gptr() - eback()
                                                        : egptr() - eback();
        const off_type target = base + offset;
        if (target < 0 || target > egptr() - eback()) return pos_type(off_type(-1));
        setg(eback(), eback() + target, egptr());
        return pos_type(target);
    }
    pos_type seekpos(pos_type position, std::ios_base::openmode mode) override
    {
        return seekoff(off_type(position), std::ios_base::beg, mode);
    }
};

class Reader : public io::Archive {
public:
    openvdb::GridBase::Ptr read_one(rust::Slice<const std::uint8_t> bytes, std::size_t descriptor)
    {
        BytesSource source(bytes);
        std::istream stream(&source);
        // A read that fails or goes past the end throws, where OpenVDB would go on with what it has.
        stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
        openvdb::SharedPtr<io::StreamMetadata> settings(new io::StreamMetadata);
        io::setStreamMetadataPtr(stream, settings);
        readHeader(stream);
        stream.seekg(std::streamoff(descriptor));
        io::GridDescriptor head;
        openvdb::GridBase::Ptr grid = head.read(stream);
        if (!grid) throw std::runtime_error("a grid of unknown type");
        readGrid(grid, head, stream);
        return grid;
    }
};

float as_float(float value)
{
    return value;
}
float as_float(double value)
{
    return float(value);
}

void store(float* target, float value)
{
    *target = value;
}
void store(float* target, double value)
{
    *target = as_float(value);
}
template <typename T>
void store(float* target, const openvdb::math::Vec3<T>& value)
{
    for (int axis = 0; axis < 3; ++axis) target[axis] = as_float(value[axis]);
}

// Calls `visit` with each tile of a node, and of those below, that says anything: origin, edge, value, state. OpenVDB's own
// iterator over a whole tree counts from the root's first entry to the present one at each step: a root of a hundred
// thousand tiles takes it minutes.
template <typename Node, typename Visit>
void visit_tiles(const Node& node, const typename Node::ValueType& background, const Visit& visit)
{
    using Child = typename Node::ChildNodeType;
    for (auto entry = node.cbeginChildAll(); entry; ++entry) {
        typename Node::ValueType value = background;
        if (const Child* child = entry.probeChild(value)) {
            if constexpr (Child::LEVEL > 0) visit_tiles(*child, background, visit);
        } else if (entry.isValueOn() || value != background) {
            visit(entry.getCoord(), int(Child::DIM), value, entry.isValueOn());
        }
    }
}

template <typename Tree>
Counts count_tree(const Tree& tree)
{
    Counts counts{tree.leafCount(), 0};
    visit_tiles(tree.root(), tree.background(), [&](const Coord&, int, const auto&, bool) { ++counts.tiles; });
    return counts;
}

void check_size(bool fits)
{
    if (!fits) throw std::length_error("a grid does not fit into what was made for it");
}

void store_origin(std::int32_t* target, const Coord& origin)
{
    for (int axis = 0; axis < 3; ++axis) target[axis] = origin[axis];
}

// `Components` floats a value; `Convert` is applied to each component.
template <std::size_t Components, typename Tree, typename Convert>
void copy_tree(const Tree& tree, Target& target, const Convert& convert)
{
    const openvdb::tree::LeafManager<const Tree> leaves(tree);
    const Counts counts = count_tree(tree);
    check_size(target.origins.size() == 3 * counts.blocks && target.masks.size() == 8 * counts.blocks
        && target.values.size() == 512 * Components * counts.blocks && target.tiles.size() == 4 * counts.tiles
        && target.tile_values.size() == Components * counts.tiles && target.tile_states.size() == counts.tiles
        && target.background.size() == Components);
    const auto put = [&](float* place, const auto& value) {
        store(place, value);
        for (std::size_t component = 0; component < Components; ++component) place[component] = convert(place[component]);
    };
    put(target.background.data(), tree.background());
    tbb::parallel_for(std::size_t(0), counts.blocks, [&](std::size_t block) {
        const auto& leaf = leaves.leaf(block);
        store_origin(target.origins.data() + 3 * block, leaf.origin());
        for (Index word = 0; word < 8; ++word) {
            target.masks[8 * block + word] = leaf.getValueMask().template getWord<std::uint64_t>(word);
        }
        const auto* values = leaf.buffer().data();
        for (std::size_t voxel = 0; voxel < 512; ++voxel) {
            put(target.values.data() + Components * (512 * block + voxel), values[voxel]);
        }
    });
    std::size_t index = 0;
    visit_tiles(tree.root(), tree.background(), [&](const Coord& origin, int edge, const auto& value, bool active) {
        store_origin(target.tiles.data() + 4 * index, origin);
        target.tiles[4 * index + 3] = edge;
        put(target.tile_values.data() + Components * index, value);
        target.tile_states[index] = active;
        ++index;
    });
}

// Calls `act` with the tree of a grid of one of the types; false for others.
template <typename Act, typename... GridTypes>
bool with_tree(const openvdb::GridBase& grid, const Act& act, openvdb::TypeList<GridTypes...>)
{
    return grid.apply<openvdb::TypeList<GridTypes...>>([&](const auto& typed) { act(typed.tree()); });
}

using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid>;
using VectorGrids = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

[[noreturn]] void refuse_type(const openvdb::GridBase& grid)
{
    throw std::runtime_error("grid '" + grid.getName() + "' of type " + grid.type() + " has no values to copy");
}

} // namespace

std::shared_ptr<Grid> decode(rust::Slice<const std::uint8_t> bytes, std::size_t descriptor)
{
    start_library();
    return share(Reader().read_one(bytes, descriptor));
}

Counts count(const Grid& grid)
{
    Counts counts{0, 0};
    const openvdb::GridBase& base = *grid.parts().grid;
    const auto act = [&](const auto& tree) { counts = count_tree(tree); };
    if (!with_tree(base, act, FloatGrids()) && !with_tree(base, act, VectorGrids())) refuse_type(base);
    return counts;
}

void copy_floats(const Grid& grid, bool flip, Target& target)
{
    const openvdb::GridBase& base = *grid.parts().grid;
    const auto act = [&](const auto& tree) {
        copy_tree<1>(tree, target, [flip](float value) { return flip ? flip_sign(value) : value; });
    };
    if (!with_tree(base, act, FloatGrids())) refuse_type(base);
}

void copy_vectors(const Grid& grid, Target& target)
{
    const openvdb::GridBase& base = *grid.parts().grid;
    const auto act = [&](const auto& tree) { copy_tree<3>(tree, target, [](float value) { return value; }); };
    if (!with_tree(base, act, VectorGrids())) refuse_type(base);
}

} // namespace hfvdb
