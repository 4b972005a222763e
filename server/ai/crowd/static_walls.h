// Walls of a zone: the sides of its static boxes.
#pragma once

#include "server/ai/crowd/walls.h"
#include "shared/motion/static_geometry.h"

namespace zoned::ai::steering {

/// The sides of upright boxes that stand on the ground (or what lies on it) and are too high to be
/// stepped onto. What else there is - slopes, ramps, other floors - movement keeps everybody out
/// of. `cell_m` as Walls::make.
Walls walls_of(const motion::StaticGeometry& statics, float cell_m);

/// The walls of the statics that were asked for last: made when somebody asks.
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
