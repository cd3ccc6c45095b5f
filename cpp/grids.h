// What stands behind the types of border.h. Only the C++ side includes this.
#pragma once

#include "border.h"
#include "hfvdb/src/vdb/bridge.rs.h"

#include <openvdb/openvdb.h>

#include <string>
#include <utility>
#include <vector>

namespace hfvdb {

struct Grid::Parts {
    openvdb::GridBase::ConstPtr grid;
};

// A grid as Rust holds it.
inline std::shared_ptr<Grid> share(openvdb::GridBase::ConstPtr grid)
{
    return std::make_shared<Grid>(std::make_unique<Grid::Parts>(Grid::Parts{std::move(grid)}));
}

// Registers OpenVDB's types; cheap after the first call.
void start_library();

// Copies items into a metadata map.
void insert_metadata(openvdb::MetaMap& map, rust::Slice<const Meta> items);

} // namespace hfvdb
