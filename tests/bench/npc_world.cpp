#include "tests/bench/npc_world.h"

#include "tests/bench/cpu_clock.h"
#include "shared/core/assert.h"
#include "shared/motion/apply_input.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

constexpr float kGridCell = 8.0F;

TypeIndex type_named(const config::Settings& settings, const std::string& name) {
    const auto at = std::find_if(settings.types.begin(),
                                 settings.types.end(),
                                 [&](const world::EntityType& type) { return type.name == name; });
    ZONED_ASSERT(at != settings.types.end(), "the config has the types that are asked for");
    return static_cast<TypeIndex>(at - settings.types.begin());
}

}  // namespace

NpcWorld::NpcWorld(const config::Settings& settings, const Plan& plan)
    : settings_(settings),
      ai_(settings.ai),
      dt_(static_cast<float>(1.0 / settings.tick_rate_hz)),
      places_(settings.ai.points_of_interest, Vec2d::Zero(), dt_) {
    if (plan.simulate_all) {
        ai_.viewer_range_m = std::numeric_limits<float>::infinity();
    }
    ai_.max_decisions_per_tick = 1'000'000;
    if (plan.threads > 1) {
        pool_ = std::make_unique<compute::WorkerPool>(static_cast<unsigned>(plan.threads));
        team_.join_pool(*pool_);
    }
    for (const NpcShare& share : plan.shares) {
        add(share.type,
            static_cast<std::size_t>(share.share * static_cast<double>(plan.people)),
            plan.side_m);
    }
    const auto lines =
        static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(plan.players))));
    for (std::size_t p = 0; p < plan.players; ++p) {
        const EntityId id(static_cast<std::uint32_t>(1'000'000 + p));
        const world::Row row = entities_.add(id, type_named(settings, "player"));
        const float pitch = plan.side_m / static_cast<float>(lines);
        entities_.position[row] =
            Vec3((static_cast<float>(p % lines) + 0.5F) * pitch - 0.5F * plan.side_m,
                 0.9F,
                 (static_cast<float>(p / lines) + 0.5F) * pitch - 0.5F * plan.side_m);
        entities_.set_client(row, ClientId(static_cast<std::uint32_t>(1 + p)));
        entities_.set(row, world::kAtRest, true);
    }
}

void NpcWorld::add(const std::string& type, std::size_t count, float side_m) {
    const TypeIndex index = type_named(settings_, type);
    const world::EntityType& of = settings_.types[index];
    const float height = of.character.radius + of.character.half_segment;
    for (std::size_t i = 0; i < count; ++i) {
        const EntityId id(static_cast<std::uint32_t>(entities_.size() + 1));
        const world::Row row = entities_.add(id, index);
        entities_.position[row] = Vec3(rng_.range(-0.5F * side_m, 0.5F * side_m),
                                       height,
                                       rng_.range(-0.5F * side_m, 0.5F * side_m));
        entities_.set(row, world::kGrounded, true);
        ai::Agent agent;
        agent.entity = id;
        agent.brain = static_cast<std::uint16_t>(of.brain - 1);
        ai::begin(agent, ai_.compiled[agent.brain], 0);
        agent.home = agent.target = entities_.position[row];
        agent.rng = core::Rng(settings_.seed, id.value);
        agents_.add(agent);
    }
}

NpcWorld::Cost NpcWorld::tick() {
    ++now_;
    Cost cost;
    const std::int64_t begin = thread_cpu_ns();
    const std::int64_t wall = wall_ns();
    report_ = step_.run({agents_,
                         ai_,
                         entities_,
                         settings_.types,
                         places_,
                         plain_,
                         team_,
                         Vec2::Constant(std::numeric_limits<float>::infinity()),
                         now_,
                         dt_,
                         [this]() -> const spatial::PointGrid& {
                             grid_.build(entities_.position, kGridCell);
                             return grid_;
                         }});
    const std::int64_t between = thread_cpu_ns();
    cost.agents_wall_ns = wall_ns() - wall;
    walk();
    cost.agents_ns = between - begin;
    cost.walk_ns = thread_cpu_ns() - between;
    return cost;
}

/// Moves characters as a zone does.
void NpcWorld::walk() {
    for (world::Row row = 0; row < entities_.size(); ++row) {
        const motion::InputCommand& c = entities_.command[row];
        if (entities_.has(row, world::kAtRest) && c.move_x == 0 && c.move_z == 0 &&
            c.yaw == entities_.yaw[row]) {
            continue;
        }
        const motion::CharacterState after =
            motion::apply_input({entities_.position[row],
                                 entities_.velocity[row],
                                 entities_.yaw[row],
                                 entities_.has(row, world::kGrounded)},
                                c,
                                settings_.types[entities_.type[row]].character,
                                plain_,
                                dt_);
        entities_.position[row] = after.position;
        entities_.velocity[row] = after.velocity;
        entities_.yaw[row] = after.yaw;
        entities_.set(row, world::kGrounded, after.grounded);
        entities_.set(row, world::kAtRest, after.velocity == Vec3::Zero());
    }
}

}  // namespace zoned::bench
