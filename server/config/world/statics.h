// statics: turns boxes, hills and walls of the config into static boxes.
#pragma once

#include "server/config/text/diagnostics.h"
#include "shared/motion/static_geometry.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Box;
class Config;
class World;
}  // namespace zoned::proto::config

namespace zoned::config {

/// All static boxes in world coordinates, in the order of the config: boxes, hills, walls.
/// Mistakes (a ramp that does not fit on its tread, a wall without length, something outside the
/// world) go to `diagnostics`. Sizes must have passed check_ranges.
std::vector<motion::StaticBox> expand_statics(const proto::config::Config& config,
                                              Diagnostics& diagnostics);

/// A box as the config has it, world coordinates.
motion::StaticBox static_box(const proto::config::Box& box);

/// Reports, under `path`, a box that lies wholly outside the world: it is surely misplaced.
void check_inside(const proto::config::World& world,
                  const motion::StaticBox& box,
                  const std::string& path,
                  Diagnostics& diagnostics);

}  // namespace zoned::config
