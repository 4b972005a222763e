#include "server/ai/ladder.h"

#include "server/ai/adopt.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

namespace {

/// Exchanges the brains of the settings and those kept at a rung.
void exchange_brains(AiSettings& settings, std::uint16_t rung) {
    Rung& kept = settings.ladder.rungs[rung];
    std::swap(settings.brains, kept.brains);
    std::swap(settings.compiled, kept.compiled);
}

}  // namespace

Ladder first_of(const LadderSettings& settings) {
    Ladder ladder;
    ladder.rung = settings.start;
    ladder.level = static_cast<float>(settings.start);
    return ladder;
}

void note_outcome(Ladder& ladder, const LadderSettings& settings, bool player_succeeded) {
    if (settings.rungs.empty()) {
        return;
    }
    ladder.level = learning::stepped(settings.staircase, ladder.level, player_succeeded);
    ++(player_succeeded ? ladder.successes : ladder.failures);
}

std::uint16_t rung_due(const Ladder& ladder, const LadderSettings& settings, Tick now) {
    if (settings.rungs.empty() || now - ladder.changed_at < settings.between) {
        return ladder.rung;
    }
    const auto here = static_cast<float>(ladder.rung);
    if (ladder.level >= here + 1.0F) {
        return static_cast<std::uint16_t>(std::floor(ladder.level));
    }
    return ladder.level <= here - 1.0F ? static_cast<std::uint16_t>(std::ceil(ladder.level))
                                       : ladder.rung;
}

const CompiledBrain& brain_at_level(const AiSettings& settings,
                                    std::uint16_t rung,
                                    std::size_t index) {
    const bool here = settings.ladder.rungs.empty() || rung == settings.ladder.active;
    return here ? settings.compiled[index] : settings.ladder.rungs[rung].compiled[index];
}

void put_on_rung(AiSettings& settings, std::uint16_t rung) {
    if (settings.ladder.rungs.empty() || rung == settings.ladder.active) {
        return;
    }
    exchange_brains(settings, settings.ladder.active);
    exchange_brains(settings, rung);
    settings.ladder.active = rung;
}

void adopt_from_rung(Agent& agent,
                     const AiSettings& settings,
                     std::uint16_t rung,
                     Tick now,
                     float dt) {
    if (rung == settings.ladder.active || settings.ladder.rungs.empty() ||
        !settings.ladder.varies[agent.brain]) {
        return;
    }
    adopt(agent,
          brain_at_level(settings, rung, agent.brain),
          settings.compiled[agent.brain],
          agent.brain,
          now,
          dt);
}

RungChange change_rung(AgentStore& agents,
                       AiSettings& settings,
                       Ladder& ladder,
                       std::uint16_t rung,
                       Tick now,
                       float dt) {
    const RungChange change{ladder.rung, rung, ladder.level, ladder.successes, ladder.failures};
    put_on_rung(settings, rung);
    for (std::size_t n = 0; n < agents.size(); ++n) {
        Agent& agent = agents.at(agents.nth(n));
        ZONED_ASSERT(agent.tier != Tier::kSuspended || !settings.ladder.varies[agent.brain],
                     "who is to live by other brains was woken up");
        adopt_from_rung(agent, settings, change.from, now, dt);
    }
    agents.forget_wavering();  // the numbers of transitions may be others
    ladder.rung = rung;
    ladder.successes = 0;
    ladder.failures = 0;
    ladder.changed_at = now;
    return change;
}

void go_on_with(Ladder& ladder, const LadderSettings& before, AiSettings& settings, Tick now) {
    const LadderSettings& after = settings.ladder;
    const auto same = [&](const Rung& rung) {
        return !before.rungs.empty() && rung.name == before.rungs[ladder.rung].name;
    };
    const auto at = std::find_if(after.rungs.begin(), after.rungs.end(), same);
    const auto rung = static_cast<std::uint16_t>(at - after.rungs.begin());
    const learning::Staircase& cap = after.staircase;
    const auto wanted = static_cast<float>(rung);
    if (at == after.rungs.end() || wanted < cap.least || wanted > cap.most) {
        ladder = first_of(after);
        ladder.changed_at = now;
        return;
    }
    const float off = ladder.level - static_cast<float>(ladder.rung);
    ladder.level = std::clamp(wanted + off, cap.least, cap.most);
    ladder.rung = rung;
    put_on_rung(settings, rung);
}

}  // namespace zoned::ai
