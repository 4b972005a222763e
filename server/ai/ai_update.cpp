#include "server/ai/ai_update.h"

#include "server/ai/ai_update_lookup.h"
#include "server/ai/perception/perception.h"
#include "server/ai/steering/steering.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

OffscreenContext AiUpdate::offscreen(const AiContext& world) const {
    return {world.entities,
            world.types,
            nobody_,
            world.points_of_interest,
            world.statics,
            world.now,
            world.dt,
            world.paths};
}

// ---------------------------------------------------------------- what is to be done

/// Finds the rows of active agents, and who has something to do, the longest waiting first; what is
/// beyond the budget waits.
void AiUpdate::collect_due(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    const std::span<const Slot> active = agents.active();
    rows_.resize(active.size());
    due_.clear();
    herd_steps_.clear();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = agents.at(active[i]);
        rows_[i] = row_of(world.entities, agent.entity, row_hints_[active[i]]);
        row_hints_[active[i]] = rows_[i];
        if (rows_[i] != world::kNoRow && perception_ranges_.any()) {
            slot_hints_[rows_[i]] = active[i];
        }
        if (rows_[i] != world::kNoRow && agent.next_decision <= world.now) {
            due_.push_back({agent.next_decision, agent.entity, active[i], rows_[i], Tier::kActive});
        }
    }
    events_.clear();
    agents.take_due(world.now, events_);
    call_up_waiting(agents, world, settings);
    for (const AgentStore::Event& event : events_) {
        __builtin_prefetch(&row_hints_[event.slot], 1);
    }
    std::sort(
        events_.begin(), events_.end(), [](const AgentStore::Event& a, const AgentStore::Event& b) {
            return a.at != b.at ? a.at < b.at : a.entity < b.entity;
        });
    // They are anywhere in memory.
    for (const AgentStore::Event& event : events_) {
        world.entities.prefetch(row_hints_[event.slot]);
        agents.prefetch_neighbours(event.slot);
    }
    for (const AgentStore::Event& event : events_) {
        const world::Row row = row_of(world.entities, event.entity, row_hints_[event.slot]);
        row_hints_[event.slot] = row;
        if (row == world::kNoRow) {
            continue;
        }
        const Agent& agent = agents.at(event.slot);
        if (!event.waited && only_steps(agent, brain_of(agent, settings), offscreen(world), row)) {
            herd_steps_.push_back({event.entity, event.slot, row});
        } else {
            due_.push_back({event.at, event.entity, event.slot, row, Tier::kSuspended});
            due_.back().waited = event.waited || agent.wait.any();
        }
    }
    const auto before = [](const DueAgent& a, const DueAgent& b) {
        return a.since != b.since ? a.since < b.since : a.entity < b.entity;
    };
    // As they are where only some are active, or nobody; they are large.
    if (!std::is_sorted(due_.begin(), due_.end(), before)) {
        std::sort(due_.begin(), due_.end(), before);
    }
    keep_to_budgets(agents, world, settings);
}

/// Of decisions, and of rays: whoever looks along lines of percept takes as many as it may need.
void AiUpdate::keep_to_budgets(AgentStore& agents,
                               const AiContext& world,
                               const AiSettings& settings) {
    const std::size_t budget = std::max<std::size_t>(1, settings.max_decisions_per_tick);
    std::uint32_t rays = std::max(settings.max_sight_rays_per_tick, kRaysPerLook);
    std::size_t kept = 0;
    for (const DueAgent& due : due_) {
        const bool looks = due.tier == Tier::kActive &&
                           brain_of(agents.at(due.slot), settings).perception.line_of_sight;
        const bool blind = looks && rays < kRaysPerLook;
        if (kept < budget && !blind) {
            rays -= looks ? kRaysPerLook : 0U;
            if (&due_[kept] != &due) {
                due_[kept] = due;
            }
            ++kept;
            continue;
        }
        if (due.tier == Tier::kSuspended) {
            agents.at(due.slot).next_event = due.since;
            agents.schedule(due.slot, 1);  // it waits for nothing
            const Tick left = left_at(agents.at(due.slot), world, true);
            settle(agents, due.slot, std::max(left, world.now + 1), world, true);
        }
        report_.blinded += kept < budget ? 1U : 0U;
        ++report_.postponed;
    }
    due_.resize(kept);
}

