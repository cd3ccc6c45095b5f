// What Rust sees of the C++ side. Includes no OpenVDB header.
#pragma once

#include "rust/cxx.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>

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
enum class Codec : std::uint8_t;

rust::String library_version();
void set_thread_limit(std::size_t threads);

// A finished grid; what it holds is in grids.h.
class Grid {
public:
    struct Parts;
    explicit Grid(std::unique_ptr<Parts> parts);
    ~Grid();
    const Parts& parts() const { return *mParts; }

private:
    std::unique_ptr<Parts> mParts;
};

std::shared_ptr<Grid> level_set(
    const Head& head, const Blocks& blocks, rust::Slice<const float> distances, float background);
std::shared_ptr<Grid> float_grid(
    const Head& head, const Blocks& blocks, rust::Slice<const float> values, float background, float tile_value);
std::shared_ptr<Grid> vector_grid(const Head& head, const Blocks& blocks, rust::Slice<const float> values,
    std::array<float, 3> background, std::array<float, 3> tile_value);

// Grids and metadata of one file.
class Frame {
public:
    struct Parts;
    explicit Frame(std::unique_ptr<Parts> parts);
    ~Frame();
    void add(std::shared_ptr<Grid> grid);
    const Parts& parts() const { return *mParts; }

private:
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<Frame> new_frame(rust::Slice<const Meta> metadata);

// A file's bytes, in pieces.
class Encoded {
public:
    struct Parts;
    explicit Encoded(std::unique_ptr<Parts> parts);
    ~Encoded();
    std::size_t pieces() const;
    rust::Slice<const std::uint8_t> piece(std::size_t index) const;

private:
    std::unique_ptr<Parts> mParts;
};

std::unique_ptr<Encoded> encode(const Frame& frame, Codec codec);

struct Counts;
struct Target;

std::shared_ptr<Grid> decode(rust::Slice<const std::uint8_t> bytes, std::size_t descriptor);
Counts count(const Grid& grid);
void copy_floats(const Grid& grid, bool flip, Target& target);
void copy_vectors(const Grid& grid, Target& target);

} // namespace hfvdb
