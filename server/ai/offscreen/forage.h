// Forage: creatures that look for food around a nest, and find the shortest path by pheromones.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/ai_context.h"
#include "server/ai/pathfinding/grid/door_cells.h"
#include "server/ai/steering/forage_walk.h"
#include "server/world/entities.h"
#include "shared/motion/static_geometry.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace zoned::ai {

/// An agent that forages.
struct Forager {
    EntityId entity;
    world::Row row = world::kNoRow;
    Slot slot = 0;
};

/// The nests of a zone. Each nest has a map of the ground around it, and the pheromones on that
/// map. A map is baked when an agent first forages there, and follows doors as they move.
///
/// Creatures walk from the middle of one cell to the middle of the next by a timetable
/// (path_segment.h). They smell and mark at the ends of these segments, in the order of ticks and
/// then of entities. So the result is the same on screen and off screen.
///
/// A creature's position on its path is part of its agent (`corner`, `target`, `steps`), and goes
/// with it to another zone. There it walks straight home. Pheromones stay, and are part of the
/// zone's state.
class Nests {
  public:
    void clear() { foragers_.clear(); }

    /// Adds an agent, in any order. Each simulated body is added, and each suspended agent that has
    /// come to the end of a segment.
    void add(const Forager& forager) { foragers_.push_back(forager); }

    /// Lets each agent that has come to a cell mark it and choose the next. Writes `target`, and
    /// ends the segment of an agent whose target has changed.
    void step(const AiContext& ai);

    /// True where a door has changed the ground of a nest in the last step. In this step all agents
    /// that forage check whether it has shut in front of them.
    [[nodiscard]] bool turned() const { return turned_; }

    /// The saved state of a nest. Its map is baked anew.
    struct Scents {
        std::uint16_t brain = 0;  ///< some brain and action that say where the nest is
        std::uint16_t current_action = 0;
        TypeIndex type = 0;  ///< the type of creature that its map is for
        std::vector<pathfinding::ScentCell> cells{};
    };

    /// Saved state of all nests, in the order in which they were first used.
    struct SavedNests {
        std::uint64_t delivered = 0;
        bool turned = false;
        std::vector<Scents> nests{};
    };

    [[nodiscard]] SavedNests save() const;

    /// Replaces everything. The next step bakes the maps. It forgets a nest that is not in this
    /// zone, and a cell that is not on its map.
    void load(const SavedNests& memory);

    /// Food brought home so far.
    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

    [[nodiscard]] std::size_t size() const { return nests_.size(); }

    /// The pheromones of a nest, numbered in the order of first use; for snapshots and pictures.
    [[nodiscard]] const pathfinding::PheromoneTrails& trails(std::size_t nest) const {
        return nests_[nest]->trails;
    }

    [[nodiscard]] const pathfinding::GroundMap& ground(std::size_t nest) const {
        return nests_[nest]->ground;
    }

    void hash(core::StateHash& hash) const;

  private:
    struct Nest {
        std::uint16_t place;
        std::uint16_t brain = 0;
        std::uint16_t current_action = 0;
        TypeIndex type = 0;
        const ForageDef* def;
        pathfinding::GroundMap ground;
        pathfinding::DoorMap doors;
        pathfinding::PheromoneTrails trails;

        Nest(const ForageDef& from, pathfinding::GroundMap&& map, pathfinding::DoorMap&& door_map)
            : place(from.nest),
              def(&from),
              ground(std::move(map)),
              doors(std::move(door_map)),
              trails(ground.cells, from.trails) {}
    };

    Nest* nest_of(const Scents& key, const AiContext& ai);
    void restore(const AiContext& ai);
    void follow_doors(Nest& nest, const motion::StaticGeometry& statics, Tick now);
    void take_turn(Agent& agent, const Forager& forager, const AiContext& ai);
    void walk(Agent& agent, Nest& nest, const Vec2& at, bool arrived, const AiContext& ai);
    void arrive(Agent& agent, Nest& nest, const Vec2& at, const AiContext& ai);
    void choose(Agent& agent, Nest& nest, const Vec2& at);

    std::vector<Forager> foragers_;
    std::vector<std::unique_ptr<Nest>> nests_;
    std::vector<pathfinding::CellChange> changes_;
    std::vector<Scents> remembered_;  // until their maps are baked
    std::uint64_t delivered_ = 0;
    bool turned_ = false;
};

}  // namespace zoned::ai
