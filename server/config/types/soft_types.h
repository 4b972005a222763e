// soft_types: turns the soft { ... } of a type in the config into a definition of the physics.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/physics/soft/soft_def.h"
#include "shared/core/result.h"
#include "shared/math/aabb.h"

#include <string>

namespace zoned::proto::config {
class Config;
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

/// A soft body about the centre of mass of its nodes.
struct SoftShape {
    physics::soft::SoftDef def;
    Aabb box;             ///< of its nodes as defined, grown by the thickness, m
    float radius = 0.0F;  ///< of the sphere about the centre of mass that holds the box, m
};

/// Definition for a type with a soft { ... }. Fails with the reason where it has no form, a pin
/// lies outside the cloth, the file of a mesh cannot be read or is no such mesh, or the physics
/// refuses it (see physics::soft::why_unfit).
core::Result<SoftShape> build_soft(const proto::config::Type& type);

/// The same matter on a lattice whose nodes lie `coarser` >= 1 times as far apart (of a balloon:
/// the next power of two; of a mesh: with as many fewer nodes): the same mass, stiffness and
/// damping per length, area or volume. A pin goes to the nearest node.
proto::config::Type coarsened(const proto::config::Type& type, std::uint32_t coarser);

/// Checks the soft { ... } of a type, and settings that contradict it.
void check_soft(const proto::config::Config& config,
                const proto::config::Type& type,
                const std::string& path,
                Diagnostics& diagnostics);

}  // namespace zoned::config
