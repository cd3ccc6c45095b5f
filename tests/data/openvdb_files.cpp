// Files of all kinds by OpenVDB's own writer, each with what OpenVDB's own reader finds in it, bit for bit; and chunks by
// Blosc. For src/vdb/tests/decode.rs, which compiles and runs this.
//
//     openvdb_files FOLDER
//
// NAME.vdb is a file, NAME.found the grids of numbers and vectors in it, in the file's order. Of each: the matrix of its
// transform (zeros where it is a frustum), its background, how many leaves, and of each leaf origin, mask and values; how many
// tiles that are active or not the background, and of each origin, edge, state and value. Numbers of values are 32-bit floats, of
// level sets positive inside. NAME.chunk is a chunk of Blosc, NAME.bytes what it holds.

#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <blosc.h>

#include <cmath>
#include <fstream>

using namespace openvdb;

namespace {

template <typename V>
V value(double number)
{
    if constexpr (VecTraits<V>::IsVec) {
        return V(number, -0.5 * number, number + 1.0);
    } else {
        return V(number);
    }
}

// Leaves with each way to keep inactive values, with no, few, many and all voxels active; tiles of all sizes.
template <typename GridType>
typename GridType::Ptr make(const std::string& name, double outside, bool half, bool level_set)
{
    using V = typename GridType::ValueType;
    auto grid = GridType::create(value<V>(outside));
    auto voxels = grid->getAccessor();
    const V background = grid->background(), minus = -background;
    for (int kind = 0; kind < 9; ++kind) {
        for (int share = 0; share < 5; ++share) {
            const Coord origin(8 * kind, 8 * share, kind % 2 ? -8 : 0);
            for (int n = 0; n < 512; ++n) {
                const Coord voxel = origin + Coord(n >> 6, n >> 3 & 7, n & 7);
                const bool active[] = {false, n % 97 == 3, n % 3 == 0, n % 5 != 0, true};
                const double smooth = std::sin(n * 0.02), few = 0.25 * (n % 4), noise = std::sin(n * n * 12.9898) * 43758.5;
                const V inactive[] = {background, minus, value<V>(7.3), n % 2 ? minus : background,
                    n % 2 ? value<V>(7.3) : background, value<V>(n % 2 ? 7.3 : -1.7), value<V>(n * 0.37),
                    n % 2 ? value<V>(-0.0) : minus, value<V>(std::nan(""))};
                if (active[share]) {
                    voxels.setValueOn(voxel, value<V>(kind % 3 == 0 ? few : kind % 3 == 1 ? smooth : noise - std::floor(noise)));
                } else {
                    voxels.setValueOff(voxel, inactive[kind]);
                }
            }
        }
    }
    auto& tree = grid->tree();
    const auto tiles = [&](Index level, int edge, int y) {
        tree.addTile(level, Coord(edge * 20, y, 0), value<V>(3.1), true);
        tree.addTile(level, Coord(edge * 21, y, 0), value<V>(-3.1), false);
        tree.addTile(level, Coord(edge * 22, y, 0), minus, false);
        tree.addTile(level, Coord(edge * 23, y, 0), background, true);
    };
    tiles(1, 8, 64);
    tiles(2, 128, 128);
    tiles(3, 4096, -4096);
    grid->setName(name);
    grid->setSaveFloatAsHalf(half);
    if (level_set) grid->setGridClass(GRID_LEVEL_SET);
    return grid;
}

template <typename GridType>
void add_all(const std::string& name, GridPtrVec& grids)
{
    grids.push_back(make<GridType>(name + " level set", 0.5, false, true));
    grids.push_back(make<GridType>(name + " half", 0.3, true, false));
    grids.push_back(make<GridType>(name + " minus zero", -0.0, false, false));
    grids.push_back(make<GridType>(name + " half level set", std::nan(""), true, true));
}

// A voxel for each half float.
FloatGrid::Ptr halves()
{
    auto grid = FloatGrid::create(0.0f);
    auto voxels = grid->getAccessor();
    for (int bits = 0; bits < 65536; ++bits) {
        math::half half;
        half.setBits(std::uint16_t(bits));
        voxels.setValueOn(Coord(bits >> 10, bits >> 5 & 31, bits & 31), half);
    }
    grid->setName("halves");
    grid->setSaveFloatAsHalf(true);
    return grid;
}

GridPtrVec all_grids()
{
    GridPtrVec grids;
    add_all<FloatGrid>("float", grids);
    add_all<DoubleGrid>("double", grids);
    add_all<Vec3SGrid>("vec3s", grids);
    add_all<Vec3DGrid>("vec3d", grids);
    grids.push_back(halves());
    const auto twin = grids[0]->copyGrid();
    twin->setName("twin");
    twin->setGridClass(GRID_UNKNOWN);
    grids.push_back(twin);
    grids.push_back(DoubleGrid::create(0.3));
    grids.back()->setName("empty");
    const auto flags = BoolGrid::create();
    flags->fill(CoordBBox(Coord(0), Coord(20)), true);
    flags->setName("flags");
    grids.push_back(flags);
    const auto numbers = Int32Grid::create(4);
    numbers->fill(CoordBBox(Coord(0), Coord(20)), 7);
    numbers->setName("numbers");
    grids.push_back(numbers);

    const auto affine = math::Transform::createLinearTransform(0.1);
    affine->preRotate(0.3, math::X_AXIS);
    affine->postTranslate(Vec3d(1, 2, 3));
    grids[1]->setTransform(affine);
    const auto moved = math::Transform::createLinearTransform(0.3);
    moved->postTranslate(Vec3d(0.1, -0.7, 1e5));
    grids[2]->setTransform(moved);
    const auto scaled = math::Transform::createLinearTransform(1.0);
    scaled->preScale(Vec3d(0.1, 0.2, -0.7));
    grids[3]->setTransform(scaled);
    grids[4]->setTransform(
        math::Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(100)), 0.5, 10.0, 0.1));
    return grids;
}

