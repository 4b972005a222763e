// SubstepPolicy: sets the substeps of each island from the load on its contacts and the error
// budget.
#pragma once

#include "server/compute/team.h"
#include "server/physics/bodies/bodies.h"
#include "server/physics/contacts/contact_graph.h"
#include "server/physics/joints/joint_table.h"
#include "shared/core/containers/union_find.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace zoned::physics {

/// A contact is a spring of angular frequency w on the effective mass m of its two bodies; under a
/// force F it gives by F / (m w^2). The solver carries w = 2 pi kContactRateShare / h with substeps
/// of h, so the budget e for that give asks for
///
///     h = 2 pi kContactRateShare sqrt(m e / F).
///
/// F is the force that the contact carried in the last step: height of a stack, ratio of masses and
/// speed of an impact all show in it. A new contact is taken to carry the heavier body. Substeps
/// come in powers of two. An island takes at once as many as its contacts ask for. It goes down by
/// one power when it needed less for half a second, with joints for a tenth of one. In a large
/// island, up to one contact in 64 may ask for up to four times as many: the few chains that carry
/// a pile shall not set the pace for all of it. Counted, never timed.
///
/// A joint's error is of second order. An arm r that turns at w goes in straight lines for h, and
/// leaves its anchor by r (w h)^2 / 8. A spring that swings with w h is off by (w h)^2 / 24 in its
/// frequency. A body also swings about its centre under the force F of a joint at the arm r with w
/// = sqrt(F r / I), which has to be resolved too: a light link that holds a heavy body does so.
///
/// A small island of contacts alone is left to an exact solver if it asks for the most substeps
/// there are because its masses differ much.
///
/// Where even the most substeps do not suffice, light bodies count as heavier between contacts.
/// Bodies lighter than a thousandth of their island's heaviest count as a thousandth of it; forces
/// still move them by their true mass. Light bodies act on each other as before, as all of them
/// grow alike. On a heavy body they act as a thousandth of it would: its motion is off by at most
/// that much for each of them. Otherwise it would sink through them.
///
/// Islands with joints are solved apart from those without, because they are solved otherwise (see
/// JointSolver): whether there is a joint somewhere makes no difference to a pile elsewhere.
class SubstepPolicy {
  public:
    static constexpr std::size_t kLevels = 7;  ///< 1, 2, 4 ... 64 substeps
    static constexpr int kMostSubsteps = 1 << (kLevels - 1);
    /// No substep is longer, s: friction and rolling are first order in it.
    static constexpr float kLongestSubstep = 1.0F / 240.0F;
    /// Passes over the contacts of an island most of whose contacts are young: they have no warm
    /// start that is worth the name, and a stack sinks before its impulses have been found.
    static constexpr int kYoungIterations = 8;
    /// Where the most substeps do not suffice, a body lighter than the heaviest by more than this
    /// counts in contacts as lighter by this much.
    static constexpr float kHeaviest = 1000.0F;
    /// Islands of up to so many contacts may be left to an exact solver, whose work grows with
    /// their third power.
    static constexpr std::uint32_t kExactContacts = 12;
    /// The level of an island that is left to it.
    static constexpr std::uint8_t kExactLevel = kLevels;

    struct SubstepTargets {
        float error_m = 0.005F;    ///< give of a contact, m
        float longest_h_s = 0.0F;  ///< substeps are no longer than this
        float dt_s = 0.0F;
        float gravity_mps2 = 0.0F;
    };

    void reserve(std::size_t bodies, std::size_t contacts);

    /// Sorts the contacts by level; the order within a level stays. Bodies that share a level's
    /// contacts are in no other level, but for those that impulses do not move.
    void plan(Bodies& bodies,
              const ContactGraph& graph,
              std::span<const std::uint32_t> list,
              const JointTable& table,
              std::span<const std::uint32_t> joints,
              const SubstepTargets& budget,
              compute::Team& team);

    /// Islands that are solved alike.
    struct SubstepBatch {
        int substeps = 1;
        bool young = false;  ///< most contacts are young
        std::span<const std::uint32_t> contacts;
        std::span<const std::uint32_t> joints;
        int least_passes = 1;  ///< in each substep
    };

    static constexpr std::size_t kBatches = 4 * kLevels;

    /// Islands that want an exact solve, which are in no batch of the others.
    [[nodiscard]] std::size_t exact_count() const { return exact_.size(); }

