// What Rust sees of the C++ side. Includes no OpenVDB header.
#pragma once

#include "rust/cxx.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <string>

// Every exception becomes a Rust error, also one that is no std::exception.
namespace rust {
namespace behavior {
template <typename Try, typename Fail>
static void trycatch(Try&& func, Fail&& fail) noexcept
{
    try {
        func();
    } catch (const std::bad_alloc&) {
        fail("not enough memory");
    } catch (const std::exception& error) {
        fail(error.what());
    } catch (...) {
        fail("an exception of an unknown type");
    }
}
} // namespace behavior
} // namespace rust

namespace hfvdb {

struct Meta;
struct Head;
struct Blocks;
struct Leaves;
struct LeafSizes;
enum class Codec : std::uint8_t;

rust::String library_version();
void set_thread_limit(std::size_t threads);

// A grid; what it holds is in grids.h.
class Grid {
public:
    struct Parts;
    explicit Grid(std::unique_ptr<Parts> parts);
    ~Grid();
    const Parts& parts() const { return *mParts; }

private:
    std::unique_ptr<Parts> mParts;
};

// The nodes, leaves and tiles of a grid.
std::shared_ptr<Grid> float_grid(const Head& head, const Blocks& blocks, float background, rust::Slice<const float> tile_values);
std::shared_ptr<Grid> vector_grid(
    const Head& head, const Blocks& blocks, std::array<float, 3> background, rust::Slice<const float> tile_values);

// What a grid's head says of all but its values; what it holds is in encode.cpp.
class Nodes {
public:
    struct Parts;
    explicit Nodes(std::unique_ptr<Parts> parts);
    ~Nodes();
    const Parts& parts() const { return *mParts; }

private:
    std::unique_ptr<Parts> mParts;
};

// The parts of a file.
class Writer {
public:
    explicit Writer(Codec codec);
    ~Writer();
    std::unique_ptr<std::string> file_head(rust::Slice<const Meta> metadata, std::int32_t grids);
    std::size_t leaves(const Grid& grid, const Leaves& leaves, rust::Slice<std::int64_t> sizes,
        rust::Slice<std::uint8_t> target) const;
    std::unique_ptr<Nodes> nodes(const Grid& grid) const;
    std::unique_ptr<std::string> grid_head(const Nodes& nodes, const LeafSizes& leaves, std::int64_t position) const;

private:
    class Archive;
    struct Parts;
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<Writer> new_writer(Codec codec);

// A grid as NanoVDB has it; what it holds is in nano.cpp.
class Nano {
public:
    struct Parts;
    explicit Nano(std::unique_ptr<Parts> parts);
    ~Nano();
    const Parts& parts() const { return *mParts; }

private:
    std::unique_ptr<Parts> mParts;
};

// A file of such grids.
class NanoFile {
public:
    struct Parts;
    explicit NanoFile(std::unique_ptr<Parts> parts);
    ~NanoFile();
    std::unique_ptr<std::string> add(const Nano& nano);
    std::unique_ptr<std::string> head() const;

private:
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<Nano> to_nano(const Grid& grid, bool half);
std::unique_ptr<NanoFile> new_nano_file(Codec codec);

struct Cancel;
struct Counts;
struct Target;

std::shared_ptr<Grid> morphed(const Grid& source, const Grid& target, double duration, const Cancel& cancel);
Counts count(const Grid& level_set);
void copy(const Grid& level_set, Target& target);

} // namespace hfvdb
