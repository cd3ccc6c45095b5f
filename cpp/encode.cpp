// The parts of a file around its leaves' values: what io::File writes, byte for byte; and values compressed by OpenVDB.
//
// io::File encodes leaf after leaf on one thread, after compressing all of them a first time to learn their sizes for
// its delayed-load metadata. Here runs of leaves are encoded before the metadata is written, by any number of threads.

#include "grids.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>

#include <ostream>
#include <stdexcept>
#include <streambuf>

namespace hfvdb {

namespace io = openvdb::io;

namespace {

constexpr std::int64_t LEAF_VOXELS = 512;

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

    std::unique_ptr<std::string> take()
    {
        if (!stream) throw std::runtime_error("a grid could not be encoded");
        return std::make_unique<std::string>(std::move(mSink.bytes));
    }

private:
    StringSink mSink;
    openvdb::SharedPtr<io::StreamMetadata> mSettings;

public:
    std::ostream stream;
};

// A stream buffer over memory of a fixed size, which is enough.
class MemorySink : public std::streambuf {
public:
    explicit MemorySink(rust::Slice<std::uint8_t> memory)
    {
        char* start = reinterpret_cast<char*>(memory.data());
        setp(start, start + memory.size());
    }

    std::size_t size() const { return std::size_t(pptr() - pbase()); }
};

template <typename Value>
void write_values(std::ostream& out, const float* values, std::size_t count, bool half, std::uint32_t compression)
{
    const Value* first = reinterpret_cast<const Value*>(values);
    if (half) {
        io::HalfWriter<true, Value>::write(out, first, openvdb::Index(count), compression);
    } else {
        io::writeData<Value>(out, first, openvdb::Index(count), compression);
    }
}

static_assert(sizeof(openvdb::Vec3s) == 3 * sizeof(float), "vectors are three floats");

// A copy of a grid, on the same tree, whose metadata may be changed.
openvdb::GridBase::Ptr with_own_metadata(const openvdb::GridBase& grid)
{
    const openvdb::GridBase::ConstPtr shallow = grid.copyGrid();
    return openvdb::ConstPtrCast<openvdb::GridBase>(shallow);
}

// What readers look for of leaves' values: how to find each leaf's without reading those before it.
io::DelayedLoadMetadata delayed_load(const LeafSizes& leaves, std::uint32_t compression)
{
    io::DelayedLoadMetadata delayed;
    delayed.resizeMask(leaves.masks.size());
    const bool compressed = compression & (io::COMPRESS_BLOSC | io::COMPRESS_ZIP);
    if (compressed) delayed.resizeCompressedSize(leaves.sizes.size());
    for (std::size_t leaf = 0; leaf < leaves.masks.size(); ++leaf) {
        delayed.setMask(leaf, leaves.masks[leaf]);
        if (compressed) delayed.setCompressedSize(leaf, leaves.sizes[leaf]);
    }
    return delayed;
}

} // namespace

class Writer::Archive : public io::Archive {
public:
    // Sets what a file's streams have in common.
    io::StreamMetadata settings() const
    {
        io::StreamMetadata settings;
        settings.setSeekable(true);
        MemoryStream out(settings);
        writeHeader(out.stream, /*seekable=*/true); // sets the versions
        settings = *io::getStreamMetadataPtr(out.stream);
        settings.setCompression(compression());
        settings.setWriteGridStats(true);
        return settings;
    }

    // The compression of a grid, which its class has a say in.
    std::uint32_t of_grid(const openvdb::GridBase& grid) const
    {
        StringSink sink;
        std::ostream out(&sink);
        setGridCompression(out, grid);
        return io::getDataCompression(out);
    }

    using io::Archive::setGridCompression;
    using io::Archive::writeHeader;
};

struct Writer::Parts {
    Archive archive;
    io::StreamMetadata settings;
};

Writer::Writer(Codec codec)
    : mParts(std::make_unique<Parts>())
{
    const std::uint32_t flags = codec == Codec::Blosc ? std::uint32_t(io::COMPRESS_BLOSC)
        : codec == Codec::Zip                         ? std::uint32_t(io::COMPRESS_ZIP)
                                                      : std::uint32_t(io::COMPRESS_NONE);
    mParts->archive.setCompression(flags | io::COMPRESS_ACTIVE_MASK);
    mParts->settings = mParts->archive.settings();
}
Writer::~Writer() = default;

std::unique_ptr<std::string> Writer::file_head(rust::Slice<const Meta> metadata, std::int32_t grids)
{
    MemoryStream out(mParts->settings);
    mParts->archive.writeHeader(out.stream, /*seekable=*/true);
    openvdb::MetaMap map;
    insert_metadata(map, metadata);
    map.writeMeta(out.stream);
    out.stream.write(reinterpret_cast<const char*>(&grids), sizeof grids);
    return out.take();
}