    /// One such island, and how to solve it where there is no exact answer; i < exact_count().
    [[nodiscard]] SubstepBatch exact(std::size_t i) const {
        const ExactIsland& island = exact_[i];
        return {kMostSubsteps,
                island.young,
                std::span(exact_contacts_).subspan(island.first, island.end - island.first),
                {}};
    }

    /// Contacts and joints of islands with joints, each times its substeps.
    [[nodiscard]] std::size_t jointed_visits() const;

    /// The island of a simulated body in the last plan.
    [[nodiscard]] std::uint32_t island_of(std::uint32_t row) const { return island_[row]; }

    /// Islands of the last plan in which something asked for more than the highest level, besides
    /// those that want an exact solve.
    [[nodiscard]] std::uint32_t substep_limited() const { return substep_limited_; }

    /// Empty ones included; i < kBatches.
    [[nodiscard]] SubstepBatch batch(std::size_t i) const {
        return {1 << (i / 4),
                i % 2 != 0,
                std::span(sorted_).subspan(first_[i], first_[i + 1] - first_[i]),
                std::span(sorted_joints_)
                    .subspan(first_joint_[i], first_joint_[i + 1] - first_joint_[i])};
    }

  private:
    void join(Bodies& bodies,
              const ContactGraph& graph,
              std::span<const std::uint32_t> list,
              const JointTable& table,
              std::span<const std::uint32_t> joints);
    void settle(Bodies& bodies, float dt);
    /// Sorts `list` into `sorted` by the batch of each member's body.
    template <class RowOf>
    void sort(const Bodies& bodies,
              std::span<const std::uint32_t> list,
              RowOf&& row_of,
              std::vector<std::uint32_t>& sorted,
              std::array<std::uint32_t, kBatches + 3>& first);
    template <class RowOf>
    void list_exact(const Bodies& bodies, RowOf&& row_of);
    [[nodiscard]] static std::uint8_t level_of_joint(const Bodies& bodies,
                                                     const JointEntry& entry,
                                                     float most_force,
                                                     const SubstepTargets& budget);
    [[nodiscard]] static std::uint8_t level_for(const Bodies& bodies,
                                                const Pair& pair,
                                                const Contact& contact,
                                                const SubstepTargets& budget);

    core::UnionFind sets_;

    struct IslandNeeds {
        std::array<std::uint32_t, kLevels> level{};  // contacts of an island by level
        std::uint32_t young = 0;
        float least_inv_mass = std::numeric_limits<float>::infinity();
        float most_inv_mass = 0.0F;
        bool jointed = false;
        bool rolls_stiffly = false;  // the exact solver knows no rolling friction
        bool substep_limited = false;

        [[nodiscard]] bool fit_for_exact() const;
        [[nodiscard]] bool mostly_young() const;
        /// See Bodies::inv_mass_scale; `held`: the level that the island has.
        [[nodiscard]] float inv_mass_scale_of(float inv_mass, std::uint8_t held) const;

        void note_mass(float inv_mass) {
            least_inv_mass = std::min(least_inv_mass, inv_mass);
            most_inv_mass = std::max(most_inv_mass, inv_mass);
        }

        /// Levels from kLevels on stand for more than there is.
        void ask(std::uint8_t wanted) {
            substep_limited |= wanted >= kLevels;
            ++level[wanted < kLevels ? wanted : kLevels - 1];
        }
    };

    std::uint32_t substep_limited_ = 0;

    std::vector<std::uint32_t> island_;   // by row
    std::vector<IslandNeeds> needs_;      // by place in the list of bodies: of its island's root
    std::vector<std::uint8_t> held_;      // the level that it had
    std::vector<std::uint8_t> patience_;  // steps until it may go down
    std::vector<std::uint8_t> level_;     // that a contact asks for, by place in the list
    std::vector<std::uint8_t> batch_;     // by place in the list of contacts
    std::vector<std::uint32_t> sorted_;
    std::array<std::uint32_t, kBatches + 3> first_{};  // the last one: those solved exactly
    std::vector<std::uint32_t> sorted_joints_;
    std::array<std::uint32_t, kBatches + 3> first_joint_{};

    struct ExactIsland {
        std::uint32_t first = 0, end = 0;  // in exact_contacts_
        bool young = false;
    };

    std::vector<std::uint64_t> exact_keys_;  // island and place in `sorted_`
    std::vector<std::uint32_t> exact_contacts_;
    std::vector<ExactIsland> exact_;
};

}  // namespace zoned::physics
