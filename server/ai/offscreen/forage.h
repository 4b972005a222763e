// Forage: creatures that look for food around a nest, and find the shortest path by scents.
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

/// The nests of a zone: a map of the ground around each, baked when somebody first forages there,
/// as it is while doors turn, and the scents on it. Creatures walk from the middle of a cell to
/// that of the next by a timetable (walk.h), and what they smell and mark happens at the ends of
/// these segments, in the order of ticks and then of entities: the same whether somebody sees them
/// or not. Where they are on their path is part of their agents (`corner`, `target`, `steps`), and
/// goes with them to another zone: from there they walk straight home. Scents stay, and are part of
/// the zone's state.
class Nests {
  public:
    void clear() { foragers_.clear(); }

    /// In any order: all whose bodies are simulated, and of the others those who have come to the
    /// end of a segment.
    void add(const Forager& forager) { foragers_.push_back(forager); }

    /// Lets those who have come to a cell mark it and choose the next: writes `target`, and ends
    /// the segment of whoever has another one.
    void step(const AiContext& ai);

    /// A door has changed the ground of a nest in the last step: all who forage have to look, in
    /// this one, whether it has shut before them.
    [[nodiscard]] bool turned() const { return turned_; }

    /// What is known of a nest beside its map, which is baked anew.
    struct Scents {
        struct ScentCell {
            pathfinding::Place place = 0;
            float home = 0.0F;
            float food = 0.0F;
        };

        std::uint16_t brain = 0;  ///< some brain and what it does say where the nest is
        std::uint16_t current_action = 0;
        TypeIndex type = 0;  ///< of the creatures that its map is for
        std::vector<ScentCell> cells{};
    };

    /// For snapshots: nests in the order in which they were first used.
    struct SavedNests {
        std::uint64_t delivered = 0;
        bool turned = false;
        std::vector<Scents> nests{};
    };

    [[nodiscard]] SavedNests save() const;

    /// Replaces everything. Maps are baked in the next step; what then is no nest of this zone, or
    /// no cell of its map, is forgotten.
    void load(const SavedNests& memory);

    /// All that was brought home so far.
    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

    [[nodiscard]] std::size_t size() const { return nests_.size(); }

    /// The scents of a nest, in the order in which nests were first used; for snapshots and
    /// pictures.
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
