#include "server/ai/perception/perception.h"

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/ai_settings.h"
#include "server/ai/agent/whereabouts.h"
#include "server/physics/query/query.h"
#include "shared/math/heading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace zoned::ai {

namespace {

bool is_player(const world::Entities& entities, world::Row row) {
    return static_cast<bool>(entities.client[row]) && !entities.has(row, world::kHidden);
}

bool is_one_of(const std::vector<TypeIndex>& types, TypeIndex type) {
    return std::find(types.begin(), types.end(), type) != types.end();
}

struct Noticed {
    float d2 = std::numeric_limits<float>::infinity();
    EntityId id;
    world::Row row = world::kNoRow;

    bool operator<(const Noticed& other) const {
        return std::tie(d2, id) < std::tie(other.d2, other.id);
    }
};

/// The nearest few, ascending, in whatever order they are added.
struct NearestFew {
    std::array<Noticed, kRaysPerLook> few;
    std::size_t size = 0;

    void add(const Noticed& one) {
        if (size == few.size() && !(one < few[size - 1])) {
            return;
        }
        size += size < few.size() ? 1 : 0;
        std::size_t at = size - 1;
        for (; at > 0 && one < few[at - 1]; --at) {
            few[at] = few[at - 1];
        }
        few[at] = one;
    }
};

/// Calls visit(row, squared distance) for each player within `radius` of `self`.
template <class Visit>
void for_each_player(const AiContext& ai,
                     const Players* known,
                     world::Row self,
                     float radius,
                     Visit&& visit) {
    const Vec3& eye = ai.entities.position[self];
    if (known != nullptr) {
        const Players& players = *known;
        players.grid.for_each_within(eye.x(), eye.z(), radius, [&](std::uint32_t k, float d2) {
            if (players.rows[k] != self) {
                visit(players.rows[k], d2);
            }
        });
        return;
    }
    ai.near->for_each_within(eye.x(), eye.z(), radius, [&](world::Row row, float d2) {
        if (row != self && is_player(ai.entities, row)) {
            visit(row, d2);
        }
    });
}

/// The nearest entity within perception; of equals, the one with the smaller id. near(radius,
/// visit) calls visit(row, squared distance) for the entities within a radius.
template <class Near>
Percept nearest_player(const world::Entities& entities,
                       float perception_m,
                       float far_m,
                       const Near& near) {
    Percept percept;
    float nearest2 = std::numeric_limits<float>::infinity();
    int players = 0;
    near(perception_m, [&](world::Row row, float d2) {
        ++players;
        const EntityId id = entities.id[row];
        if (d2 < nearest2 || (d2 == nearest2 && id < percept.prey)) {
            nearest2 = d2;
            percept.prey = id;
        }
    });
    percept.distance = std::sqrt(nearest2);
    percept.confidence = percept.prey ? 1.0F : 0.0F;
    percept.foes = static_cast<float>(players);
    percept.player_far = percept.distance > far_m;
    if (!percept.prey && far_m > perception_m) {
        near(far_m, [&](world::Row /*row*/, float /*d2*/) { percept.player_far = false; });
    }
    return percept;
}

/// One look around by one agent.
class Looking {
  public:
    Looking(const AiContext& ai,
            world::Row self,
            const Agent& agent,
            const CompiledBrain& brain,
            const Players* players,
            const Timetables* timetables)
        : ai_(ai),
          players_(players),
          timetables_(timetables),
          e_(ai.entities),
          self_(self),
          agent_(agent),
          how_(brain.perception),
          sight_m_(brain.perception_m),
          eye_(stand_of(self).at),
          leader_(ai.entities.id[self]) {
        const bool on_segment = timetable_of(self) != nullptr;
        const std::uint16_t yaw = on_segment ? agent.aim.yaw : e_.yaw[self];
        ahead_ = heading_of(yaw);
    }

