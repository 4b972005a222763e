#include "server/ai/offscreen/forage.h"

#include "server/ai/agent/ai_settings.h"
#include "server/ai/steering/path_following.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// An agent this far from its target counts as led astray, in cells.
constexpr float kAstrayCells = 2.5F;
constexpr std::uint8_t kDirectionBits = 0x07;

pathfinding::Spot place_of_target(const Vec2& at) {
    return {at.x(), at.y()};
}

void turn_back(Agent& agent) {
    agent.corner ^= pathfinding::kDirections / 2;
    agent.steps = 0;
}

void set_out(Agent& agent, const ForageDef& def) {
    agent.corner &= static_cast<std::uint8_t>(~(kScouts | kLost | kBegins));
    agent.corner |= agent.rng.unit() < def.explore ? kScouts : 0;
    agent.steps = 0;
}

void aim_at(Agent& agent, const Vec2& at) {
    agent.target = Vec3(at.x(), agent.target.y(), at.y());
}

/// Ends the agent's segment. Steering or the off-screen update then makes one to its new target.
void end_segment(Agent& agent, Tick now) {
    agent.segment.length = 0.0F;
    agent.again_at = now;
    agent.next_steering = now;
}

/// Whether pheromones guide the agent. They do not guide scouts. They guide an agent that has been
/// walking for long only half of the time, since old pheromones may lead to a path that is gone.
bool is_guided(const Agent& agent, const ForageDef& def) {
    const bool scouts = (agent.corner & (kCarries | kScouts)) == kScouts;
    return !scouts && (agent.steps / def.trails.patience) % 2 == 0;
}

bool finds_food(const ForageDef& def, const PointsOfInterest& points_of_interest, const Vec2& at) {
    return std::any_of(def.food.begin(), def.food.end(), [&](std::uint16_t place) {
        return points_of_interest.outside(place, at) <= 0.0F;
    });
}

}  // namespace

/// Null where the nest lies in another zone.
Nests::Nest* Nests::nest_of(const Scents& key, const AiContext& ai) {
    const ForageDef& def = *ai.settings.compiled[key.brain].states[key.current_action].forage;
    for (const auto& nest : nests_) {
        if (nest->place == def.nest) {
            nest->def = &def;
            return nest.get();
        }
    }
    const Vec2 centre = ai.points_of_interest.centre(def.nest);
    if (std::abs(centre.x()) > ai.half_size.x() || std::abs(centre.y()) > ai.half_size.y()) {
        return nullptr;
    }
    const pathfinding::GroundRect area{centre.x() - def.radius_m,
                                       centre.y() - def.radius_m,
                                       centre.x() + def.radius_m,
                                       centre.y() + def.radius_m};
    const motion::CharacterLimits& limits = ai.types[key.type].character;
    pathfinding::GroundMap ground = pathfinding::bake_ground(ai.statics, limits, area, def.cell_m);
    pathfinding::DoorMap doors(
        pathfinding::bake_doors(ai.statics, limits, area, def.cell_m, ground), ground.cells);
    nests_.push_back(std::make_unique<Nest>(def, std::move(ground), std::move(doors)));
    Nest& nest = *nests_.back();
    nest.brain = key.brain;
    nest.current_action = key.current_action;
    nest.type = key.type;
    return &nest;
}

Nests::SavedNests Nests::save() const {
    SavedNests memory{delivered_, turned_, {}};
    for (const auto& nest : nests_) {
        Scents scents{nest->brain, nest->current_action, nest->type, {}};
        nest->trails.for_each_scent(
            [&scents](const pathfinding::ScentCell& cell) { scents.cells.push_back(cell); });
        memory.nests.push_back(std::move(scents));
    }
    memory.nests.insert(memory.nests.end(), remembered_.begin(), remembered_.end());
    return memory;
}

void Nests::load(const SavedNests& memory) {
    nests_.clear();
    delivered_ = memory.delivered;
    turned_ = memory.turned;
    remembered_ = memory.nests;
}

/// Doors are as they were at the end of the last step.
void Nests::restore(const AiContext& ai) {
    const bool turned = turned_;
    for (const Scents& scents : remembered_) {
        Nest* const nest = scents.type < ai.types.size() ? nest_of(scents, ai) : nullptr;
        if (nest == nullptr) {
            continue;
        }
        follow_doors(*nest, ai.statics, ai.now - 1);
        for (const pathfinding::ScentCell& cell : scents.cells) {
            nest->trails.put_scent(cell);
        }
    }
    remembered_.clear();
    turned_ = turned;
}

void Nests::follow_doors(Nest& nest, const motion::StaticGeometry& statics, Tick now) {
    changes_.clear();
    for (std::uint32_t door = 0; door < nest.doors.doors(); ++door) {
        nest.doors.turn(door, statics.shut_at(door, now), changes_);
    }
    for (const pathfinding::CellChange& change : changes_) {
        nest.ground.cells.set_passable(change.cell, change.passable);
    }
    turned_ = turned_ || !changes_.empty();
}

