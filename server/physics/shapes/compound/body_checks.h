// Body checks: decides whether a body or a part of a compound is fit for a scene, with the reason.
#pragma once

#include "server/physics/shapes/compound/compound.h"

#include <string>

namespace zoned::physics {

/// Empty when the definition is fit for the scene, otherwise the reason.
std::string why_unfit(const BodyDef& def);

/// why_unfit for a part of a compound.
std::string why_unfit_part(const CompoundPart& part);

}  // namespace zoned::physics
