#include "server/app/log/difficulty_log.h"

#include "server/app/log/log.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace zoned::app {

namespace {

constexpr float kLoggedBandChange = 0.1F;

bool has_band(const ai::CompiledBrain& brain) {
    return std::any_of(brain.states.begin(), brain.states.end(), [](const ai::BrainState& state) {
        return state.rubber_band.has_value();
    });
}

void add_band(float factor, BandFigures& figures) {
    figures.least = figures.npcs == 0 ? factor : std::min(figures.least, factor);
    figures.most = figures.npcs == 0 ? factor : std::max(figures.most, factor);
    ++figures.npcs;
}

}  // namespace

std::string difficulty_text(const zone::ZoneState& state) {
    const ai::DifficultyLevels& settings = state.settings.ai.difficulty;
    if (settings.levels.empty()) {
        return {};
    }
    const ai::DifficultyState& difficulty = state.ai_update.difficulty();
    const auto name = [&](float position) {
        return settings.levels[static_cast<std::size_t>(position)].name;
    };
    return fmt::format(
        "difficulty: {}, of {} to {}; {} successes and {} failures of players at it, level "
        "{:.2f}\n",
        settings.levels[difficulty.level].name,
        name(settings.staircase.least),
        name(settings.staircase.most),
        difficulty.successes,
        difficulty.failures,
        difficulty.position);
}

void log_difficulty(const zone::Zone& zone) {
    const auto& change = zone.report().level_change;
    if (!change) {
        return;
    }
    const ai::DifficultyLevels& settings = zone.state().settings.ai.difficulty;
    log_of(LogArea::kAgents)
        .info(
            "zone {}: difficulty {} -> {} at tick {}: {} successes and {} failures of players "
            "at {}, level {:.2f}",
            zone.state().settings.id.value,
            settings.levels[change->from].name,
            settings.levels[change->to].name,
            zone.report().tick,
            change->successes,
            change->failures,
            settings.levels[change->from].name,
            change->position);
}

std::map<std::string, BandFigures> bands_of(std::span<const std::unique_ptr<zone::Zone>> zones) {
    std::map<std::string, BandFigures> out;
    for (const auto& zone : zones) {
        const zone::ZoneState& state = zone->state();
        const auto& brains = state.settings.ai.compiled;
        if (std::none_of(brains.begin(), brains.end(), has_band)) {
            continue;
        }
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const ai::Agent& agent = state.agents.at(state.agents.nth(n));
            const ai::CompiledBrain& brain = brains[agent.brain];
            if (brain.states[agent.current_action].rubber_band) {
                add_band(agent.band, out[brain.name]);
            }
        }
    }
    return out;
}

void log_bands(const std::map<std::string, BandFigures>& now,
               Tick tick,
               Tick between,
               LoggedBands& logged) {
    for (const auto& [brain, figures] : now) {
        LoggedBands::LoggedBand& last = logged.by_brain[brain];
        const bool other = std::abs(figures.least - last.figures.least) >= kLoggedBandChange ||
                           std::abs(figures.most - last.figures.most) >= kLoggedBandChange;
        if (!other || (last.at && tick - *last.at < between)) {
            continue;
        }
        log_of(LogArea::kAgents)
            .info(
                "brain {}: rubber bands of {} NPCs: speed times {:.2f} to {:.2f}, before "
                "{:.2f} to {:.2f} (tick {})",
                brain,
                figures.npcs,
                figures.least,
                figures.most,
                last.figures.least,
                last.figures.most,
                tick);
        last = {figures, tick};
    }
}

}  // namespace zoned::app