/// The grid is made only where some active agent looks for others than players, or is looked for.
void AiUpdate::find_others(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    const std::span<const Slot> active = agents.active();
    bool needed = false;
    for (std::size_t i = 0; i < active.size() && !needed; ++i) {
        const Agent& agent = agents.at(active[i]);
        needed =
            brain_of(agent, settings).knows_others ||
            (perception_ranges_.any() && rows_[i] != world::kNoRow &&
             perception_ranges_.farthest({world.entities.type[rows_[i]], agent.brain}) >= 0.0F);
    }
    others_ = needed ? &world.grid() : &nobody_;
}

// ---------------------------------------------------------------- current_action it

void AiUpdate::decide_one(AgentStore& agents,
                          DueAgent& due,
                          const AiContext& world,
                          const AiSettings& settings,
                          AiLane& lane) {
    Agent& agent = agents.at(due.slot);
    const CompiledBrain& brain = brain_of(agent, settings);
    const world::Entities& e = world.entities;
    const bool active = due.tier == Tier::kActive;
    const Timetables timetables{agents, slot_hints_};
    const Percept percept = active ? perceive({e,
                                               world.types,
                                               *others_,
                                               world.query,
                                               world.now,
                                               world.dt,
                                               settings.far_m,
                                               &players_,
                                               perception_ranges_.any() ? &timetables : nullptr},
                                              due.row,
                                              agent,
                                              brain)
                                   : Percept::none();
    const Vec2 body(e.position[due.row].x(), e.position[due.row].z());
    const Vec2 here = whereabouts(agent, body, world.now, world.dt);
    if (decide(agent, brain, percept, here, world.points_of_interest, world.now, lane.scratch)) {
        ++lane.transitions;
        due.change = lane.scratch.change;
    }
    due.changed = agent.entered;
    if (active) {
        agent.next_decision =
            next_decision(agent.entity, decision_period(brain, world.dt), world.now);
        if (viewer_coverage_.covers(body)) {
            agent.offscreen_since = kNever;
        } else if (agent.offscreen_since == kNever) {
            agent.offscreen_since = world.now;
        }
    }
}

/// First who goes from event to event is put where he is, then all look around.
void AiUpdate::decide_due(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    in_lanes(world.team, due_.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (due_[i].tier == Tier::kSuspended) {
                Agent& agent = agents.at(due_[i].slot);
                due_[i].decides = agent.next_decision <= world.now;
                catch_up(agent, offscreen(world), due_[i].row);
                due_[i].moved = world.entities.discontinuity_tick[due_[i].row] == world.now;
            }
        }
    });
    in_lanes(world.team, due_.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        lane.scratch.max_plan_nodes = settings.max_plan_nodes;
        for (std::size_t i = begin; i < end; ++i) {
            if (due_[i].decides) {
                decide_one(agents, due_[i], world, settings, lane);
            }
        }
    });
}

/// Who goes to and fro: for reports alone.
void AiUpdate::watch_changes(AgentStore& agents, const AiContext& world) const {
    for (const DueAgent& due : due_) {
        if (due.change) {
            agents.watch(due.slot, *due.change, world.now, world.dt);
        }
    }
}

/// Legs of offscreen agents whose event this is.
void AiUpdate::advance_suspended(AgentStore& agents,
                                 const AiContext& world,
                                 const AiSettings& settings) {
    in_lanes(world.team, due_.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            DueAgent& due = due_[i];
            if (due.tier != Tier::kSuspended) {
                continue;
            }
            Agent& agent = agents.at(due.slot);
            const CompiledBrain& brain = brain_of(agent, settings);
            if (due.roams) {
                const Vec3 from = world.entities.position[due.row];
                take_step(agent, brain, offscreen(world), from, due.end);
                agent.placed = Vec2(from.x(), from.z());
                lane.drift_m = std::max(lane.drift_m, step_of(agent));
            } else if (!roams(agent, brain) &&
                       walk_on(agent, brain, offscreen(world), due.row, due.slot)) {
                lane.asking.push_back(due.slot);
            }
            std::uint8_t& stance = world.entities.stance[due.row];
            due.moved = due.moved || stance != brain.states[agent.current_action].stance;
            stance = brain.states[agent.current_action].stance;
        }
    });
}