    Percept run() {
        Percept percept;
        const float range = std::max(sight_m_, how_.hearing_m);
        const float beside = timetables_ != nullptr ? kDriftM : 0.0F;
        ai_.near->for_each_within(
            eye_.x(), eye_.z(), range + beside, [&](world::Row row, float d2) {
                const Stand stand = stand_of(row);
                const Vec3 way = stand.at - eye_;
                const float own2 = way.x() * way.x() + way.z() * way.z();
                consider(row, stand, stand.by_segment || beside > 0.0F ? own2 : d2, percept);
            });
        const Noticed target = choose();
        if (target.row != world::kNoRow) {
            percept.prey = target.id;
            percept.place = stand_of(target.row).at;
            percept.distance = std::sqrt(target.d2);
            percept.confidence = 1.0F;
        } else {
            remember(percept);
        }
        percept.ward = kept_ward_ ? agent_.ward : ward_.id;
        if (!percept.ward && leader_ != e_.id[self_]) {
            percept.ward = leader_;
        }
        for_each_player(
            ai_, players_, self_, ai_.settings.far_m, [&](world::Row /*row*/, float /*d2*/) {
                percept.player_far = false;
            });
        return percept;
    }

  private:
    /// The position and velocity at which an entity is perceived.
    struct Stand {
        Vec3 at;
        Vec2 velocity;
        bool by_segment = false;
    };

    /// Null: the entity is on no known timetable.
    [[nodiscard]] const PathSegment* timetable_of(world::Row row) const {
        const Timetables* const all = timetables_;
        if (all == nullptr || row >= all->slots.size() || all->slots[row] >= all->agents.slots()) {
            return nullptr;
        }
        const Agent& agent = all->agents.at(all->slots[row]);
        const Vec3& body = e_.position[row];
        const bool keeps = agent.entity == e_.id[row] &&
                           keeps_to_segment(agent, {body.x(), body.z()}, ai_.now, ai_.dt);
        return keeps ? &agent.segment : nullptr;
    }

    [[nodiscard]] Stand stand_of(world::Row row) const {
        const Vec3& body = e_.position[row];
        const Vec3& velocity = e_.velocity[row];
        const PathSegment* const segment = timetable_of(row);
        if (segment == nullptr) {
            return {body, {velocity.x(), velocity.z()}};
        }
        const Vec2 at = position_at(*segment, ai_.now - 1, ai_.dt);
        return {{at.x(), body.y(), at.y()}, velocity_at(*segment, ai_.now - 1, ai_.dt), true};
    }

    void consider(world::Row row, const Stand& stand, float d2, Percept& percept) {
        if (row == self_ || e_.has(row, world::kHidden)) {
            return;
        }
        const bool player = is_player(e_, row);
        const TypeIndex type = e_.type[row];
        const bool within = d2 <= sight_m_ * sight_m_;
        if (within && is_one_of(how_.allies, type)) {
            percept.allies += 1.0F;
        }
        const Noticed one{d2, e_.id[row], row};
        if (within && ((player && how_.ward_players) || is_one_of(how_.wards, type))) {
            kept_ward_ = kept_ward_ || one.id == agent_.ward;
            ward_ = std::min(ward_, one);
        }
        if (within && how_.succession && type == e_.type[self_]) {
            leader_ = std::min(leader_, one.id);
        }
        if (!(player && how_.players) && !is_one_of(how_.targets, type)) {
            return;
        }
        const bool heard = hears(row, stand, d2);
        if (!heard && !(within && in_cone(stand, d2))) {
            return;
        }
        percept.foes += 1.0F;
        if (heard || !how_.line_of_sight) {
            nearest_ = std::min(nearest_, one);
            if (one.id == agent_.prey) {
                kept_ = one;
            }
        } else if (one.id == agent_.prey) {
            before_ = one;
        } else {
            others_.add(one);
        }
    }

    /// Chooses among the targets noticed without a ray and the targets that a ray reaches.
    Noticed choose() {
        std::uint32_t rays = kRaysPerLook;
        if (before_.row != world::kNoRow && sees(before_.row)) {
            kept_ = before_;
            nearest_ = std::min(nearest_, before_);
        }
        rays -= before_.row != world::kNoRow ? 1 : 0;
        if (how_.keeps_target && kept_.row != world::kNoRow) {
            return kept_;
        }
        for (std::size_t k = 0; k < others_.size && rays > 0; ++k, --rays) {
            if (!(others_.few[k] < nearest_)) {
                break;
            }
            if (sees(others_.few[k].row)) {
                return others_.few[k];
            }
        }
        return nearest_;
    }

