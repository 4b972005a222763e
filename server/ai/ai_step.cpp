#include "server/ai/ai_step.h"

#include "server/ai/lod.h"
#include "server/ai/perception.h"
#include "server/ai/steering.h"
#include "server/ai/step_lookup.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

namespace {

/// All coarse minds are looked at once in so many ticks, in turn.
constexpr Tick kLookPeriod = 16;
/// Entities of coarse minds are put where they are when they have walked so far, m.
constexpr float kStale_m = 8.0F;

/// From how far off a mind is woken, m: so that it is awake when its entity can be seen, though
/// that is put where it is now and then only, and both run towards each other between two looks.
float waking_radius(const World& world, const Settings& settings) {
    float fastest = 0.0F;
    for (const world::EntityType& type : world.types) {
        fastest = std::max(fastest, type.character.speed * type.character.sprint_factor);
    }
    return settings.seen_m + kStale_m + 2.0F * fastest * static_cast<float>(kLookPeriod) * world.dt;
}

/// Fewer minds than this are not worth a second thread.
constexpr std::size_t kShared = 256;

bool outside(const Vec2& at, const Vec2& half_size) {
    return std::abs(at.x()) > half_size.x() || std::abs(at.y()) > half_size.y();
}

}  // namespace

void compile(Settings& settings, float dt) {
    settings.compiled.clear();
    for (const Machine& machine : settings.machines) {
        settings.compiled.push_back(machine.inner ? CompiledMachine{} : compile(machine, dt));
    }
    if (settings.avoidance) {
        crowd::AvoidanceSettings& avoidance = *settings.avoidance;
        avoidance.step_s = dt;
        avoidance.horizon_s = std::max(avoidance.horizon_s, dt);
        avoidance.wall_horizon_s = std::max(avoidance.wall_horizon_s, dt);
    }
}

CoarseWorld Step::coarse(const World& world) const {
    return {world.entities,
            world.types,
            nobody_,
            world.places,
            world.statics,
            world.now,
            world.dt,
            world.ways};
}

// ---------------------------------------------------------------- who is seen

/// Where players are. One who was not here a tick ago, or is back, is heard of at once.
void Step::follow_viewers(Minds& minds, const World& world, const Settings& settings) {
    const world::Entities& e = world.entities;
    viewers_before_.swap(memory_.viewers);
    memory_.viewers.clear();
    for (const world::Row row : players_.rows) {
        memory_.viewers.push_back(e.id[row]);
    }
    std::sort(memory_.viewers.begin(), memory_.viewers.end());
    const bool appeared = !std::includes(viewers_before_.begin(),
                                         viewers_before_.end(),
                                         memory_.viewers.begin(),
                                         memory_.viewers.end());
    const bool jumped =
        std::any_of(memory_.viewers.begin(), memory_.viewers.end(), [&](EntityId id) {
            return e.discontinuity_tick[e.find(id)] >= world.now - 1;
        });
    if (appeared || jumped || world.now % kLookPeriod == 0) {
        memory_.watched_from.clear();
        for (const Vec3& at : players_.at) {
            memory_.watched_from.emplace_back(at.x(), at.z());
        }
        memory_.watched_m = waking_radius(world, settings);
        watched_.build(memory_.watched_from, memory_.watched_m);
    }
    // Without anybody to see them, and nowhere to go to, it does not matter where they are.
    if (!memory_.viewers.empty() || world.half_size.allFinite()) {
        look_at_coarse(minds, world, appeared || jumped);
    }
}

/// Wakes who may be seen. All are looked at in turn, at once where `all`.
void Step::look_at_coarse(Minds& minds, const World& world, bool all) {
    const std::size_t count = minds.size();
    const auto turn = static_cast<std::size_t>(world.now % kLookPeriod);
    const std::size_t begin = all ? 0 : count * turn / kLookPeriod;
    const std::size_t end = all ? count : count * (turn + 1) / kLookPeriod;
    for (std::size_t n = begin; n < end; ++n) {
        const Slot slot = minds.nth(n);
        Mind& mind = minds.at(slot);
        if (mind.tier != Tier::kCoarse) {
            continue;
        }
        const Vec2 at = position_at(mind.leg, world.now - 1, world.dt);
        const bool wakes = watched_.covers(at) || outside(at, world.half_size);
        const bool stale = mind.leg.length > 0.0F && (at - mind.placed).norm() >= kStale_m;
        if (!wakes && !stale) {
            continue;
        }
        const world::Row row = row_of(world.entities, mind.entity);
        if (row == world::kNoRow) {
            continue;
        }
        if (wakes) {
            waking_.push_back(slot);
        } else {
            catch_up(mind, coarse(world), row);
            report_.moved = true;
        }
    }
}