template <typename T>
void put(std::ostream& out, T number)
{
    out.write(reinterpret_cast<const char*>(&number), sizeof number);
}

template <typename V>
void put_value(std::ostream& out, const V& value, bool flip)
{
    if constexpr (VecTraits<V>::IsVec) {
        for (int axis = 0; axis < 3; ++axis) put(out, float(value[axis]));
    } else {
        put(out, flip ? 0.0f - float(value) : float(value));
    }
}

void put_coordinate(std::ostream& out, const Coord& place)
{
    for (int axis = 0; axis < 3; ++axis) put(out, place[axis]);
}

template <typename GridType>
void put_grid(std::ostream& out, const GridType& grid)
{
    const bool flip = grid.getGridClass() == GRID_LEVEL_SET;
    const Mat4d matrix = grid.transform().isLinear() ? grid.transform().baseMap()->getAffineMap()->getMat4() : Mat4d::zero();
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) put(out, matrix(row, column));
    }
    put_value(out, grid.background(), flip);
    put(out, std::uint64_t(grid.tree().leafCount()));
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        put_coordinate(out, leaf->origin());
        for (Index n = 0; n < 512; n += 64) put(out, leaf->getValueMask().template getWord<std::uint64_t>(n / 64));
        for (Index n = 0; n < 512; ++n) put_value(out, leaf->getValue(n), flip);
    }
    for (const bool counts : {true, false}) {
        std::uint64_t tiles = 0;
        auto tile = grid.tree().cbeginValueAll();
        tile.setMaxDepth(GridType::TreeType::RootNodeType::LEVEL - 1);
        for (; tile; ++tile) {
            if (!tile.isValueOn() && *tile == grid.background()) continue;
            ++tiles;
            if (counts) continue;
            put_coordinate(out, tile.getBoundingBox().min());
            put(out, tile.getBoundingBox().dim().x());
            put(out, std::int32_t(tile.isValueOn()));
            put_value(out, *tile, flip);
        }
        if (counts) put(out, tiles);
    }
}

void put_found(const std::string& path, const GridPtrVec& grids)
{
    io::File file(path + ".vdb");
    file.open(/*delayLoad=*/false);
    std::ofstream out(path + ".found", std::ios::binary);
    for (const GridBase::Ptr& written : grids) {
        const GridBase::Ptr grid = file.readGrid(written->getName());
        grid->apply<TypeList<FloatGrid, DoubleGrid, Vec3SGrid, Vec3DGrid>>([&](const auto& typed) { put_grid(out, typed); });
    }
}

void write_files(const std::string& folder)
{
    const GridPtrVec grids = all_grids();
    const std::pair<const char*, std::uint32_t> codecs[] = {{"none", io::COMPRESS_NONE}, {"zip", io::COMPRESS_ZIP},
        {"blosc", io::COMPRESS_BLOSC}, {"active", io::COMPRESS_ACTIVE_MASK},
        {"zip active", io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK},
        {"blosc active", io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK}};
    for (const auto& [name, codec] : codecs) {
        io::File file(folder + "/" + name + ".vdb");
        file.setCompression(codec);
        file.write(grids);
        file.close();
        put_found(folder + "/" + name, grids);
    }
    // Without offsets.
    std::ofstream out(folder + "/stream.vdb", std::ios::binary);
    io::Stream stream(out);
    stream.setCompression(io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
    stream.write(grids);
    out.close();
    put_found(folder + "/stream", grids);
}

void write_chunks(const std::string& folder)
{
    int number = 0;
    for (const std::size_t size : {std::size_t(0), std::size_t(4), std::size_t(127), std::size_t(2048), std::size_t(6132)}) {
        std::string bytes(size, '\0');
        for (std::size_t n = 0; n < size; ++n) bytes[n] = char(n % 4 == 3 ? n / 64 : n % 4 == 2 ? n * n * 7 / 5 : n / 7);
        for (const std::size_t value : {1, 2, 4, 8, 12, 24}) {
            for (const std::size_t block : {0, 256, 1000, 1 << 20}) {
                for (const int shuffled : {0, 1}) {
                    std::string chunk(size + BLOSC_MAX_OVERHEAD, '\0');
                    const int length = blosc_compress_ctx(
                        9, shuffled, value, size, bytes.data(), chunk.data(), chunk.size(), BLOSC_LZ4_COMPNAME, block, 1);
                    if (length < 0) throw std::runtime_error("Blosc fails");
                    chunk.resize(std::size_t(length));
                    const std::string path = folder + "/" + std::to_string(number++);
                    std::ofstream(path + ".chunk", std::ios::binary) << chunk;
                    std::ofstream(path + ".bytes", std::ios::binary) << bytes;
                }
            }
        }
    }
}

} // namespace

int main(int, char** arguments)
{
    initialize();
    write_files(arguments[1]);
    write_chunks(arguments[1]);
}
