#include "server/zone/simulation/zone_agents.h"

#include "server/ai/offscreen/suspend_resume.h"
#include "server/zone/simulation/spawning.h"

#include <limits>

namespace zoned::zone {

namespace {

/// Beyond it an entity belongs to another zone.
Vec2 half_size(const ZoneState& state) {
    if (state.settings.regions.size() < 2) {
        return Vec2::Constant(std::numeric_limits<float>::infinity());
    }
    const Region& region = state.settings.region();
    const auto slack = static_cast<double>(state.settings.handoff_hysteresis_m);
    return {static_cast<float>(0.5 * (region.max_x - region.min_x) + slack),
            static_cast<float>(0.5 * (region.max_z - region.min_z) + slack)};
}

/// So far within the edge goals are: a walker stops a little beyond them.
constexpr double kInside = 1.0;

ai::WorldBox world_box(const ZoneState& state) {
    const Vec3d origin = state.settings.region().origin();
    ai::WorldBox box;
    if (state.settings.regions.empty()) {
        return box;
    }
    Vec2d lower = Vec2d::Constant(std::numeric_limits<double>::infinity());
    Vec2d upper = -lower;
    for (const Region& region : state.settings.regions) {
        lower = lower.cwiseMin(Vec2d(region.min_x, region.min_z));
        upper = upper.cwiseMax(Vec2d(region.max_x, region.max_z));
    }
    const Vec2d here(origin.x(), origin.z());
    box.lower = (lower - here + Vec2d::Constant(kInside)).cast<float>();
    box.upper = (upper - here - Vec2d::Constant(kInside)).cast<float>();
    return box;
}

}  // namespace

ai::AiContext context_of(ZoneState& state, compute::Team& team, const physics::Query* query) {
    return {state.agents,
            state.settings.ai,
            state.entities,
            *state.settings.types,
            state.points_of_interest,
            state.fixed_ground ? *state.fixed_ground : *state.settings.statics,
            team,
            half_size(state),
            state.now,
            state.settings.dt,
            [&state]() -> const spatial::PointGrid& { return current_grid(state); },
            query,
            state.paths.empty() ? nullptr : &state.paths,
            state.settings.handoff_hysteresis_m,
            world_box(state),
            state.fixed_ground ? state.settings.statics.get() : nullptr};
}

std::uint32_t update_agents(ZoneState& state) {
    if (state.agents.size() == 0) {
        state.paths.serve();
        return 0;
    }
    compute::Team alone;
    const physics::Query statics = state.scene.query();
    compute::Team& team = state.team != nullptr ? *state.team : alone;
    state.report.ai = state.ai_update.run(context_of(state, team, &statics));
    for (const EntityId entity : state.ai_update.suspended()) {
        remove_body(state, state.entities.find(entity));
    }
    for (const EntityId entity : state.ai_update.resumed()) {
        add_body(state, state.entities.find(entity), false);
    }
    state.grid_valid = state.grid_valid && !state.report.ai.moved;
    return state.report.ai.decisions;
}

void follow_players(ZoneState& state) {
    ai::AiSettings& settings = state.settings.ai;
    ai::DifficultyState& difficulty = state.ai_update.difficulty();
    const std::uint16_t level = ai::level_due(difficulty, settings.difficulty, state.now);
    if (level == difficulty.level) {
        return;
    }
    for (std::size_t n = 0; n < state.agents.size(); ++n) {
        const ai::Agent& agent = state.agents.at(state.agents.nth(n));
        const world::Row row = state.entities.find(agent.entity);
        if (row != world::kNoRow && settings.difficulty.varies[agent.brain]) {
            wake_agent(state, row);
        }
    }
    state.report.level_change =
        ai::change_level(state.agents, settings, difficulty, level, state.now, state.settings.dt);
}

void wake_agent(ZoneState& state, world::Row row) {
    ai::Agent* const agent = state.agents.find(state.entities.id[row]);
    if (agent == nullptr || agent->tier != ai::Tier::kSuspended) {
        return;
    }
    compute::Team alone;
    ai::AiContext ai = context_of(state, alone, nullptr);
    ai.paths = nullptr;  // it stands up where the ground under it carries it
    ai::resume(*agent, state.settings.ai.compiled[agent->brain], ai, row);
    state.agents.resume(agent->entity);
    add_body(state, row, false);
    state.grid_valid = false;
}

}  // namespace zoned::zone