void Step::wake_seen(Minds& minds, const World& world, const Settings& settings) {
    for (const Slot slot : waking_) {
        Mind& mind = minds.at(slot);
        // Some are here since the last tick.
        const world::Row row = row_of(world.entities, mind.entity);
        if (!mind.entity || mind.tier != Tier::kCoarse || row == world::kNoRow) {
            continue;
        }
        wake_up(mind, machine_of(mind, settings), coarse(world), row);
        minds.wake(slot);
        woke_up_.push_back(mind.entity);
        report_.moved = true;
    }
    waking_.clear();
}

// ---------------------------------------------------------------- what is to be done

/// Finds the rows of awake minds, and who has something to do, the longest waiting first; what is
/// beyond the budget waits.
void Step::collect_due(Minds& minds, const World& world, const Settings& settings) {
    const std::span<const Slot> awake = minds.awake();
    rows_.resize(awake.size());
    row_hints_.resize(minds.slots(), world::kNoRow);
    due_.clear();
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const Mind& mind = minds.at(awake[i]);
        rows_[i] = row_of(world.entities, mind.entity, row_hints_[awake[i]]);
        row_hints_[awake[i]] = rows_[i];
        if (rows_[i] != world::kNoRow && mind.next_decision <= world.now) {
            due_.push_back({mind.next_decision, mind.entity, awake[i], rows_[i], Tier::kAwake});
        }
    }
    events_.clear();
    minds.take_due(world.now, events_);
    for (const Minds::Event& event : events_) {
        const world::Row row = row_of(world.entities, event.entity, row_hints_[event.slot]);
        row_hints_[event.slot] = row;
        if (row != world::kNoRow) {
            due_.push_back({event.at, event.entity, event.slot, row, Tier::kCoarse});
        }
    }
    std::sort(due_.begin(), due_.end(), [](const Due& a, const Due& b) {
        return a.since != b.since ? a.since < b.since : a.entity < b.entity;
    });
    keep_to_budgets(minds, settings);
}

/// Of decisions, and of rays: whoever looks along lines of sight takes as many as it may need.
void Step::keep_to_budgets(Minds& minds, const Settings& settings) {
    const std::size_t budget = std::max<std::size_t>(1, settings.max_decisions_per_tick);
    std::uint32_t rays = std::max(settings.max_sight_rays_per_tick, kRaysPerLook);
    std::size_t kept = 0;
    for (const Due& due : due_) {
        const bool looks = due.tier == Tier::kAwake &&
                           machine_of(minds.at(due.slot), settings).perception.line_of_sight;
        const bool blind = looks && rays < kRaysPerLook;
        if (kept < budget && !blind) {
            rays -= looks ? kRaysPerLook : 0U;
            due_[kept++] = due;
            continue;
        }
        if (due.tier == Tier::kCoarse) {
            minds.at(due.slot).next_event = due.since;
            minds.schedule(due.slot);
        }
        report_.blinded += kept < budget ? 1U : 0U;
        ++report_.postponed;
    }
    due_.resize(kept);
}

/// The grid is made only where some awake mind looks for others than players, or goes with a herd.
void Step::find_others(Minds& minds, const World& world, const Settings& settings) {
    const std::span<const Slot> awake = minds.awake();
    const bool needed = std::any_of(awake.begin(), awake.end(), [&](Slot slot) {
        return machine_of(minds.at(slot), settings).knows_others;
    });
    others_ = needed ? &world.grid() : &nobody_;
}

/// Calls work(lane, begin, end) for consecutive ranges that cover [0, count).
template <class Work>
void Step::in_lanes(compute::Team& team, std::size_t count, Work&& work) {
    if (count < kShared) {
        work(lanes_[0], std::size_t{0}, count);
        return;
    }
    const compute::Team::Shift shift(team);
    team.run(kLanes, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t lane = first; lane < last; ++lane) {
            work(lanes_[lane], count * lane / kLanes, count * (lane + 1) / kLanes);
        }
    });
}

// ---------------------------------------------------------------- doing it

void Step::decide_one(Mind& mind,
                      Due& due,
                      const World& world,
                      const Settings& settings,
                      Lane& lane) {
    const CompiledMachine& machine = machine_of(mind, settings);
    const world::Entities& e = world.entities;
    const bool awake = due.tier == Tier::kAwake;
    const Sight sight = awake ? perceive({e,
                                          world.types,
                                          *others_,
                                          world.query,
                                          world.now,
                                          world.dt,
                                          settings.far_m,
                                          &players_},
                                         due.row,
                                         mind,
                                         machine)
                              : Sight::none();
    const Vec2 body(e.position[due.row].x(), e.position[due.row].z());
    const Vec2 here = whereabouts(mind, body, world.now, world.dt);
    if (decide(mind, machine, sight, here, world.places, world.now, lane.thinking)) {
        ++lane.transitions;
        due.change = lane.thinking.change;
    }
    due.changed = mind.entered;
    if (awake) {
        mind.next_decision =
            next_decision(mind.entity, decision_period(machine, world.dt), world.now);
        if (watched_.covers(body)) {
            mind.unseen_since = kNever;
        } else if (mind.unseen_since == kNever) {
            mind.unseen_since = world.now;
        }
    }
}

