// Grids to a file's bytes: what io::File writes, byte for byte, with the leaves encoded on all threads and once.
//
// io::File encodes leaf after leaf on one thread, after compressing all of them a first time to learn their sizes for
// its delayed-load metadata. Here runs of leaves are encoded by OpenVDB's own leaf writer into memory, on all threads,
// before the metadata is written, so their sizes are known by then.

#include "grids.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>
#include <ostream>
#include <stdexcept>
#include <streambuf>

namespace hfvdb {

namespace io = openvdb::io;

struct Encoded::Parts {
    std::vector<std::string> pieces;
};

namespace {

// Leaves encoded into one piece: some 100 KiB of output, enough to outweigh a stream's start, few enough to share.
constexpr std::size_t LEAVES_A_PIECE = 256;
// The value mask that a leaf's buffer starts with, and the byte after it that says how inactive values are kept.
constexpr std::size_t LEAF_MASK_BYTES = 64;

// A stream buffer that grows a string.
class StringSink : public std::streambuf {
public:
    std::string bytes;

protected:
    std::streamsize xsputn(const char* data, std::streamsize count) override
    {
        bytes.append(data, std::size_t(count));
        return count;
    }
    int_type overflow(int_type byte) override
    {
        if (!traits_type::eq_int_type(byte, traits_type::eof())) bytes.push_back(traits_type::to_char_type(byte));
        return traits_type::not_eof(byte);
    }
    // Positions are asked for, never changed.
    pos_type seekoff(off_type offset, std::ios_base::seekdir way, std::ios_base::openmode) override
    {
        return offset == 0 && way == std::ios_base::cur ? pos_type(off_type(bytes.size())) : pos_type(off_type(-1));
    }
};

// A stream into memory. It has a copy of the settings of its own: they hold pointers and counters that threads must
// not share, and the stream keeps the address of the pointer to them, so they live as long as it.
class MemoryStream {
public:
    explicit MemoryStream(const io::StreamMetadata& settings)
        : mSettings(new io::StreamMetadata(settings))
        , stream(&mSink)
    {
        io::setStreamMetadataPtr(stream, mSettings);
    }

    const std::string& bytes() const { return mSink.bytes; }

