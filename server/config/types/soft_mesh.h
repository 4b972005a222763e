// soft_mesh: reads the OBJ file of a soft { mesh { ... } } and makes its soft body.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "shared/core/result.h"

namespace zoned::proto::config {
class Config;
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Of a type with a mesh, in coordinates of its file times the scale. Fails where the file cannot
/// be read, is no OBJ, has mistakes (with their lines) or another SHA-256 than the config gives, or
/// is no such surface (see physics::soft::build_mesh_body). File names are taken as they stand.
core::Result<physics::soft::SoftDef> mesh_body_of(const proto::config::Type& type);

/// Notes the SHA-256 of each mesh's file that the config gives none of. From then on other content
/// is refused, here and in replays. Files that cannot be read are left to mesh_body_of.
void note_soft_meshes(proto::config::Config& config);

}  // namespace zoned::config
