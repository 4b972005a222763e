#include "server/ai/crowd/formation.h"

#include <algorithm>

namespace zoned::ai::steering {

namespace {

float cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

float free_share(const Vec2& a, const Vec2& b, const Walls& walls) {
    float share = 1.0F;
    const Vec2 path = b - a;
    walls.for_each_near(std::min(a.x(), b.x()),
                        std::min(a.y(), b.y()),
                        std::max(a.x(), b.x()),
                        std::max(a.y(), b.y()),
                        [&](const Wall& w) {
                            const Vec2 from(w.ax, w.az);
                            const Vec2 along = Vec2(w.bx, w.bz) - from;
                            const float slope = cross(path, along);
                            if (slope == 0.0F) {
                                return;  // beside it
                            }
                            const float t = cross(from - a, along) / slope;
                            const float u = cross(from - a, path) / slope;
                            if (t >= 0.0F && t < share && u >= 0.0F && u <= 1.0F) {
                                share = t;
                            }
                        });
    return share;
}

Vec2 pull_to_slot(const FormationSettings& settings, const Vec2& velocity, const Vec2& offset) {
    const float d = offset.norm();
    const float ratio = d > settings.near_m ? settings.near_m / d : 1.0F;
    return velocity + settings.pull_per_s * ratio * ratio * offset;
}

Vec2 slot_before_walls(const Vec2& centre, const Vec2& offset, float radius, const Walls& walls) {
    const float share = free_share(centre, centre + offset, walls);
    const float length = offset.norm();
    if (share >= 1.0F || length <= 0.0F) {
        return centre + offset;
    }
    return centre + offset * std::max(0.0F, share - 2.0F * radius / length);
}

}  // namespace zoned::ai::steering
