#include "server/app/runtime/state_flapping_report.h"

#include "server/ai/explain.h"
#include "server/app/log/log.h"

#include <algorithm>

namespace zoned::app {

namespace {

recording::FlappingFigures* find(std::vector<recording::FlappingFigures>& all,
                                 const recording::FlappingFigures& pair) {
    const auto at = std::find_if(all.begin(), all.end(), [&pair](const auto& other) {
        return other.brain == pair.brain && other.states == pair.states;
    });
    return at == all.end() ? nullptr : &*at;
}

}  // namespace

std::vector<recording::FlappingFigures> flapping_of(
    std::span<const std::unique_ptr<zone::Zone>> zones) {
    std::vector<recording::FlappingFigures> out;
    for (const auto& zone : zones) {
        const zone::ZoneState& state = zone->state();
        const ai::AiSettings& agents = state.settings.ai;
        for (std::size_t m = 0; m < agents.compiled.size(); ++m) {
            for (const ai::state_machine::FlappingPair& o : state.agents.state_flapping(m)) {
                const ai::CompiledBrain& compiled = agents.compiled[m];
                const auto text = [&](std::uint16_t from, std::uint16_t to, std::uint16_t by) {
                    return ai::transition_text(agents.brains[m], compiled, from, to, by);
                };
                recording::FlappingFigures pair;
                pair.brain = compiled.name;
                pair.states = {compiled.table.state_name(o.a), compiled.table.state_name(o.b)};
                pair.forth = text(o.a, o.b, o.a_to_b);
                pair.back = text(o.b, o.a, o.b_to_a);
                pair.count = o.count;
                pair.entity = o.agent;
                pair.tick = static_cast<std::uint64_t>(o.at);
                recording::FlappingFigures* known = find(out, pair);
                if (known == nullptr) {
                    out.push_back(std::move(pair));
                    continue;
                }
                known->count += pair.count;
                if (pair.tick > known->tick) {
                    known->entity = pair.entity;
                    known->tick = pair.tick;
                }
            }
        }
    }
    return out;
}

void tell_flapping(const std::vector<recording::FlappingFigures>& now,
                   std::vector<recording::FlappingFigures>& logged) {
    for (const recording::FlappingFigures& pair : now) {
        if (find(logged, pair) != nullptr) {
            continue;
        }
        logged.push_back(pair);
        log_of(LogArea::kAgents)
            .warn("brain {}: NPCs go to and fro: {}, and {} (entity {} at tick {})",
                  pair.brain,
                  pair.forth,
                  pair.back,
                  pair.entity,
                  pair.tick);
    }
}

}  // namespace zoned::app
