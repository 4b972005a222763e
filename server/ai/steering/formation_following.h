// FormationFollowing: agents that keep their slots around a captain.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/crowd/assignment.h"
#include "server/ai/steering/desired_velocity.h"
#include "shared/motion/static_geometry.h"

#include <span>
#include <vector>

namespace zoned::ai {

/// The contents of Agent::corner while it is in formation: its slot, and whether it straggles.
inline constexpr std::uint8_t kNoRank = 0x7F;
inline constexpr std::uint8_t kStraggles = 0x80;

/// Rank: an agent in formation around its ward.
struct Rank {
    EntityId captain;
    EntityId entity;
    world::Row captain_row = world::kNoRow;
    world::Row row = world::kNoRow;
    Slot slot = 0;
};

/// The members of all formations of a zone. This class has no memory: the slots are part of the
/// agents. Slots are assigned anew, by the least sum of squared distances, when the slots of a
/// captain's members are not the first so many. Near a border the captain or some members may be
/// ghosts of another zone. Then both zones keep the slots from the time when the formation was
/// together. They do so while at least as many ghosts could be members as members are missing.
class Formations {
  public:
    void clear() { ranks_.clear(); }

    /// Adds an agent whose state is a formation; its ward is present.
    void add(const Rank& rank) { ranks_.push_back(rank); }

    [[nodiscard]] bool empty() const { return ranks_.empty(); }

    /// Gives each member its slot, writes the slot's present position into `target`, and marks the
    /// stragglers.
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

/// True: the agent walks to its place by itself, as to any goal.
inline bool straggles(const Agent& agent) {
    return (agent.corner & kStraggles) != 0;
}

/// Steers a member that is in its place: with the captain, and towards its slot.
void steer_in_formation(Agent& agent,
                        const BrainState& state,
                        bool entered,
                        const Surroundings& around);

}  // namespace zoned::ai
