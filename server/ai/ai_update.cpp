#include "server/ai/ai_update.h"

#include "server/ai/steering/steering.h"
#include "server/ai/update/decision_update.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

AiReport AiUpdate::run(const AiContext& context) {
    AiContext ai = context;
    ai.near = &nobody_;
    AiTurn& turn = turn_;
    const bool may_suspend = std::isfinite(ai.settings.viewer_range_m);
    turn.report = AiReport{};
    turn.row_hints.resize(ai.agents.slots(), world::kNoRow);
    offscreen_.clear();
    viewers_.gather(ai);
    meetings_.index_suspended(ai, turn);
    if (may_suspend) {
        viewers_.follow_viewers(ai, turn, meetings_);
        meetings_.meet(ai, turn);
        offscreen_.resume_waking(ai, turn, meetings_);
    }
    forage_.call_foragers(ai);
    collect_due(ai, turn, meetings_, trades_);
    if (needs_others(ai, turn, meetings_.ranges())) {
        ai.near = &ai.make_grid();
    }
    decide_due(ai, turn, meetings_.ranges(), viewers_);
    trades_.settle_trades(ai, turn, meetings_);
    watch_changes(ai, turn);
    forage_.forage(ai, turn);
    crowd_.place_formations(ai, turn);
    steer_active(ai);
    herds_.head_herds(ai, turn);
    OffscreenUpdate::advance_suspended(ai, turn);
    HerdUpdate::walk_herd_steps(ai, turn);
    paths_.find_paths(ai, turn, meetings_);
    give_commands(ai);
    crowd_.avoid(ai, turn);
    OffscreenUpdate::go_on(ai, turn, meetings_);
    HerdUpdate::settle_herd_steps(ai, turn, meetings_);
    if (may_suspend) {
        offscreen_.suspend_unseen(ai, turn, meetings_);
    }
    add_up();
    turn.report.agents = static_cast<std::uint32_t>(ai.agents.size());
    turn.report.active = static_cast<std::uint32_t>(ai.agents.active().size());
    return turn.report;
}

void AiUpdate::steer_active(const AiContext& ai) {
    const std::span<const Slot> active = ai.agents.active();
    const HerdDrift drift = drift_of(ai, turn_);
    turn_.in_lanes(ai.team, active.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = turn_.rows[i];
            if (row == world::kNoRow) {
                continue;
            }
            Agent& agent = ai.agents.at(active[i]);
            if (steers_now(agent, ai.settings, ai.now)) {
                Surroundings around = surroundings_of(ai, agent, row, active[i]);
                around.drift = turn_.drift_m > 0.0F ? &drift : nullptr;
                if (steer(agent, brain_of(agent, ai.settings), around)) {
                    lane.asking.push_back(active[i]);
                }
                ++lane.steered;
            }
        }
    });
}

/// Gives the commands of active agents.
void AiUpdate::give_commands(const AiContext& ai) {
    const std::span<const Slot> active = ai.agents.active();
    turn_.in_lanes(ai.team, active.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = turn_.rows[i];
            if (row == world::kNoRow) {
                continue;
            }
            const Agent& agent = ai.agents.at(active[i]);
            ai.entities.command[row] = agent.aim;
            ai.entities.command[row].tick = ai.now;
            ai.entities.stance[row] =
                brain_of(agent, ai.settings).states[agent.current_action].stance;
        }
    });
}

void AiUpdate::add_up() {
    AiReport& report = turn_.report;
    for (AiLane& lane : turn_.lanes) {
        report.transitions += std::exchange(lane.transitions, 0U);
        report.steered += std::exchange(lane.steered, 0U);
        turn_.drift_m = std::max(turn_.drift_m, std::exchange(lane.drift_m, 0.0F));
        report.plans += std::exchange(lane.scratch.plans, 0U);
        report.plans_cut_off += std::exchange(lane.scratch.plans_cut_off, 0U);
        report.plans_unreachable += std::exchange(lane.scratch.plans_unreachable, 0U);
    }
}

void AiUpdate::load(const SavedAiState& saved,
                    const Nests::SavedNests& nests,
                    const AgentStore& agents,
                    const AiSettings& settings) {
    difficulty_ = saved.difficulty;
    forage_.load(nests);
    meetings_.reset();
    viewers_.load(saved.viewers);
    turn_.waking.clear();
    turn_.drift_m = saved.drift_m;
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Agent& agent = agents.at(agents.nth(n));
        if (agent.tier == Tier::kSuspended && !can_suspend(agent, brain_of(agent, settings))) {
            turn_.waking.push_back(agents.nth(n));
        }
    }
}

void AiUpdate::hash(const AgentStore& agents, core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(agents.size()));
    nests().hash(hash);
    for (const DueAgent& due : turn_.due) {
        // The agent may have gone to another zone since.
        const Agent& agent = agents.at(due.slot);
        if (agent.entity != due.entity) {
            continue;
        }
        if (due.tier == Tier::kSuspended && !due.decides && !due.waited && !due.changed) {
            hash_walk(hash, agent);
        } else {
            ai::hash(hash, agent);
        }
    }
    for (const HerdStep& stepper : turn_.herd_steps) {
        const Agent& agent = agents.at(stepper.slot);
        if (agent.entity == stepper.entity) {
            hash_step(hash, agent);
        }
    }
}

}  // namespace zoned::ai