/// Of active agents.
void AiUpdate::give_commands(const AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings) {
    const std::span<const Slot> active = agents.active();
    in_lanes(world.team, active.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = rows_[i];
            if (row == world::kNoRow) {
                continue;
            }
            const Agent& agent = agents.at(active[i]);
            world.entities.command[row] = agent.aim;
            world.entities.command[row].tick = world.now;
            world.entities.stance[row] =
                brain_of(agent, settings).states[agent.current_action].stance;
        }
    });
}

/// Of a offscreen agent: what its next_event() has found.
void AiUpdate::plan(AgentStore& agents,
                    Slot slot,
                    const AiContext& world,
                    const AiSettings& settings) const {
    agents.schedule(slot, decision_period(brain_of(agents.at(slot), settings), world.dt));
}

/// Offscreen agents whose event this was: to the next one.
void AiUpdate::go_on(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    in_lanes(world.team, due_.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            DueAgent& due = due_[i];
            if (due.tier == Tier::kSuspended) {
                Agent& agent = agents.at(due.slot);
                due.next_event = event_after(agent, due, world, settings);
                due.left = std::max(left_at(agent, world), world.now + 1);
            }
        }
    });
    for (const DueAgent& due : due_) {
        if (due.tier == Tier::kSuspended) {
            Agent& agent = agents.at(due.slot);
            agent.next_event = due.next_event;
            plan(agents, due.slot, world, settings);
            settle(agents, due.slot, due.left, world);
            if (due.moved) {
                world.entities.touch(due.row);
                report_.moved = true;
            }
            if (!due.end.stands || !can_suspend(agent, brain_of(agent, settings))) {
                waking_.push_back(due.slot);
            }
            ++report_.events;
        }
        report_.decisions += due.decides ? 1U : 0U;
    }
}

/// Awake agents that have decided and that nobody can see for a while.
void AiUpdate::suspend_unseen(AgentStore& agents,
                              const AiContext& world,
                              const AiSettings& settings) {
    const Tick calm = static_cast<Tick>(std::ceil(settings.suspend_after_s / world.dt));
    for (const DueAgent& due : due_) {
        Agent& agent = agents.at(due.slot);
        if (due.tier == Tier::kSuspended || agent.offscreen_since == kNever ||
            world.now - agent.offscreen_since < calm ||
            !can_suspend(agent, brain_of(agent, settings)) ||
            !world.entities.has(due.row, world::kGrounded)) {
            continue;
        }
        const CompiledBrain& brain = brain_of(agent, settings);
        // A blend goes by none while it is active, however settled it is.
        const bool blends = brain.choices[agent.state_machine.state()].blend >= 0;
        if (blends ? world.now < agent.detour_until
                   : !agent.timed && goes_by_segments(agent, brain.states[agent.current_action])) {
            continue;  // on a detour
        }
        if (!meets_nobody(agents, due, world, calm)) {
            agent.offscreen_since = world.now;  // others are no better than viewers
            continue;
        }
        if (roams(agent, brain) && !set_roaming(agent, due, world, settings)) {
            continue;  // on its way down
        }
        suspend(agent, brain, offscreen(world), due.row);
        if (agent.next_proximity_check != kNever) {
            proximity_schedule_.put(
                due.slot, world.entities.type[due.row], scene(agents, world), false);
        }
        agent.next_event = next_event(agent, brain, offscreen(world));
        agents.suspend(due.slot);
        plan(agents, due.slot, world, settings);
        settle(agents, due.slot, std::max(left_at(agent, world), world.now + 1), world);
        suspended_.push_back(agent.entity);
    }
    std::sort(suspended_.begin(), suspended_.end());
}

