// TornIslands: finds the islands whose joints a solve tore, and puts them back to solve them again.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/contacts/contact_graph.h"
#include "server/physics/joints/joint_table.h"
#include "server/physics/solver/substep_policy.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// A body as it was before the solve of a step.
struct StepStart {
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();
    Vec3 spin = Vec3::Zero();
};

/// SubstepPolicy foresees the substeps of an island from its last step. A blow within the step may
/// ask for more: joints open, or bodies gain energy from what undoes the error. The island is then
/// solved again from where the step began, with twice the substeps, then with twice the passes in
/// each, until it holds together, more changes nothing, or there are no more. Counted, never timed:
/// all repeats of a step visit no more contacts and joints than kLeastVisits or twice its first
/// solve.
class TornIslands {
  public:
    void reserve(std::size_t bodies, std::size_t contacts);

    /// Beyond these an island is torn.
    struct TearLimits {
        float gap_m = 0.005F;  ///< a joint opens no further
        float dt_s = 0.0F;
        Vec3 gravity = Vec3::Zero();  ///< m/s2
    };

    /// The scene that is solved. `starts` is by row.
    struct StepView {
        Bodies& bodies;
        ContactGraph& graph;
        JointTable& table;
        const SubstepPolicy& islands;
        std::span<const StepStart> starts;
    };

    /// Begins a step of so many visits: contacts and joints times their substeps.
    void begin_step(std::size_t visits, const TearLimits& limits);

    /// Remembers what a solve of the batch changes besides the bodies.
    void note(const StepView& view, const SubstepPolicy::SubstepBatch& batch);

    /// Puts the islands back that the solve with half of `sweeps` tore, and lists them for one with
    /// `sweeps`: substeps times passes. Torn are also those of the bodies that `passed` a surface.
    /// Bodies that it stopped leave `broken`. False: there are none.
    bool take_back(const StepView& view,
                   int sweeps,
                   std::span<const std::uint32_t> passed,
                   std::vector<std::uint32_t>& broken);

    /// After the last repeat: the islands which are no better for the repeats, put back to be
    /// solved as at first.
    bool take_back_hopeless(const StepView& view, std::vector<std::uint32_t>& broken);

    /// Simulated bodies of the noted batch.
    [[nodiscard]] std::span<const std::uint32_t> rows() const { return rows_; }

    /// A further contact between bodies of the batch, from its next repeat on.
    void add(std::uint32_t index, const Contact& contact) {
        noted_contacts_.push_back({index, contact});
    }

    /// Puts the islands of these bodies back to solve them again with as many substeps. False:
    /// there are no visits left for any of them.
    bool take_back_of(const StepView& view,
                      std::span<const std::uint32_t> rows,
                      int substeps,
                      std::vector<std::uint32_t>& broken);

    /// After all repeats: takes the gain of energy that is left out of the motion of the islands
    /// that something fixed holds. One factor for all velocities leaves joints and contacts as
    /// satisfied as they are (D. Dinev and others, "FEPR: fast energy projection for real-time
    /// simulation of deformable objects", ACM Transactions on Graphics 37(4), 2018).
    void take_out_gain(const StepView& view);

    [[nodiscard]] std::span<const std::uint32_t> contacts() const { return contacts_; }

    [[nodiscard]] std::span<const std::uint32_t> joints() const { return joints_; }

    /// Islands of this step that stayed torn.
    [[nodiscard]] std::uint32_t given_up() const { return given_up_; }

  private:
    struct NotedContact {
        std::uint32_t index = 0;
        Contact contact;
    };

    struct NotedJoint {
        std::uint32_t index = 0;
        JointState state;
        float gap = 0.0F;     ///< m
        float stored = 0.0F;  ///< J
    };

    struct TornIsland {
        std::uint32_t island = 0;
        float gap = 0.0F;        ///< of the joint that is open most, m
        std::size_t visits = 0;  ///< in one substep
        float over = 0.0F;       ///< energy gained beyond what is allowed, J
    };

    /// Change of energy in the step.
    struct IslandEnergy {
        float gain = 0.0F;
        float allowed = 0.0F;
        float motion = 0.0F;  ///< energy of motion after the step
        bool driven = false;  ///< by movers or forces: it may gain
        bool held = false;    ///< by something that impulses do not move

        /// Gained beyond what is allowed.
        [[nodiscard]] float over() const { return driven ? 0.0F : gain - allowed; }
    };

    void list_rows(const StepView& view);
    void judge(const StepView& view,
               std::span<const std::uint32_t> passed,
               std::span<const std::uint32_t> broken);
    void weigh(const StepView& view);
    static void sort_islands(std::vector<TornIsland>& some);
    void drop_hopeless();
    void keep_affordable(const StepView& view, int substeps);
    void put_back(const StepView& view,
                  std::span<const TornIsland> which,
                  std::vector<std::uint32_t>& broken);
    [[nodiscard]] static const TornIsland* find(std::span<const TornIsland> some,
                                                std::uint32_t island);

    TearLimits limits_;
    float opening_m_ = 0.0F;  ///< a joint that was open already opens no further than by this
    std::size_t visits_left_ = 0;
    std::uint32_t given_up_ = 0;
    std::vector<NotedContact> noted_contacts_;
    std::vector<NotedJoint> noted_joints_;
    std::vector<std::uint32_t> rows_;   // simulated bodies of the batch
    std::vector<std::uint8_t> listed_;  // by row; zero between calls
    std::vector<IslandEnergy> energy_;  // by island
    std::vector<TornIsland> torn_;      // now, by island
    std::vector<TornIsland> last_;      // before the last repeat
    std::vector<TornIsland> hopeless_;
    std::vector<std::uint32_t> contacts_;
    std::vector<std::uint32_t> joints_;
};

}  // namespace zoned::physics