/// First who goes from event to event is put where he is, then all look around.
void Step::decide_due(Minds& minds, const World& world, const Settings& settings) {
    in_lanes(world.team, due_.size(), [&](Lane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (due_[i].tier == Tier::kCoarse) {
                Mind& mind = minds.at(due_[i].slot);
                due_[i].decides = mind.next_decision <= world.now;
                catch_up(mind, coarse(world), due_[i].row);
            }
        }
    });
    in_lanes(world.team, due_.size(), [&](Lane& lane, std::size_t begin, std::size_t end) {
        lane.thinking.max_plan_nodes = settings.max_plan_nodes;
        for (std::size_t i = begin; i < end; ++i) {
            if (due_[i].decides) {
                decide_one(minds.at(due_[i].slot), due_[i], world, settings, lane);
            }
        }
    });
}

/// What minds do may ask for trades. Two that want the last loaf: the smaller id gets it, whoever
/// decided first; the other one goes on asking as long as it does what asks.
void Step::settle_trades(Minds& minds, const World& world, const Settings& settings) {
    traders_.clear();
    for (std::uint32_t i = 0; i < due_.size(); ++i) {
        Mind& mind = minds.at(due_[i].slot);
        if (due_[i].changed) {
            mind.wants = all_trades(machine_of(mind, settings).states[mind.doing]);
        }
        if (due_[i].decides && mind.wants != 0) {
            traders_.push_back(i);
        }
    }
    std::sort(traders_.begin(), traders_.end(), [this](std::uint32_t a, std::uint32_t b) {
        return due_[a].entity < due_[b].entity;
    });
    for (const std::uint32_t i : traders_) {
        Mind& mind = minds.at(due_[i].slot);
        const Vec3& position = world.entities.position[due_[i].row];
        const Vec2 body(position.x(), position.z());
        const Bargain bargain = ai::settle_trades(mind,
                                                  machine_of(mind, settings),
                                                  whereabouts(mind, body, world.now, world.dt),
                                                  world.places,
                                                  world.now);
        report_.trades += bargain.done;
        report_.trades_refused += bargain.refused;
        due_[i].changed = due_[i].changed || bargain.done > 0;
    }
}

/// Who goes to and fro: for reports alone.
void Step::watch_changes(Minds& minds, const World& world) const {
    for (const Due& due : due_) {
        if (due.change) {
            minds.watch(due.slot, *due.change, world.now, world.dt);
        }
    }
}

/// Legs of coarse minds whose event this is.
void Step::walk_coarse(Minds& minds, const World& world, const Settings& settings) {
    in_lanes(world.team, due_.size(), [&](Lane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Due& due = due_[i];
            if (due.tier != Tier::kCoarse) {
                continue;
            }
            Mind& mind = minds.at(due.slot);
            const CompiledMachine& machine = machine_of(mind, settings);
            if (walk_on(mind, machine, coarse(world), due.row, due.slot)) {
                lane.asking.push_back(due.slot);
            }
            world.entities.behaviour[due.row] = machine.states[mind.doing].behaviour;
        }
    });
}

/// Of awake minds.
void Step::give_commands(const Minds& minds, const World& world, const Settings& settings) {
    const std::span<const Slot> awake = minds.awake();
    in_lanes(world.team, awake.size(), [&](Lane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = rows_[i];
            if (row == world::kNoRow) {
                continue;
            }
            const Mind& mind = minds.at(awake[i]);
            world.entities.command[row] = mind.aim;
            world.entities.command[row].tick = world.now;
            world.entities.behaviour[row] = machine_of(mind, settings).states[mind.doing].behaviour;
        }
    });
}

/// Coarse minds whose event this was: to the next one.
void Step::go_on(Minds& minds, const World& world, const Settings& settings) {
    in_lanes(world.team, due_.size(), [&](Lane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Due& due = due_[i];
            if (due.tier == Tier::kCoarse) {
                Mind& mind = minds.at(due.slot);
                due.next_event = next_event(
                    mind, machine_of(mind, settings), coarse(world), due.decides && !due.changed);
            }
        }
    });
    for (const Due& due : due_) {
        if (due.tier == Tier::kCoarse) {
            Mind& mind = minds.at(due.slot);
            mind.next_event = due.next_event;
            minds.schedule(due.slot);
            if (!can_sleep(mind, machine_of(mind, settings))) {
                waking_.push_back(due.slot);
            }
            ++report_.events;
            report_.moved = true;
        }
        report_.decisions += due.decides ? 1U : 0U;
    }
}

