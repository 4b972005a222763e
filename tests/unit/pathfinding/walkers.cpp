#include "tests/unit/pathfinding/walkers.h"

#include <cmath>
#include <numbers>

namespace zoned::ai::pathfinding {

motion::StaticBox static_box(const Vec3& centre,
                             const Vec3& half,
                             float degrees,
                             const Vec3& axis) {
    motion::StaticBox box;
    box.centre = centre;
    box.half_extents = half;
    box.orientation = Quat(Eigen::AngleAxisf(degrees * std::numbers::pi_v<float> / 180.0F, axis));
    return box;
}

motion::StaticGeometry random_world(core::Rng& rng, float side_m, int pieces) {
    std::vector<motion::StaticBox> boxes;
    const auto place = [&] {
        return (rng.unit() - 0.5F) * side_m;
    };
    for (int i = 0; i < pieces; ++i) {
        const float x = place();
        const float z = place();
        const float turn = rng.unit() * 180.0F;
        switch (rng.below(6)) {
            case 0:  // wall
                boxes.push_back(static_box(Vec3(x, 1.5F, z), Vec3(4.0F, 1.5F, 0.15F), turn));
                break;
            case 1:  // crate
                boxes.push_back(static_box(Vec3(x, 0.5F, z), Vec3(0.5F, 0.5F, 0.5F), turn));
                break;
            case 2: {  // ramp, some too steep
                const float tilt = 10.0F + rng.unit() * 60.0F;
                motion::StaticBox ramp = static_box(Vec3(x, 0.3F, z), Vec3(3.0F, 0.2F, 1.5F), turn);
                ramp.orientation = ramp.orientation *
                                   Quat(Eigen::AngleAxisf(tilt * std::numbers::pi_v<float> / 180.0F,
                                                          Vec3::UnitZ()));
                boxes.push_back(ramp);
                break;
            }
            case 3: {  // curb, some too high
                const float half = 0.05F + rng.unit() * 0.3F;
                boxes.push_back(static_box(Vec3(x, half, z), Vec3(2.5F, half, 2.0F), turn));
                break;
            }
            case 4:  // stairs of 0.25 m
                for (int k = 0; k < 4; ++k) {
                    const float half = 0.125F * static_cast<float>(k + 1);
                    boxes.push_back(static_box(Vec3(x + 0.5F * static_cast<float>(k), half, z),
                                               Vec3(0.25F, half, 1.5F)));
                }
                break;
            default:  // roof on posts
                boxes.push_back(static_box(Vec3(x, 2.6F, z), Vec3(3.0F, 0.1F, 3.0F), turn));
                boxes.push_back(static_box(Vec3(x, 1.25F, z), Vec3(0.2F, 1.25F, 0.2F), turn));
                break;
        }
    }
    return motion::StaticGeometry(boxes, 0.0F);
}

int ticks_to_walk(const motion::StaticGeometry& world,
                  const motion::CharacterLimits& limits,
                  const GroundMap& map,
                  Cell start,
                  std::span<const Spot> corners,
                  float near_m,
                  int most) {
    const Spot begin = map.grid.centre(start);
    motion::CharacterState state;
    state.position = Vec3(begin.x,
                          map.floor_m[map.cells.place(start)] + limits.radius + limits.half_segment,
                          begin.z);
    state.grounded = true;
    std::size_t next = 0;
    for (int tick = 0; tick < most; ++tick) {
        Vec2 to(corners[next].x - state.position.x(), corners[next].z - state.position.z());
        while (to.norm() <= near_m) {
            if (++next == corners.size()) {
                return tick;
            }
            to = Vec2(corners[next].x - state.position.x(), corners[next].z - state.position.z());
        }
        to.normalize();
        motion::InputCommand command;
        command.move_x = static_cast<std::int8_t>(std::lround(127.0F * to.x()));
        command.move_z = static_cast<std::int8_t>(std::lround(127.0F * to.y()));
        state = motion::apply_input(state, command, limits, world, 1.0F / 30.0F);
    }
    return most;
}

}  // namespace zoned::ai::pathfinding
