// Grids as NanoVDB has them, and the file of them: by NanoVDB's own headers, of version 32, which come with OpenVDB 10.

#include "grids.h"

#if OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER == 10 && __has_include(<nanovdb/util/OpenToNanoVDB.h>)

#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace hfvdb {

namespace {

// Memory for a grid, zeroed: its padding goes into the file, which is to be the same each time.
class Zeroed {
public:
    explicit Zeroed(std::uint64_t size = 0)
        : mSize(size)
    {
        if (size == 0) return;
        constexpr std::uint64_t alignment = NANOVDB_DATA_ALIGNMENT;
        const std::uint64_t whole = (size + alignment - 1) / alignment * alignment;
        mData.reset(static_cast<std::uint8_t*>(std::aligned_alloc(alignment, whole)));
        if (!mData) throw std::bad_alloc();
        std::memset(mData.get(), 0, whole);
    }

    static Zeroed create(std::uint64_t size, const Zeroed* = nullptr) { return Zeroed(size); }

    std::uint8_t* data() { return mData.get(); }
    const std::uint8_t* data() const { return mData.get(); }
    std::uint64_t size() const { return mSize; }
    void clear()
    {
        mData.reset();
        mSize = 0;
    }

private:
    struct Free {
        void operator()(std::uint8_t* memory) const { std::free(memory); }
    };
    std::unique_ptr<std::uint8_t, Free> mData;
    std::uint64_t mSize;
};

using Handle = nanovdb::GridHandle<Zeroed>;

nanovdb::io::Codec codec_of(Codec codec)
{
    return codec == Codec::Blosc ? nanovdb::io::Codec::BLOSC
        : codec == Codec::Zip    ? nanovdb::io::Codec::ZIP
                                 : nanovdb::io::Codec::NONE;
}

} // namespace

struct Nano::Parts {
    Handle handle;
};

struct NanoFile::Parts {
    nanovdb::io::Segment segment;
};

std::unique_ptr<Nano> to_nano(const Grid& grid, bool half)
{
    const openvdb::GridBase& base = *grid.parts().grid;
    Handle handle;
    if (base.isType<openvdb::FloatGrid>()) {
        const auto& floats = static_cast<const openvdb::FloatGrid&>(base);
        handle = half ? nanovdb::openToNanoVDB<Zeroed, openvdb::FloatTree, nanovdb::Fp16>(floats)
                      : nanovdb::openToNanoVDB<Zeroed, openvdb::FloatTree>(floats);
    } else if (base.isType<openvdb::Vec3SGrid>() && !half) {
        handle = nanovdb::openToNanoVDB<Zeroed, openvdb::Vec3STree>(static_cast<const openvdb::Vec3SGrid&>(base));
    } else {
        throw std::runtime_error("NanoVDB has no such grid");
    }
    return std::make_unique<Nano>(std::make_unique<Nano::Parts>(Nano::Parts{std::move(handle)}));
}

std::unique_ptr<std::string> NanoFile::add(const Nano& nano)
{
    const Handle& handle = nano.parts().handle;
    nanovdb::io::Segment& segment = mParts->segment;
    segment.add(handle);
    auto bytes = std::make_unique<std::string>();
    if (segment.header.codec == nanovdb::io::Codec::NONE) {
        bytes->assign(reinterpret_cast<const char*>(handle.data()), handle.size());
    } else {
        std::ostringstream out;
        nanovdb::io::Internal::write(out, handle, segment.header.codec);
        *bytes = out.str();
    }
    segment.meta.back().fileSize = bytes->size();
    return bytes;
}

std::unique_ptr<std::string> NanoFile::head() const
{
    std::ostringstream out;
    mParts->segment.write(out);
    return std::make_unique<std::string>(out.str());
}

std::unique_ptr<NanoFile> new_nano_file(Codec codec)
{
    start_library();
    const nanovdb::io::Segment segment(codec_of(codec));
    return std::make_unique<NanoFile>(std::make_unique<NanoFile::Parts>(NanoFile::Parts{segment}));
}

} // namespace hfvdb

#else

#include <stdexcept>

namespace hfvdb {

struct Nano::Parts {};
struct NanoFile::Parts {};

namespace {

[[noreturn]] void missing()
{
    throw std::runtime_error("this program was built without NanoVDB: install the Debian package libnanovdb-dev, of "
                             "OpenVDB 10, and build it again");
}

} // namespace

std::unique_ptr<Nano> to_nano(const Grid&, bool)
{
    missing();
}
std::unique_ptr<std::string> NanoFile::add(const Nano&)
{
    missing();
}
std::unique_ptr<std::string> NanoFile::head() const
{
    missing();
}
std::unique_ptr<NanoFile> new_nano_file(Codec)
{
    missing();
}

} // namespace hfvdb

#endif

namespace hfvdb {

Nano::Nano(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
Nano::~Nano() = default;

NanoFile::NanoFile(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
NanoFile::~NanoFile() = default;

} // namespace hfvdb