/// Awake minds that have decided and that nobody can see for a while.
void Step::send_to_sleep(Minds& minds, const World& world, const Settings& settings) {
    const Tick calm = static_cast<Tick>(std::ceil(settings.calm_s / world.dt));
    for (const Due& due : due_) {
        Mind& mind = minds.at(due.slot);
        if (due.tier == Tier::kCoarse || mind.unseen_since == kNever ||
            world.now - mind.unseen_since < calm || !can_sleep(mind, machine_of(mind, settings)) ||
            !world.entities.has(due.row, world::kGrounded)) {
            continue;
        }
        const CompiledMachine& machine = machine_of(mind, settings);
        if (!mind.timed && goes_by_legs(mind, machine.states[mind.doing])) {
            continue;  // on a detour
        }
        fall_asleep(mind, machine, coarse(world), due.row);
        mind.next_event = next_event(mind, machine, coarse(world), !due.changed);
        minds.put_to_sleep(due.slot);
        minds.schedule(due.slot);
        fell_asleep_.push_back(mind.entity);
    }
    std::sort(fell_asleep_.begin(), fell_asleep_.end());
}

void Step::steer_awake(Minds& minds, const World& world, const Settings& settings) {
    const std::span<const Slot> awake = minds.awake();
    in_lanes(world.team, awake.size(), [&](Lane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const world::Row row = rows_[i];
            if (row == world::kNoRow) {
                continue;
            }
            Mind& mind = minds.at(awake[i]);
            const CompiledMachine& machine = machine_of(mind, settings);
            if (steers_now(mind, settings, world.now)) {
                Surroundings around{world.entities,
                                    world.types,
                                    *others_,
                                    world.places,
                                    row,
                                    world.now,
                                    world.dt,
                                    world.ways,
                                    awake[i]};
                around.at = whereabouts(mind, around.body(), world.now, world.dt);
                if (steer(mind, machine, around)) {
                    lane.asking.push_back(awake[i]);
                }
                ++lane.steered;
            }
        }
    });
}

void Step::add_up() {
    for (Lane& lane : lanes_) {
        report_.transitions += std::exchange(lane.transitions, 0U);
        report_.steered += std::exchange(lane.steered, 0U);
        report_.plans += std::exchange(lane.thinking.plans, 0U);
        report_.plans_cut_off += std::exchange(lane.thinking.plans_cut_off, 0U);
        report_.plans_unreachable += std::exchange(lane.thinking.plans_unreachable, 0U);
    }
}

Report Step::run(Minds& minds, const World& world, const Settings& settings) {
    report_ = Report{};
    fell_asleep_.clear();
    woke_up_.clear();
    players_.gather(world.entities);
    if (std::isfinite(settings.seen_m)) {
        follow_viewers(minds, world, settings);
        wake_seen(minds, world, settings);
    }
    collect_due(minds, world, settings);
    find_others(minds, world, settings);
    decide_due(minds, world, settings);
    settle_trades(minds, world, settings);
    watch_changes(minds, world);
    forage(minds, world, settings);
    form_up(minds, world, settings);
    steer_awake(minds, world, settings);
    walk_coarse(minds, world, settings);
    find_ways(minds, world, settings);
    give_commands(minds, world, settings);
    make_way(minds, world, settings);
    go_on(minds, world, settings);
    if (std::isfinite(settings.seen_m)) {
        send_to_sleep(minds, world, settings);
    }
    add_up();
    report_.minds = static_cast<std::uint32_t>(minds.size());
    report_.awake = static_cast<std::uint32_t>(minds.awake().size());
    return report_;
}

void Step::remember(const Memory& memory, const Minds& minds, const Settings& settings) {
    memory_ = memory;
    watched_.build(memory_.watched_from, memory_.watched_m);
    waking_.clear();
    for (std::size_t n = 0; n < minds.size(); ++n) {
        const Mind& mind = minds.at(minds.nth(n));
        if (mind.tier == Tier::kCoarse && !can_sleep(mind, machine_of(mind, settings))) {
            waking_.push_back(minds.nth(n));
        }
    }
}

void Step::hash(const Minds& minds, core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(minds.size()));
    nests_.hash(hash);
    for (const Due& due : due_) {
        // It may have gone to another zone since.
        const Mind& mind = minds.at(due.slot);
        if (mind.entity == due.entity) {
            ai::hash(hash, mind);
        }
    }
}

}  // namespace zoned::ai