    std::string take()
    {
        if (!stream) throw std::runtime_error("a grid could not be encoded");
        return std::move(mSink.bytes);
    }

private:
    StringSink mSink;
    openvdb::SharedPtr<io::StreamMetadata> mSettings;

public:
    std::ostream stream;
};

struct Leaves {
    std::vector<std::string> pieces;
    std::vector<std::int8_t> masks;
    std::vector<std::int64_t> sizes;
};

// Bytes of a leaf before its compressed values, by the byte that says how inactive values are kept.
std::size_t leaf_head_bytes(std::int8_t flag, std::size_t value_bytes)
{
    const std::size_t values = flag == io::MASK_AND_TWO_INACTIVE_VALS ? 2
        : flag == io::NO_MASK_AND_ONE_INACTIVE_VAL || flag == io::MASK_AND_ONE_INACTIVE_VAL ? 1
                                                                                            : 0;
    const bool selection = flag == io::MASK_AND_NO_INACTIVE_VALS || flag == io::MASK_AND_ONE_INACTIVE_VAL
        || flag == io::MASK_AND_TWO_INACTIVE_VALS;
    return LEAF_MASK_BYTES + 1 + values * value_bytes + (selection ? LEAF_MASK_BYTES : 0);
}

template <typename GridType>
Leaves encode_leaves(const GridType& grid, const io::StreamMetadata& settings)
{
    using Tree = typename GridType::TreeType;
    const Tree& tree = grid.tree();
    const openvdb::tree::LeafManager<const Tree> manager(tree);
    const std::size_t count = manager.leafCount();
    Leaves leaves;
    leaves.pieces.resize((count + LEAVES_A_PIECE - 1) / LEAVES_A_PIECE);
    leaves.masks.resize(count);
    leaves.sizes.resize(count);
    tbb::parallel_for(std::size_t(0), leaves.pieces.size(), [&](std::size_t piece) {
        MemoryStream out(settings);
        io::setGridBackgroundValuePtr(out.stream, &tree.background());
        const std::size_t end = std::min(count, (piece + 1) * LEAVES_A_PIECE);
        for (std::size_t leaf = piece * LEAVES_A_PIECE; leaf != end; ++leaf) {
            const std::size_t start = out.bytes().size();
            manager.leaf(leaf).writeBuffers(out.stream, grid.saveFloatAsHalf());
            leaves.masks[leaf] = std::int8_t(out.bytes().at(start + LEAF_MASK_BYTES));
            leaves.sizes[leaf] = std::int64_t(out.bytes().size() - start
                - leaf_head_bytes(leaves.masks[leaf], sizeof(typename GridType::ValueType)));
        }
        leaves.pieces[piece] = out.take();
    });
    return leaves;
}

Leaves encode_leaves(const openvdb::GridBase& grid, const io::StreamMetadata& settings)
{
    if (const auto* floats = dynamic_cast<const openvdb::FloatGrid*>(&grid)) return encode_leaves(*floats, settings);
    if (const auto* vectors = dynamic_cast<const openvdb::Vec3SGrid*>(&grid)) return encode_leaves(*vectors, settings);
    throw std::runtime_error("grid '" + grid.getName() + "' is of type " + grid.type() + ", which is not written here");
}

class Writer : public io::Archive {
public:
    std::vector<std::string> write_file(const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const
    {
        io::StreamMetadata settings;
        settings.setSeekable(true);
        MemoryStream out(settings);
        writeHeader(out.stream, /*seekable=*/true); // sets the versions
        settings = *io::getStreamMetadataPtr(out.stream);
        settings.setCompression(compression());
        settings.setWriteGridStats(true);
        metadata.writeMeta(out.stream);
        const std::int32_t count = std::int32_t(grids.size());
        out.stream.write(reinterpret_cast<const char*>(&count), sizeof count);

        std::vector<std::string> pieces{out.take()};
        std::int64_t position = std::int64_t(pieces.back().size());
        for (const openvdb::GridBase::ConstPtr& grid : grids) write_one(*grid, settings, pieces, position);
        return pieces;
    }

private:
    void write_one(const openvdb::GridBase& grid, const io::StreamMetadata& settings, std::vector<std::string>& pieces,
        std::int64_t& position) const
    {
        MemoryStream out(settings);
        io::setGridClass(out.stream, grid.getGridClass());
        io::GridDescriptor descriptor(grid.getName(), grid.type(), grid.saveFloatAsHalf());
        descriptor.writeHeader(out.stream);
        const std::size_t offsets_at = out.bytes().size();
        descriptor.writeStreamPos(out.stream); // to be replaced below
        descriptor.setGridPos(position + std::int64_t(out.bytes().size()));
        setGridCompression(out.stream, grid);

        Leaves leaves = encode_leaves(grid, *io::getStreamMetadataPtr(out.stream));
        write_metadata(grid, leaves, out.stream);
        grid.writeTransform(out.stream);
        grid.writeTopology(out.stream);
        descriptor.setBlockPos(position + std::int64_t(out.bytes().size()));

        position += std::int64_t(out.bytes().size());
        for (const std::string& piece : leaves.pieces) position += std::int64_t(piece.size());
        descriptor.setEndPos(position);
        MemoryStream offsets(settings);
        descriptor.writeStreamPos(offsets.stream);
        const std::string offset_bytes = offsets.take();
        pieces.push_back(out.take().replace(offsets_at, offset_bytes.size(), offset_bytes));
        std::move(leaves.pieces.begin(), leaves.pieces.end(), std::back_inserter(pieces));
    }

    // A grid's metadata with the statistics and sizes that readers look for.
    static void write_metadata(const openvdb::GridBase& grid, const Leaves& leaves, std::ostream& stream)
    {
        const openvdb::GridBase::ConstPtr shallow = grid.copyGrid();
        const openvdb::GridBase::Ptr copy = openvdb::ConstPtrCast<openvdb::GridBase>(shallow);
        copy->addStatsMetadata();
        const std::uint32_t flags = io::getDataCompression(stream);
        copy->insertMeta(
            openvdb::GridBase::META_FILE_COMPRESSION, openvdb::StringMetadata(io::compressionToString(flags)));
        if (!leaves.masks.empty()) {
            io::DelayedLoadMetadata delayed;
            delayed.resizeMask(leaves.masks.size());
            const bool compressed = flags & (io::COMPRESS_BLOSC | io::COMPRESS_ZIP);
            if (compressed) delayed.resizeCompressedSize(leaves.sizes.size());
            for (std::size_t leaf = 0; leaf < leaves.masks.size(); ++leaf) {
                delayed.setMask(leaf, leaves.masks[leaf]);
                if (compressed) delayed.setCompressedSize(leaf, leaves.sizes[leaf]);
            }
            copy->insertMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD, delayed);
        }
        copy->writeMeta(stream);
    }
};

} // namespace

Encoded::Encoded(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Encoded::~Encoded() = default;

std::size_t Encoded::pieces() const
{
    return mParts->pieces.size();
}

rust::Slice<const std::uint8_t> Encoded::piece(std::size_t index) const
{
    const std::string& bytes = mParts->pieces.at(index);
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

std::unique_ptr<Encoded> encode(const Frame& frame, Codec codec)
{
    start_library();
    Writer writer;
    const std::uint32_t flags = codec == Codec::Blosc ? std::uint32_t(io::COMPRESS_BLOSC)
        : codec == Codec::Zip                         ? std::uint32_t(io::COMPRESS_ZIP)
                                                      : std::uint32_t(io::COMPRESS_NONE);
    writer.setCompression(flags | io::COMPRESS_ACTIVE_MASK);
    auto parts = std::make_unique<Encoded::Parts>();
    parts->pieces = writer.write_file(frame.parts().grids, frame.parts().metadata);
    return std::make_unique<Encoded>(std::move(parts));
}

} // namespace hfvdb
