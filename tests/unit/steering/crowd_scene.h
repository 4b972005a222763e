// CrowdScene: scenes of crowds, and outside checks of them: overlaps and crossed walls.
#pragma once

#include "server/ai/crowd/orca_avoidance.h"
#include "shared/core/rng.h"

#include <cstddef>
#include <vector>

namespace zoned::ai::steering {

struct CrowdScene {
    CrowdAgents agents;
    std::vector<Wall> walls;
};

/// Up to `count` agents of several sizes that do not overlap, in a closed square of `side` (m) with
/// a tenth as many walls in it, some of them closed triangles.
CrowdScene random_scene(core::Rng& rng, std::size_t count, float side);

/// The largest overlap of two agents over the smaller radius; 0 for none. All pairs, in doubles.
float largest_overlap_share(const CrowdAgents& agents);

/// How deep an agent is in a wall, over its radius.
float deepest_in_wall_share(const CrowdScene& scene);

/// Agents whose centre has crossed a wall.
std::size_t crossings(const CrowdAgents& before,
                      const CrowdAgents& after,
                      const std::vector<Wall>& walls);

/// Agents that walk to their goals and then leave.
class WalkingScene {
  public:
    virtual ~WalkingScene() = default;

    /// Steps until all agents are through, or `most` steps; returns the number.
    int run(int most);

    [[nodiscard]] std::size_t left() const { return scene.agents.size(); }

    CrowdScene scene;
    float worst_overlap = 0.0F;
    std::size_t crossed_walls = 0;

  protected:
    /// Writes the desired velocity of row i; false: it is through.
    virtual bool aim(std::size_t i) = 0;
};

/// Half of the agents walk along x to the right, half to the left.
class CorridorScene final : public WalkingScene {
  public:
    CorridorScene(std::size_t count, float length, float width, std::uint64_t seed);

  private:
    bool aim(std::size_t i) override;
    float length_;
};

/// All walk through a door in a wall at x = 0, from the left.
class DoorScene final : public WalkingScene {
  public:
    DoorScene(std::size_t count, float width, std::uint64_t seed);

  private:
    bool aim(std::size_t i) override;
    float width_;
};

}  // namespace zoned::ai::steering
