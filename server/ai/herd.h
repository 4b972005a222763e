// Herd: animals of a herd that nobody sees go on by the rule of the flock, a second at a time.
#pragma once

#include "server/ai/coarse.h"
#include "server/ai/minds.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Whether the mind goes with a herd.
inline bool roams(const Mind& mind, const CompiledMachine& machine) {
    return machine.states[mind.doing].action == ActionKind::kFlock;
}

/// The fastest that one walks who roams so, m/s.
float roam_speed(const State& state, const motion::CharacterLimits& limits);

/// The way of its last step, m: so far it may have come from where its entity was put.
inline float step_of(const Mind& mind) {
    return (mind.leg.goal - mind.leg.from).norm();
}

/// Where those neighbours are whom nobody sees: their rows say where they were put last, their
/// minds where they are now.
struct Drift {
    const Minds& minds;
    std::span<const Slot> slots;  ///< by row: of whoever dozes there; others may be in the way
    Tick now;
    float dt;       ///< s
    float reach_m;  ///< nobody is farther than this from its row

    /// Of a row that dozes; null: it has no mind here.
    [[nodiscard]] const Leg* leg_of(const world::Entities& entities, world::Row row) const;
};

/// Whether the mind is on a step with its herd: no other leg leads on without an end.
inline bool on_step(const Mind& mind) {
    return mind.tier == Tier::kCoarse && mind.leg.length == 0.0F && mind.leg.speed > 0.0F;
}

/// Where such a one is that is at `at` (x, z, m) now, and whose entity was put at `body`: at the
/// end of the step where roam() has found that it will stand (mind.target), before that on the line
/// there.
Vec3 place_on_step(const Mind& mind, const Vec3& body, const Vec2& at);

/// Whether it is time for a step.
inline bool roams_on(const Mind& mind, const CompiledMachine& machine, Tick now) {
    return roams(mind, machine) && (mind.entered || now >= mind.again_at);
}

/// Until when a step leads that begins now: a tick that is a multiple of a second, or of the
/// decisions of the machine where these are rarer, so that all animals of a kind begin the next one
/// together.
Tick roams_until(const CompiledMachine& machine, Tick now, float dt);

/// The step of an animal whose entity is where it is, which catch_up() sees to, along `way` (x, z,
/// m) until roams_until(): as a character moves that is simulated, so along walls, over ledges, up
/// and down the ground (motion::apply_input). False: it would leave the ground; it stands where it
/// is, and is to be woken up. Where it comes to stand is mind.target.
bool roam(Mind& mind,
          const CompiledMachine& machine,
          const CoarseWorld& in,
          world::Row row,
          const Vec2& way);

/// The way that it goes until then where nothing changes its heading, x, z, m.
Vec2 way_ahead(const Mind& mind,
               const CompiledMachine& machine,
               const CoarseWorld& in,
               world::Row row);

/// Herds for a step: who looks at whom is found once, then the rule is asked at the very ticks at
/// which a simulated animal would decide and steer, by where all of them are then (Verlet,
/// "Computer experiments on classical fluids I", Physical Review 159, 1967, section 4, for the
/// lists). In between they walk straight. Animals of the herd that are simulated are foretold by
/// the same rule. What is left out until the step is over is what they walk into, and that others
/// turn.
class Herds {
  public:
    struct Scene {
        const world::Entities& entities;
        const world::TypeTable& types;
        const spatial::PointGrid& grid;
        const Places& places;
        const std::vector<CompiledMachine>& machines;
        const Drift& drift;
        bool reduce_far;  ///< those far from players steer every kFarPeriod ticks
        Tick now;
        float dt;  ///< s
    };

    void clear() { roaming_.clear(); }

    /// In any order.
    void add(Slot slot, world::Row row) { roaming_.push_back({slot, row}); }

    [[nodiscard]] bool empty() const { return roaming_.empty(); }

    /// Sets their aims as they are at the end of their steps.
    void step(Minds& minds, const Scene& scene);

    /// The way of the n-th that was added, x, z, m.
    [[nodiscard]] const Vec2& way(std::size_t n) const { return way_[n]; }

  private:
    struct Roaming {
        Slot slot;
        world::Row row;
    };

    void gather(const Minds& minds, const Scene& scene);
    std::uint32_t add_animal(const Mind* mind, world::Row row, const Scene& scene);
    std::uint32_t place_of(const Minds& minds, world::Row row, const Scene& scene);
    void see(const Minds& minds, std::size_t n, const Scene& scene);
    void turn_all(Minds& minds, const Scene& scene, Tick now);
    void turn(Minds& minds, std::size_t n, const Scene& scene, Tick now);
    void walk_until(std::size_t n, Tick end, float dt);
    void leave(Minds& minds, std::size_t n, Tick now, float dt);

    std::vector<Roaming> roaming_;
    // By animal: those who step, then others whom they see.
    std::vector<world::Row> row_;
    std::vector<EntityId> entity_;
    std::vector<const Mind*> mind_;  // null: it goes straight on
    std::vector<Vec2> from_;
    std::vector<Vec2> at_;  // at the end of tick since_
    std::vector<Tick> since_;
    std::vector<Vec2> velocity_;  // since then, m/s
    std::vector<motion::InputCommand> aim_;
    std::vector<Tick> turns_at_;        // kNever: it goes straight on
    std::vector<Vec2> wanted_;          // velocity after a turn
    std::vector<std::uint32_t> first_;  // of sees_
    std::vector<std::uint32_t> sees_;
    std::vector<std::uint32_t> place_of_row_;
    std::vector<Vec2> way_;  // of those who step
};

}  // namespace zoned::ai
