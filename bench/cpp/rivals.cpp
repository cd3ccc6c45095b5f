#include "rivals.h"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace rivals {

namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;

// Calls `act` with the bounds of each thread's share of `count`.
template <typename Act>
void share(std::size_t count, std::size_t threads, const Act& act)
{
    std::vector<std::thread> workers;
    for (std::size_t thread = 0; thread < threads; ++thread) {
        workers.emplace_back([&, thread] { act(thread, count * thread / threads, count * (thread + 1) / threads); });
    }
    for (std::thread& worker : workers) worker.join();
}

// Seconds that all threads of the process have run.
double processor_seconds()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

// Has OpenVDB encode a tree's leaves, in runs of as many as a cache holds; returns the bytes they take.
std::size_t encode_tree(const Tree& tree, std::size_t threads, std::uint32_t compression)
{
    constexpr std::size_t LEAVES_A_RUN = 256;
    const openvdb::tree::LeafManager<const Tree> leaves(tree);
    std::vector<std::string> runs((leaves.leafCount() + LEAVES_A_RUN - 1) / LEAVES_A_RUN);
    share(runs.size(), threads, [&](std::size_t, std::size_t first, std::size_t end) {
        for (std::size_t run = first; run < end; ++run) {
            std::ostringstream out;
            openvdb::io::setDataCompression(out, compression | openvdb::io::COMPRESS_ACTIVE_MASK);
            openvdb::io::setGridBackgroundValuePtr(out, &tree.background());
            const std::size_t end_leaf = std::min(leaves.leafCount(), (run + 1) * LEAVES_A_RUN);
            for (std::size_t leaf = run * LEAVES_A_RUN; leaf < end_leaf; ++leaf) {
                leaves.leaf(leaf).writeBuffers(out, /*toHalf=*/false);
            }
            runs[run] = out.str();
        }
    });
    std::size_t bytes = 0;
    for (const std::string& run : runs) bytes += run.size();
    return bytes;
}

} // namespace

struct LibraryFrame::Parts {
    openvdb::GridPtrVecPtr grids;
    openvdb::MetaMap::Ptr metadata;
};

LibraryFrame::LibraryFrame(rust::Str path)
    : mParts(std::make_unique<Parts>())
{
    openvdb::initialize();
    openvdb::io::File file{std::string(path)};
    file.open(/*delayLoad=*/false);
    mParts->grids = file.getGrids();
    mParts->metadata = file.getMetadata();
}
LibraryFrame::~LibraryFrame() = default;

void LibraryFrame::write(rust::Str path) const
{
    const std::string name(path);
    openvdb::io::File file(name);
    file.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    file.write(*mParts->grids, *mParts->metadata);
    file.close();
    const int descriptor = open(name.c_str(), O_RDONLY);
    if (descriptor < 0 || fsync(descriptor) != 0) throw std::runtime_error("cannot sync " + name);
    close(descriptor);
}

std::unique_ptr<LibraryFrame> read_with_library(rust::Str path)
{
    return std::make_unique<LibraryFrame>(path);
}

// What an experienced C++ programmer writes: each thread copies its share of leaves and links them into a tree of its
// own, and the trees, which share no leaf, are merged by moving nodes. Then each thread has OpenVDB encode its share.
std::size_t encode_in_cpp(rust::Slice<const std::int32_t> origins, rust::Slice<const std::uint64_t> masks,
    rust::Slice<const float> values, float background, std::size_t threads,
    std::array<double, 2>& seconds)
{
    const auto start = std::chrono::steady_clock::now();
    const double processor_start = processor_seconds();
    std::vector<std::unique_ptr<Tree>> trees(threads);
    share(origins.size() / 3, threads, [&](std::size_t thread, std::size_t first, std::size_t end) {
        trees[thread] = std::make_unique<Tree>(background);
        openvdb::tree::ValueAccessor<Tree> accessor(*trees[thread]);
        for (std::size_t block = first; block < end; ++block) {
            const openvdb::Coord origin(origins[3 * block], origins[3 * block + 1], origins[3 * block + 2]);
            auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), origin, background, false);
            leaf->allocate();
            std::memcpy(leaf->buffer().data(), values.data() + 512 * block, 512 * sizeof(float));
            for (openvdb::Index word = 0; word < 8; ++word) {
                leaf->getValueMask().getWord<std::uint64_t>(word) = masks[8 * block + word];
            }
            accessor.addLeaf(leaf.release());
        }
    });
    for (std::size_t thread = 1; thread < threads; ++thread) trees[0]->merge(*trees[thread]);
    const std::size_t bytes = encode_tree(*trees[0], threads, openvdb::io::COMPRESS_BLOSC);
    seconds[0] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    seconds[1] = processor_seconds() - processor_start;
    return bytes;
}

struct VoxelTree::Parts {
    Tree tree;
    openvdb::tree::ValueAccessor<Tree> accessor;

    explicit Parts(float background)
        : tree(background)
        , accessor(tree)
    {
    }
};

VoxelTree::VoxelTree(float background)
    : mParts(std::make_unique<Parts>(background))
{
}
VoxelTree::~VoxelTree() = default;

void VoxelTree::set(std::int32_t x, std::int32_t y, std::int32_t z, float value)
{
    mParts->accessor.setValueOn(openvdb::Coord(x, y, z), value);
}

std::size_t VoxelTree::encode() const
{
    return encode_tree(mParts->tree, 1, openvdb::io::COMPRESS_NONE);
}

std::unique_ptr<VoxelTree> new_voxel_tree(float background)
{
    return std::make_unique<VoxelTree>(background);
}

} // namespace rivals
