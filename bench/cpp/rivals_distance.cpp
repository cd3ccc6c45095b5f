// What users would make signed distances with, by OpenVDB alone.
#include "rivals.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/LevelSetMorph.h>
#include <openvdb/tools/LevelSetPlatonic.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

namespace rivals {

namespace {

using FloatGrid = openvdb::FloatGrid;
using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;

struct Sphere {
    openvdb::Vec3f centre;
    float radius;

    float value(const openvdb::Vec3f& at) const { return radius * radius - (at - centre).lengthSqr(); }
};

std::vector<Sphere> spheres_of(rust::Slice<const double> numbers)
{
    std::vector<Sphere> spheres;
    for (std::size_t i = 0; i < numbers.size(); i += 4) {
        spheres.push_back({openvdb::Vec3f(numbers[i], numbers[i + 1], numbers[i + 2]), float(numbers[i + 3])});
    }
    return spheres;
}

float r0_union(float a, float b)
{
    return a + b + std::sqrt(a * a + b * b);
}

// F of the whole: a balanced tree of unions, then the differences one by one. `row` is scratch.
float whole(const openvdb::Vec3f& at, const std::vector<Sphere>& balls, const std::vector<Sphere>& holes,
    std::vector<float>& row)
{
    std::size_t count = balls.size();
    for (std::size_t i = 0; i < count; ++i) row[i] = balls[i].value(at);
    for (; count > 1; count = (count + 1) / 2) {
        for (std::size_t i = 0; i + 1 < count; i += 2) row[i / 2] = r0_union(row[i], row[i + 1]);
        if (count % 2 == 1) row[count / 2] = row[count - 1];
    }
    float value = row[0];
    for (const Sphere& hole : holes) value = -r0_union(-value, hole.value(at));
    return value;
}

std::unique_ptr<RivalGrid> wrap(FloatGrid::Ptr grid);

} // namespace

struct RivalGrid::Parts {
    FloatGrid::Ptr grid;
};

RivalGrid::RivalGrid(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
RivalGrid::~RivalGrid() = default;

namespace {

std::unique_ptr<RivalGrid> wrap(FloatGrid::Ptr grid)
{
    auto parts = std::make_unique<RivalGrid::Parts>();
    parts->grid = std::move(grid);
    return std::make_unique<RivalGrid>(std::move(parts));
}

} // namespace

std::uint64_t RivalGrid::active_voxels() const
{
    return mParts->grid->activeVoxelCount();
}

std::size_t RivalGrid::leaves() const
{
    return mParts->grid->tree().leafCount();
}

void RivalGrid::blocks(
    rust::Slice<std::int32_t> origins, rust::Slice<std::uint64_t> masks, rust::Slice<float> values) const
{
    std::size_t block = 0;
    for (auto leaf = mParts->grid->tree().cbeginLeaf(); leaf; ++leaf, ++block) {
        for (int axis = 0; axis < 3; ++axis) origins[3 * block + axis] = leaf->origin()[axis];
        for (openvdb::Index word = 0; word < 8; ++word) {
            masks[8 * block + word] = leaf->valueMask().getWord<std::uint64_t>(word);
        }
        std::memcpy(values.data() + 512 * block, leaf->buffer().data(), 512 * sizeof(float));
    }
}

std::unique_ptr<RivalGrid> dense_grid(
    rust::Slice<const std::int32_t> origins, rust::Slice<const float> values, double voxel_size)
{
    FloatGrid::Ptr grid = FloatGrid::create(float(3 * voxel_size));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_size));
    for (std::size_t block = 0; block < origins.size() / 3; ++block) {
        const openvdb::Coord origin(origins[3 * block], origins[3 * block + 1], origins[3 * block + 2]);
        auto leaf = std::make_unique<Leaf>(origin, 0.0f, true);
        std::memcpy(leaf->buffer().data(), values.data() + 512 * block, 512 * sizeof(float));
        grid->tree().addLeaf(leaf.release());
    }
    return wrap(grid);
}

// A slab of the box for each thread, whose trees are merged at the end.
std::unique_ptr<RivalGrid> accessor_loop(rust::Slice<const double> ball_numbers,
    rust::Slice<const double> hole_numbers, std::int32_t resolution, std::size_t threads)
{
    const auto balls = spheres_of(ball_numbers), holes = spheres_of(hole_numbers);
    const float voxel_size = 2.0f / float(resolution), background = 3.0f * voxel_size;
    std::vector<FloatGrid::Ptr> grids(threads);
    std::vector<std::thread> workers;
    for (std::size_t thread = 0; thread < threads; ++thread) {
        workers.emplace_back([&, thread] {
            grids[thread] = FloatGrid::create(background);
            FloatGrid::Accessor accessor = grids[thread]->getAccessor();
            std::vector<float> row(balls.size());
            const int first = int(resolution * thread / threads), end = int(resolution * (thread + 1) / threads);
            const int half = resolution / 2;
            for (int x = first - half; x < end - half; ++x) {
                for (int y = -half; y < half; ++y) {
                    for (int z = -half; z < half; ++z) {
                        const float value = whole(openvdb::Vec3f(x, y, z) * voxel_size, balls, holes, row);
                        if (std::abs(value) < background) accessor.setValue(openvdb::Coord(x, y, z), -value);
                    }
                }
            }
        });
    }
    for (std::thread& worker : workers) worker.join();
    for (std::size_t thread = 1; thread < threads; ++thread) grids[0]->merge(*grids[thread]);
    return wrap(grids[0]);
}

std::unique_ptr<RivalGrid> spheres_by_csg(
    rust::Slice<const double> ball_numbers, rust::Slice<const double> hole_numbers, double voxel_size)
{
    const auto sphere = [&](const Sphere& one) {
        return openvdb::tools::createLevelSetSphere<FloatGrid>(one.radius, one.centre, float(voxel_size), 3.0f);
    };
    const auto balls = spheres_of(ball_numbers), holes = spheres_of(hole_numbers);
    FloatGrid::Ptr all = sphere(balls[0]);
    for (std::size_t i = 1; i < balls.size(); ++i) openvdb::tools::csgUnion(*all, *sphere(balls[i]));
    for (const Sphere& hole : holes) openvdb::tools::csgDifference(*all, *sphere(hole));
    return wrap(all);
}

std::unique_ptr<RivalGrid> rebuild(const RivalGrid& dense)
{
    return wrap(openvdb::tools::levelSetRebuild(*dense.parts().grid, 0.0f, 3.0f));
}

std::unique_ptr<RivalGrid> sweep(const RivalGrid& dense)
{
    return wrap(openvdb::tools::sdfToSdf(*dense.parts().grid));
}

std::unique_ptr<RivalGrid> sphere_level_set(double radius, double voxel_size)
{
    return wrap(openvdb::tools::createLevelSetSphere<FloatGrid>(
        float(radius), openvdb::Vec3f(0.0f), float(voxel_size), 3.0f));
}

std::unique_ptr<RivalGrid> cube_level_set(double edge, double voxel_size)
{
    return wrap(
        openvdb::tools::createLevelSetCube<FloatGrid>(float(edge), openvdb::Vec3f(0.0f), float(voxel_size), 3.0f));
}

std::size_t morph(RivalGrid& source, const RivalGrid& target, double from, double to)
{
    openvdb::tools::LevelSetMorphing<FloatGrid> morphing(*source.parts().grid, *target.parts().grid);
    return morphing.advect(float(from), float(to));
}

} // namespace rivals
