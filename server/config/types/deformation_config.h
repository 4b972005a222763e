// deformation_config: the lattice by which clients hear of the shape of a soft type, from the
// config.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/config/types/soft_types.h"
#include "server/world/entity_type.h"

#include <memory>
#include <string>
#include <vector>

namespace zoned::config {

/// As many control points as the type may have and no more than nodes, about as far apart along all
/// axes. Null: the type sends no deformation.
std::shared_ptr<const wire::DeformationLattice> expand_deformation(const proto::config::Type& type,
                                                                   const SoftShape& shape);

/// Adds the fields of a soft type behind its own, and notes in `out` which they are.
void add_deformation_fields(const proto::config::Type& type,
                            world::EntityType& out,
                            std::vector<wire::DeclaredField>& fields);

/// Of a type whose shape can be built.
void check_deformation(const proto::config::Type& type,
                       const SoftShape& shape,
                       const std::string& path,
                       Diagnostics& diagnostics);

}  // namespace zoned::config