    [[nodiscard]] bool in_cone(const Stand& stand, float d2) const {
        if (how_.cos_half_angle <= -1.0F || d2 <= how_.around_m * how_.around_m) {
            return true;
        }
        const Vec3 way = stand.at - eye_;
        return ahead_.dot(Vec2(way.x(), way.z())) >= how_.cos_half_angle * std::sqrt(d2);
    }

    [[nodiscard]] bool hears(world::Row row, const Stand& stand, float d2) const {
        if (!(d2 <= how_.hearing_m * how_.hearing_m) || !(how_.hearing_m > 0.0F)) {
            return false;
        }
        const world::EntityType& type = ai_.types[e_.type[row]];
        const float speed = stand.velocity.norm() / std::max(0.01F, type.character.speed);
        const float carries =
            type.aura_m[e_.stance[row]] * std::min(speed, type.character.sprint_factor);
        return d2 <= carries * carries && carries > 0.0F;
    }

    [[nodiscard]] bool sees(world::Row row) const {
        if (ai_.query == nullptr) {
            return true;
        }
        const Vec3 up(0.0F, how_.eyes_m, 0.0F);
        physics::Ray ray;
        ray.origin = eye_ + up;
        ray.direction = stand_of(row).at - eye_;
        ray.max_distance = ray.direction.norm();
        if (!(ray.max_distance > 1e-3F)) {
            return true;
        }
        physics::QueryFilter filter;
        filter.kinematics = false;
        filter.dynamics = false;
        return !ai_.query->ray_any(ray, filter);
    }

    void remember(Percept& percept) const {
        percept.distance = std::numeric_limits<float>::infinity();
        if (!agent_.prey || !(how_.memory_s > 0.0F) || agent_.known_at == 0) {
            return;
        }
        const float age = static_cast<float>(ai_.now - agent_.known_at) * ai_.dt;
        percept.confidence = std::max(0.0F, 1.0F - age / how_.memory_s);
        if (percept.confidence > 0.0F) {
            percept.prey = agent_.prey;
            percept.noticed = false;
            percept.place = agent_.known;
            percept.distance =
                Vec2(agent_.known.x() - eye_.x(), agent_.known.z() - eye_.z()).norm();
        }
    }

    const AiContext& ai_;
    const Players* players_;
    const Timetables* timetables_;
    const world::Entities& e_;
    world::Row self_;
    const Agent& agent_;
    const Perception& how_;
    float sight_m_;
    Vec3 eye_;
    Vec2 ahead_ = Vec2::Zero();
    Noticed nearest_;  ///< noticed for certain
    Noticed kept_;     ///< the previous target, noticed for certain
    Noticed before_;   ///< the previous target, if a ray must decide
    NearestFew others_;
    Noticed ward_;
    bool kept_ward_ = false;
    EntityId leader_;  ///< of its own type, itself included, where the brain has succession
};

}  // namespace

Percept look(const world::Entities& entities,
             const spatial::PointGrid& grid,
             world::Row self,
             float perception_m,
             float far_m) {
    const auto near = [&](float radius, auto&& visit) {
        const Vec3& eye = entities.position[self];
        grid.for_each_within(eye.x(), eye.z(), radius, [&](world::Row row, float d2) {
            if (row != self && is_player(entities, row)) {
                visit(row, d2);
            }
        });
    };
    return nearest_player(entities, perception_m, far_m, near);
}

void Players::gather(const world::Entities& entities) {
    // Wide enough that a usual radius covers few cells.
    constexpr float kCell_m = 64.0F;
    rows.clear();
    at.clear();
    world::for_each_row(entities.avatars(), [&](world::Row row) {
        if (is_player(entities, row)) {
            rows.push_back(row);
            at.push_back(entities.position[row]);
        }
    });
    grid.build(at, kCell_m);
}

Percept perceive(const AiContext& ai,
                 world::Row self,
                 const Agent& agent,
                 const CompiledBrain& brain,
                 const Players* players,
                 const Timetables* timetables) {
    if (brain.perception.given) {
        return Looking(ai, self, agent, brain, players, timetables).run();
    }
    const auto near = [&](float radius, auto&& visit) {
        for_each_player(ai, players, self, radius, visit);
    };
    return nearest_player(ai.entities, brain.perception_m, ai.settings.far_m, near);
}

}  // namespace zoned::ai
