// FormationFollowing: agents that keep their slots around a captain.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/steering/desired_velocity.h"
#include "server/ai/crowd/assignment.h"
#include "shared/motion/static_geometry.h"

#include <span>
#include <vector>

namespace zoned::ai {

/// What an agent keeps in `corner` while it forms up: its slot, and whether it straggles.
inline constexpr std::uint8_t kNoRank = 0x7F;
inline constexpr std::uint8_t kStraggles = 0x80;

/// An agent that forms up around its ward.
struct Rank {
    EntityId captain;
    EntityId entity;
    world::Row captain_row = world::kNoRow;
    world::Row row = world::kNoRow;
    Slot slot = 0;
};

/// The members of all formations of a zone. Nothing is remembered here: slots are part of the
/// agents, and given anew, by the least sum of squared paths, when those of a captain's members are
/// not the first so many. On a border, where some of them, or the captain, are ghosts of another
/// zone, both keep to the slots that they had when they were together: as long as there are as many
/// ghosts who may be those that are missing.
class Formations {
  public:
    void clear() { ranks_.clear(); }

    /// An agent whose state forms up; its ward is there.
    void add(const Rank& rank) { ranks_.push_back(rank); }

    [[nodiscard]] bool empty() const { return ranks_.empty(); }

    /// Gives each its slot, writes where that is now into `target`, and says who straggles.
    void place(AgentStore& agents,
               const world::Entities& entities,
               const world::TypeTable& types,
               std::span<const CompiledBrain> brains,
               const steering::Walls& walls,
               Tick now);

  private:
    struct Group;

    void give_slots(AgentStore& agents, const world::Entities& entities, const Group& group);
    template <class Ghosts>
    [[nodiscard]] static std::size_t company_of(std::span<const Rank> ranks,
                                                const AgentStore& agents,
                                                Ghosts&& ghosts);

    std::vector<Rank> ranks_;
    std::vector<double> cost_;
    std::vector<std::uint8_t> taken_;
    steering::Assignment assignment_;
};

/// Whether the agent walks to its place by itself, as to any goal.
inline bool straggles(const Agent& agent) {
    return (agent.corner & kStraggles) != 0;
}

/// Steers a member in its place: with the captain, and to its slot.
void steer_in_formation(Agent& agent,
                        const BrainState& state,
                        bool entered,
                        const Surroundings& around);

}  // namespace zoned::ai
