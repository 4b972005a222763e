// Static walls: KnownWalls and walls_of() turn the sides of a zone's static boxes into walls.
#pragma once

#include "server/ai/crowd/walls.h"
#include "shared/motion/static_geometry.h"

namespace zoned::ai::steering {

/// The sides of upright boxes that stand on the ground (or on something on it) and are too high to
/// step onto. Movement itself keeps agents out of all other shapes: slopes, ramps, other floors.
/// `cell_m` as in Walls::make.
Walls walls_of(const motion::StaticGeometry& statics, float cell_m);

/// The walls of the last requested statics, built on request.
class KnownWalls {
  public:
    const Walls& of(const motion::StaticGeometry& statics) {
        if (statics_ != &statics) {
            walls_ = walls_of(statics, kCell_m);
            statics_ = &statics;
        }
        return walls_;
    }

  private:
    static constexpr float kCell_m = 3.0F;

    Walls walls_;
    const motion::StaticGeometry* statics_ = nullptr;
};

}  // namespace zoned::ai::steering
