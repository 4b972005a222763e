#include "server/ai/agent/ai_settings.h"

#include <algorithm>

namespace zoned::ai {

namespace {

std::vector<CompiledBrain> compiled_of(const std::vector<Brain>& brains, float dt) {
    std::vector<CompiledBrain> out;
    for (const Brain& brain : brains) {
        out.push_back(brain.inner ? CompiledBrain{} : compile(brain, dt));
    }
    return out;
}

}  // namespace

void compile(AiSettings& settings, float dt) {
    settings.compiled = compiled_of(settings.brains, dt);
    for (DifficultyLevel& level : settings.difficulty.levels) {
        level.compiled = compiled_of(level.brains, dt);
    }
    if (settings.avoidance) {
        steering::AvoidanceSettings& avoidance = *settings.avoidance;
        avoidance.step_s = dt;
        avoidance.horizon_s = std::max(avoidance.horizon_s, dt);
        avoidance.wall_horizon_s = std::max(avoidance.wall_horizon_s, dt);
    }
}

}  // namespace zoned::ai