std::size_t Writer::leaves(
    const Grid& grid, const Leaves& leaves, rust::Slice<std::int64_t> sizes, rust::Slice<std::uint8_t> target) const
{
    const openvdb::GridBase& base = *grid.parts().grid;
    const bool is_float = base.isType<openvdb::FloatGrid>(), half = base.saveFloatAsHalf();
    const std::uint32_t compression = mParts->archive.of_grid(base);
    MemorySink sink(target);
    std::ostream out(&sink);
    std::size_t head = 0, value = 0;
    for (std::size_t leaf = 0; leaf < leaves.head_ends.size(); ++leaf) {
        const std::size_t head_end = leaves.head_ends[leaf], value_end = leaves.value_ends[leaf];
        out.write(reinterpret_cast<const char*>(leaves.heads.data()) + head, std::streamsize(head_end - head));
        const std::size_t start = sink.size();
        const float* values = leaves.values.data() + value;
        if (is_float) {
            write_values<float>(out, values, value_end - value, half, compression);
        } else {
            write_values<openvdb::Vec3s>(out, values, (value_end - value) / 3, half, compression);
        }
        sizes[leaf] = std::int64_t(sink.size() - start);
        head = head_end;
        value = value_end;
    }
    if (!out) throw std::runtime_error("leaves could not be encoded");
    return sink.size();
}

// Where a grid's nodes stand does not depend on its leaves' values, so both can be encoded at the same time.
struct Nodes::Parts {
    // Has the statistics that readers look for.
    openvdb::GridBase::Ptr metadata;
    // The transform and the nodes down to the leaves' masks.
    std::unique_ptr<std::string> bytes;
};

Nodes::Nodes(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Nodes::~Nodes() = default;

std::unique_ptr<Nodes> Writer::nodes(const Grid& grid) const
{
    const openvdb::GridBase& base = *grid.parts().grid;
    MemoryStream out(mParts->settings);
    io::setGridClass(out.stream, base.getGridClass());
    const std::uint32_t compression = mParts->archive.of_grid(base);
    io::setDataCompression(out.stream, compression);
    base.writeTransform(out.stream);
    base.writeTopology(out.stream);

    const openvdb::GridBase::Ptr metadata = with_own_metadata(base);
    metadata->addStatsMetadata();
    // The memory of the grid as its readers have it: with the values, which its leaves here lack.
    const std::int64_t values = std::int64_t(base.baseTree().leafCount()) * LEAF_VOXELS;
    const bool is_float = base.isType<openvdb::FloatGrid>();
    const std::int64_t value_bytes = values * std::int64_t(is_float ? sizeof(float) : sizeof(openvdb::Vec3s));
    metadata->insertMeta(openvdb::GridBase::META_FILE_MEM_BYTES,
        openvdb::Int64Metadata(std::int64_t(base.memUsage()) + value_bytes));
    metadata->insertMeta(
        openvdb::GridBase::META_FILE_COMPRESSION, openvdb::StringMetadata(io::compressionToString(compression)));
    return std::make_unique<Nodes>(std::make_unique<Nodes::Parts>(Nodes::Parts{metadata, out.take()}));
}

std::unique_ptr<std::string> Writer::grid_head(
    const Nodes& nodes, const LeafSizes& leaves, std::int64_t position) const
{
    const openvdb::GridBase& base = *nodes.parts().metadata;
    MemoryStream out(mParts->settings);
    io::GridDescriptor descriptor(base.getName(), base.type(), base.saveFloatAsHalf());
    descriptor.writeHeader(out.stream);
    const std::size_t offsets_at = out.bytes().size();
    descriptor.writeStreamPos(out.stream); // to be replaced below
    descriptor.setGridPos(position + std::int64_t(out.bytes().size()));
    mParts->archive.setGridCompression(out.stream, base); // writes it too
    if (leaves.masks.empty()) {
        base.writeMeta(out.stream);
    } else {
        const openvdb::GridBase::Ptr copy = with_own_metadata(base);
        copy->insertMeta(
            openvdb::GridBase::META_FILE_DELAYED_LOAD, delayed_load(leaves, io::getDataCompression(out.stream)));
        copy->writeMeta(out.stream);
    }
    const std::string& bytes = *nodes.parts().bytes;
    out.stream.write(bytes.data(), std::streamsize(bytes.size()));
    const std::int64_t end = position + std::int64_t(out.bytes().size());
    descriptor.setBlockPos(end);
    descriptor.setEndPos(end + leaves.bytes);
    MemoryStream offsets(mParts->settings);
    descriptor.writeStreamPos(offsets.stream);
    std::unique_ptr<std::string> head = out.take();
    head->replace(offsets_at, offsets.bytes().size(), offsets.bytes());
    return head;
}

std::unique_ptr<Writer> new_writer(Codec codec)
{
    start_library();
    return std::make_unique<Writer>(codec);
}

} // namespace hfvdb