void AiUpdate::steer_active(AgentStore& agents,
                            const AiContext& world,
                            const AiSettings& settings) {
    const std::span<const Slot> active = agents.active();
    const HerdDrift drift = drift_of(agents, world);
    in_lanes(world.team, active.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = rows_[i];
            if (row == world::kNoRow) {
                continue;
            }
            Agent& agent = agents.at(active[i]);
            const CompiledBrain& brain = brain_of(agent, settings);
            if (steers_now(agent, settings, world.now)) {
                Surroundings around{world.entities,
                                    world.types,
                                    *others_,
                                    world.points_of_interest,
                                    row,
                                    world.now,
                                    world.dt,
                                    world.paths,
                                    active[i]};
                around.at = whereabouts(agent, around.body(), world.now, world.dt);
                around.drift = drift_m_ > 0.0F ? &drift : nullptr;
                if (steer(agent, brain, around)) {
                    lane.asking.push_back(active[i]);
                }
                ++lane.steered;
            }
        }
    });
}

void AiUpdate::add_up() {
    for (AiLane& lane : lanes_) {
        report_.transitions += std::exchange(lane.transitions, 0U);
        report_.steered += std::exchange(lane.steered, 0U);
        drift_m_ = std::max(drift_m_, std::exchange(lane.drift_m, 0.0F));
        report_.plans += std::exchange(lane.scratch.plans, 0U);
        report_.plans_cut_off += std::exchange(lane.scratch.plans_cut_off, 0U);
        report_.plans_unreachable += std::exchange(lane.scratch.plans_unreachable, 0U);
    }
}

AiReport AiUpdate::run(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    report_ = AiReport{};
    suspended_.clear();
    resumed_.clear();
    row_hints_.resize(agents.slots(), world::kNoRow);
    players_.gather(world.entities);
    index_suspended(agents, world, settings);
    if (std::isfinite(settings.viewer_range_m)) {
        follow_viewers(agents, world, settings);
        meet(agents, world);
        resume_seen(agents, world, settings);
    }
    call_foragers(agents, world, settings);
    collect_due(agents, world, settings);
    find_others(agents, world, settings);
    decide_due(agents, world, settings);
    settle_trades(agents, world, settings);
    watch_changes(agents, world);
    forage(agents, world, settings);
    formation_following(agents, world, settings);
    steer_active(agents, world, settings);
    head_herds(agents, world, settings);
    advance_suspended(agents, world, settings);
    walk_herd_steps(agents, world, settings);
    find_paths(agents, world, settings);
    give_commands(agents, world, settings);
    local_avoidance(agents, world, settings);
    go_on(agents, world, settings);
    settle_herd_steps(agents, world, settings);
    if (std::isfinite(settings.viewer_range_m)) {
        suspend_unseen(agents, world, settings);
    }
    add_up();
    report_.agents = static_cast<std::uint32_t>(agents.size());
    report_.active = static_cast<std::uint32_t>(agents.active().size());
    return report_;
}

void AiUpdate::load(const SavedAiState& memory,
                    const Nests::SavedNests& nests,
                    const AgentStore& agents,
                    const AiSettings& settings) {
    saved_ = memory;
    nests_.load(nests);
    perception_ranges_ = PerceptionRanges();  // who sleeps is found anew
    watch();
    waking_.clear();
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Agent& agent = agents.at(agents.nth(n));
        if (agent.tier == Tier::kSuspended && !can_suspend(agent, brain_of(agent, settings))) {
            waking_.push_back(agents.nth(n));
        }
        if (agent.tier == Tier::kSuspended && roams(agent, brain_of(agent, settings))) {
            drift_m_ = std::max(drift_m_, step_of(agent));
        }
    }
}

void AiUpdate::hash(const AgentStore& agents, core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(agents.size()));
    nests_.hash(hash);
    for (const DueAgent& due : due_) {
        // It may have gone to another zone since.
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
    for (const HerdStep& stepper : herd_steps_) {
        const Agent& agent = agents.at(stepper.slot);
        if (agent.entity == stepper.entity) {
            hash_step(hash, agent);
        }
    }
}

}  // namespace zoned::ai
