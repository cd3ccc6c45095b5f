// What users would take meshes to volumes and back with, by OpenVDB alone, colours with them.
#include "rivals.h"

#include <openvdb/io/File.h>
#include <openvdb/math/Proximity.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_for.h>

#include <string>
#include <vector>

namespace rivals {

using openvdb::Vec3d;
using openvdb::Vec3f;

struct ColouredGrid::Parts {
    openvdb::FloatGrid::Ptr surface;
    openvdb::Vec3SGrid::Ptr colour;
};

ColouredGrid::ColouredGrid(std::unique_ptr<Parts> parts)
    : mParts(std::move(parts))
{
}
ColouredGrid::~ColouredGrid() = default;

std::uint64_t ColouredGrid::active_voxels() const
{
    return mParts->surface->activeVoxelCount();
}

float ColouredGrid::value(std::int32_t x, std::int32_t y, std::int32_t z) const
{
    return mParts->surface->tree().getValue(openvdb::Coord(x, y, z));
}

std::unique_ptr<ColouredGrid> mesh_to_volume(rust::Slice<const float> positions,
    rust::Slice<const std::uint32_t> triangles, rust::Slice<const float> colours, double voxel_size)
{
    constexpr float HALF_WIDTH = 3;
    std::vector<Vec3f> points(positions.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = Vec3f(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]) / float(voxel_size);
    }
    std::vector<openvdb::Vec3I> faces(triangles.size() / 3);
    for (std::size_t i = 0; i < faces.size(); ++i) {
        faces[i] = openvdb::Vec3I(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
    }
    const openvdb::tools::QuadAndTriangleDataAdapter<Vec3f, openvdb::Vec3I> mesh(points, faces);
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel_size);
    openvdb::Int32Grid closest(0);
    auto parts = std::make_unique<ColouredGrid::Parts>();
    parts->surface = openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, *transform, HALF_WIDTH, HALF_WIDTH, 0, &closest);
    parts->colour = openvdb::Vec3SGrid::create();
    parts->colour->setTransform(transform);
    parts->colour->setTree(std::make_shared<openvdb::Vec3STree>(parts->surface->tree(), Vec3f(0), openvdb::TopologyCopy()));
    // The colour of the closest point, by the triangle that the grid of polygons has for the voxel.
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(parts->colour->tree());
    leaves.foreach([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        const auto polygons = closest.getConstAccessor();
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel) {
            const openvdb::Coord at = voxel.getCoord();
            const openvdb::Vec3I& face = faces[polygons.getValue(at)];
            Vec3d weights;
            openvdb::math::closestPointOnTriangleToPoint(
                Vec3d(points[face[0]]), Vec3d(points[face[1]]), Vec3d(points[face[2]]), at.asVec3d(), weights);
            Vec3f colour(0);
            for (int corner = 0; corner < 3; ++corner) {
                colour += Vec3f(&colours[3 * face[corner]]) * float(weights[corner]);
            }
            voxel.setValue(colour);
        }
    });
    return std::make_unique<ColouredGrid>(std::move(parts));
}

std::unique_ptr<ColouredGrid> read_coloured(rust::Str path)
{
    openvdb::initialize();
    openvdb::io::File file{std::string(path)};
    file.open(/*delayLoad=*/false);
    auto parts = std::make_unique<ColouredGrid::Parts>();
    parts->surface = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
    parts->colour = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("Cd"));
    return std::make_unique<ColouredGrid>(std::move(parts));
}

std::size_t volume_to_mesh(const ColouredGrid& grid, double adaptivity)
{
    const ColouredGrid::Parts& parts = grid.parts();
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*parts.surface, points, triangles, quads, 0.0, adaptivity);
    std::vector<Vec3f> colours(points.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size()), [&](const auto& range) {
        const auto accessor = parts.colour->getConstAccessor();
        const openvdb::tools::GridSampler<openvdb::Vec3SGrid::ConstAccessor, openvdb::tools::BoxSampler> sampler(
            accessor, parts.colour->transform());
        for (std::size_t i = range.begin(); i < range.end(); ++i) colours[i] = sampler.wsSample(points[i]);
    });
    return triangles.size() + 2 * quads.size();
}

} // namespace rivals
