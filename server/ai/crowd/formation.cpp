#include "server/ai/crowd/formation.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::steering {

namespace {

/// A corner is reached within this distance, m.
constexpr float kAtCorner = 0.5F;

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

Vec2 push_off_walls(const FormationSettings& settings,
                    const Vec2& at,
                    float radius,
                    const Walls& walls) {
    Vec2 push = Vec2::Zero();
    const float reach = radius + settings.repel_m;
    walls.for_each_near(
        at.x() - reach, at.y() - reach, at.x() + reach, at.y() + reach, [&](const Wall& w) {
            const Vec2 from(w.ax, w.az);
            const Vec2 along = Vec2(w.bx, w.bz) - from;
            const float length2 = along.squaredNorm();
            const float t =
                length2 > 0.0F ? std::clamp(along.dot(at - from) / length2, 0.0F, 1.0F) : 0.0F;
            const Vec2 away = at - (from + t * along);
            const float d = away.norm();
            if (d > 0.0F && d < reach) {
                push += away *
                        (settings.repel_speed * std::min(1.0F, (reach - d) / settings.repel_m) / d);
            }
        });
    return push;
}

Vec2 slot_before_walls(const Vec2& centre, const Vec2& offset, float radius, const Walls& walls) {
    const float share = free_share(centre, centre + offset, walls);
    const float length = offset.norm();
    if (share >= 1.0F || length <= 0.0F) {
        return centre + offset;
    }
    return centre + offset * std::max(0.0F, share - 2.0F * radius / length);
}

Formation::Formation(std::vector<FormationSlot> slots, const FormationSettings& settings)
    : slots_(std::move(slots)),
      settings_(settings) {
    ZONED_ASSERT(settings.near_m > 0.0F && settings.taken_back_m <= settings.straggler_m,
                 "who is taken back does not straggle");
}

void Formation::place(const Vec2& centre, const Vec2& velocity, const Vec2& heading) {
    centre_ = centre;
    velocity_ = velocity;
    heading_ = heading;
}

void Formation::enlist(const CrowdAgents& agents, std::span<const std::size_t> members) {
    rows_.assign(members.begin(), members.end());
    cost_.clear();
    for (const std::size_t row : rows_) {
        for (const FormationSlot& slot : slots_) {
            const Vec2 at =
                centre_ + slot.ahead * heading_ + slot.right * Vec2(-heading_.y(), heading_.x());
            const double dx = static_cast<double>(agents.x[row]) - static_cast<double>(at.x());
            const double dz = static_cast<double>(agents.z[row]) - static_cast<double>(at.y());
            cost_.push_back(dx * dx + dz * dz);
        }
    }
    const auto slots = assignment_.solve(cost_, rows_.size(), slots_.size());
    slot_.assign(slots.begin(), slots.end());
    straggles_.assign(rows_.size(), 0);
    corner_.assign(rows_.size(), Vec2::Zero());
    asked_.assign(rows_.size(), 0);
}

Vec2 Formation::slot_of(std::size_t i, const Walls& walls, float radius) const {
    if (slot_[i] == kNoSlot) {
        return centre_;
    }
    const FormationSlot& slot = slots_[slot_[i]];
    const Vec2 offset = slot.ahead * heading_ + slot.right * Vec2(-heading_.y(), heading_.x());
    return slot_before_walls(centre_, offset, radius, walls);
}

void Formation::follow_path(std::size_t i,
                            CrowdAgents& agents,
                            const Vec2& slot,
                            const Route& route) {
    const std::size_t row = rows_[i];
    const Vec2 at(agents.x[row], agents.z[row]);
    if (asked_[i] == 0 || (corner_[i] - at).norm() < kAtCorner) {
        corner_[i] = route ? route(row, at, slot) : slot;
        asked_[i] = settings_.ask_every;
    }
    --asked_[i];
    const Vec2 path = corner_[i] - at;
    const float d = path.norm();
    const Vec2 want = d > 0.0F ? Vec2(path * (agents.most_speed[row] / d)) : Vec2(Vec2::Zero());
    agents.want_x[row] = want.x();
    agents.want_z[row] = want.y();
    agents.path_left[row] = d + (slot - corner_[i]).norm();
}

void Formation::aim(CrowdAgents& agents, const Walls& walls, const Route& route) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const std::size_t row = rows_[i];
        const Vec2 at(agents.x[row], agents.z[row]);
        const Vec2 slot = slot_of(i, walls, agents.radius[row]);
        const float d = (slot - at).norm();
        const bool sees = free_share(at, slot, walls) >= 1.0F;
        if (straggles_[i] != 0) {
            straggles_[i] = d <= settings_.taken_back_m && sees ? 0 : 1;
        } else if (d > settings_.straggler_m || !sees) {
            straggles_[i] = 1;
            asked_[i] = 0;
        }
        if (straggles_[i] != 0) {
            follow_path(i, agents, slot, route);
            continue;
        }
        Vec2 want = pull_to_slot(settings_, velocity_, slot - at) +
                    push_off_walls(settings_, at, agents.radius[row], walls);
        const float speed = want.norm();
        want *= speed > agents.most_speed[row] ? agents.most_speed[row] / speed : 1.0F;
        agents.want_x[row] = want.x();
        agents.want_z[row] = want.y();
        agents.path_left[row] = d;
    }
}

}  // namespace zoned::ai::steering