/// Sends the agent on to a neighbour of its cell, or to the nearest cell that can be walked.
void Nests::choose(Agent& agent, Nest& nest, const Vec2& at) {
    const pathfinding::GroundGrid& grid = nest.ground.grid;
    const pathfinding::Cell here = grid.cell(place_of_target(at));
    if (!nest.ground.cells.passable(here)) {
        pathfinding::Cell near;
        if (pathfinding::nearest_passable(nest.ground.cells, grid, place_of_target(at), 4, near)) {
            const pathfinding::Spot to = grid.centre(near);
            aim_at(agent, Vec2(to.x, to.z));
        } else {
            agent.corner |= kLost;
        }
        return;
    }
    const bool carries = (agent.corner & kCarries) != 0;
    const pathfinding::Place place = nest.ground.cells.place(here);
    const unsigned direction = nest.trails.choose(place,
                                                  agent.corner & kDirectionBits,
                                                  carries ? pathfinding::kHome : pathfinding::kFood,
                                                  is_guided(agent, *nest.def),
                                                  agent.rng);
    if (direction >= pathfinding::kDirections) {
        aim_at(agent, at);  // it waits
        return;
    }
    agent.corner = static_cast<std::uint8_t>((agent.corner & ~kDirectionBits) | direction);
    const pathfinding::Spot to =
        grid.centre(nest.ground.cells.cell(nest.trails.beside(place, direction)));
    aim_at(agent, Vec2(to.x, to.z));
}

/// Handles an agent in the middle of a cell: it marks the cell, takes food or brings it home, and
/// goes on.
void Nests::arrive(Agent& agent, Nest& nest, const Vec2& at, const AiContext& ai) {
    const ForageDef& def = *nest.def;
    const pathfinding::Cell here = nest.ground.grid.cell(place_of_target(at));
    agent.steps = static_cast<std::uint16_t>(std::min<std::uint32_t>(agent.steps + 1U, 0xFFFFU));
    const bool carries = (agent.corner & kCarries) != 0;
    if (nest.ground.cells.passable(here)) {
        nest.trails.mark(carries ? pathfinding::kFood : pathfinding::kHome,
                         nest.ground.cells.place(here),
                         agent.steps);
    }
    if (!carries && finds_food(def, ai.points_of_interest, at)) {
        agent.corner |= kCarries;
        turn_back(agent);
    } else if ((carries || agent.steps > 1) &&
               ai.points_of_interest.outside(def.nest, at) <= 0.0F) {
        delivered_ += carries ? 1U : 0U;
        agent.corner &= static_cast<std::uint8_t>(~kCarries);
        turn_back(agent);
        set_out(agent, def);
    }
    choose(agent, nest, at);
}

void Nests::walk(Agent& agent, Nest& nest, const Vec2& at, bool arrived, const AiContext& ai) {
    const float cell_m = nest.ground.grid.cell_m();
    const Vec2 target(agent.target.x(), agent.target.z());
    if ((agent.corner & kLost) != 0) {
        if (ai.points_of_interest.outside(nest.place, at) > 0.0F) {
            aim_at(agent, ai.points_of_interest.centre(nest.place));
            return;
        }
        agent.corner &= static_cast<std::uint8_t>(~kCarries);
        set_out(agent, *nest.def);
        choose(agent, nest, at);
    } else if ((agent.corner & kBegins) != 0) {
        agent.corner = static_cast<std::uint8_t>(agent.rng.below(pathfinding::kDirections));
        set_out(agent, *nest.def);
        choose(agent, nest, at);
    } else if (!nest.ground.grid.contains(place_of_target(at))) {
        agent.corner |= kLost;
        aim_at(agent, ai.points_of_interest.centre(nest.place));
    } else if (arrived) {
        arrive(agent, nest, at, ai);
    } else if ((target - at).norm() > kAstrayCells * cell_m ||
               !nest.ground.cells.passable(nest.ground.grid.cell(place_of_target(target)))) {
        // The agent was pushed away, or a door has shut in front of it.
        choose(agent, nest, at);
    }
}

/// An agent on a segment does nothing, unless doors have moved.
void Nests::take_turn(Agent& agent, const Forager& forager, const AiContext& ai) {
    const ForageDef& def = *ai.settings.compiled[agent.brain].states[agent.current_action].forage;
    const Vec3& position = ai.entities.position[forager.row];
    const Vec2 body(position.x(), position.z());
    const bool by_segment = keeps_to_segment(agent, body, ai.now, ai.dt);
    const bool over = by_segment && segment_is_over(agent, ai.now, ai.dt);
    if (by_segment && !over && !turned_) {
        return;
    }
    const Vec2 at = whereabouts(agent, body, ai.now, ai.dt);
    const Vec2 target(agent.target.x(), agent.target.z());
    const Scents key{agent.brain, agent.current_action, ai.entities.type[forager.row], {}};
    if (Nest* const nest = nest_of(key, ai)) {
        const bool near = (target - at).norm() < kAtCell * nest->ground.grid.cell_m();
        walk(agent, *nest, at, by_segment ? over : near, ai);
    } else {
        agent.corner |= kLost;
        aim_at(agent, ai.points_of_interest.centre(def.nest));
    }
    if (by_segment && target != Vec2(agent.target.x(), agent.target.z())) {
        end_segment(agent, ai.now);
    }
}

void Nests::step(const AiContext& ai) {
    std::sort(foragers_.begin(), foragers_.end(), [](const Forager& a, const Forager& b) {
        return a.entity < b.entity;
    });
    restore(ai);
    for (const Forager& forager : foragers_) {
        take_turn(ai.agents.at(forager.slot), forager, ai);
    }
    turned_ = false;
    const auto second = std::max<Tick>(1, std::lround(1.0F / ai.dt));
    for (const auto& nest : nests_) {
        follow_doors(*nest, ai.statics, ai.now);
        if (ai.now % second == 0) {
            nest->trails.evaporate();
        }
    }
}

void Nests::hash(core::StateHash& hash) const {
    hash.add(delivered_);
    for (const auto& nest : nests_) {
        nest->trails.hash(hash);
    }
}

}  // namespace zoned::ai
