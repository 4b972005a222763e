// ContactSolver: substepped sequential impulses with soft contacts, warm starting and friction,
// eight contacts at a time.
#pragma once

#include "server/compute/team.h"
#include "server/physics/bodies/bodies.h"
#include "server/physics/bodies/solver_bodies.h"
#include "server/physics/contacts/contact_graph.h"
#include "server/physics/joints/joint_solver.h"
#include "server/physics/simd/contact_batch.h"
#include "server/physics/simd/lane_body.h"
#include "server/physics/solver/contact_coloring.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace zoned::physics {

/// Contacts are springs whose frequency is this share of the substep rate. More cannot be carried
/// by one pass over the contacts: at a quarter, a pyramid of twenty rows trembles and walks.
inline constexpr float kContactRateShare = 0.125F;
/// The time of an impact that does not come, s.
inline constexpr float kNoImpact = std::numeric_limits<float>::infinity();

/// The solver follows Box2D 3's "soft step" (E. Catto, "Solver2D", 2024): each substep integrates
/// velocities, applies the last impulses again, solves with contacts as stiff damped springs,
/// integrates positions, and solves again without the springs, so that what pushed shapes apart
/// does not stay in the velocities as energy. Beyond it:
/// - An impulse always acts on both bodies at one and the same point in space, although they move
///   between substeps, so that angular momentum is conserved to rounding.
/// - Positions follow the mean velocity of a substep where the change of velocity is due to forces:
///   exact under constant acceleration.
/// - Where joints are, constraints are solved in the middle of each substep instead: see
///   JointSolver.
/// - Impacts come before all else, at their times within the substep and one after the other; see
///   contact_impacts.cpp and contact_blows.cpp.
class ContactSolver {
  public:
    struct Parameters {
        Vec3 gravity = Vec3::Zero();
        float dt = 0.0F;
        int substeps = 4;
        int iterations = 1;
        int relax_iterations = 1;
        float restitution_speed = 0.5F;  ///< slower impacts do not bounce, m/s
    };

    /// Makes room for that many bodies and contacts.
    void reserve(std::size_t bodies, std::size_t contacts);

    void reserve_joints(std::size_t joints) { joints_.reserve(joints); }

    /// Solves the contacts and joints in the lists and moves the awake bodies that they hold;
    /// writes poses, velocities and impulses back. A body whose result is not finite or out of
    /// range keeps its pose, stops, and is appended to `broken`. `solver_slot` of all awake bodies
    /// must be 0 and is so again afterwards.
    void solve(Bodies& bodies,
               ContactGraph& graph,
               std::span<const std::uint32_t> list,
               JointTable& table,
               std::span<const std::uint32_t> joints,
               const Parameters& parameters,
               compute::Team& team,
               std::vector<std::uint32_t>& broken);

  private:
    /// A contact that may see an impact. Where it is comes along: an impact looks at many contacts,
    /// one at a time, and in a batch each number of one lies in a cache line of its own.
    struct SolverWatch {
        struct Point {
            Vec3 arm;
            float separation = 0.0F;
        };

        std::uint32_t batch = 0;
        std::uint32_t lane = 0;
        std::uint32_t a = 0, b = 0;
        float restitution = 0.0F;
        float time = kNoImpact;  ///< of the next impact, s from the substep's start
        bool listed = false;     ///< among the meetings that are gathered now
        std::uint8_t count = 0;
        float follow_b = 0.0F;
        Vec3 normal, between, lead;
        std::array<Point, kMaxManifoldPoints> points;
    };

    /// The contact spring of this step.
    struct Softness {
        float bias_rate = 0.0F;
        float mass_scale = 1.0F;
        float impulse_scale = 0.0F;
    };

    /// Velocities of the two bodies of a contact.
    struct Motions {
        Row8 a, b;
    };

    struct Arms;
    struct Approach;
    struct Single;
    struct Blow;

    void prepare(Bodies& bodies,
                 const ContactGraph& graph,
                 std::span<const std::uint32_t> list,
                 const JointTable& table,
                 std::span<const std::uint32_t> joints);
    static Softness contact_softness(float h);
    void lay_out(const ContactGraph& graph);
    void fill_batch(std::size_t index, const Bodies& bodies, const ContactGraph& graph);
    void list_watches(const ContactGraph& graph);
    void watch(std::size_t batch, std::uint32_t lane, float restitution);
    void list_rolls(const ContactGraph& graph);
    /// Calls visit(batch) for all, those of a colour by all threads at a time.
    template <class Visit>
    void for_each_batch(Visit&& visit);
    void fill_lane(ContactBatch& batch,
                   std::size_t lane,
                   const Bodies& bodies,
                   const Pair& pair,
                   const Contact& contact);
    void fill_masses(ContactBatch& batch, std::size_t lanes, const ContactGraph& graph);
    [[gnu::noinline]] void fit_masses(ContactBatch& batch,
                                      const LaneBody& a,
                                      const LaneBody& b,
                                      const Lanes3& offset);
    void warm_start();
    void substep(const Bodies& bodies, const JointTable& table, bool last);
    template <bool kSoft>
    void solve_all();
    void add_totals();
    template <bool kSoft, std::size_t kCount>
    void solve_batch(ContactBatch& batch);
    void solve_rolling(const ContactBatch& batch);
    void solve_friction(ContactBatch& batch,
                        LaneBody& a,
                        LaneBody& b,
                        const Arms& arms,
                        const Lanes& push,
                        const Lanes& leverage) const;

    // contact_impacts.cpp, contact_blows.cpp
    void watch_impacts();
    [[nodiscard]] float meeting_time(const SolverWatch& w) const;
    [[nodiscard]] float arrival(const SolverWatch& w, float time) const;
    [[nodiscard]] Motions motions_at(const Approach& at, float time) const;
    [[nodiscard]] float bounce_speed(float pull) const;
    void collide(const Bodies& bodies);
    void take_back_pushes();
    void take_back_rolling(const ContactBatch& batch, std::size_t lane);
    void follow_turns(std::uint32_t slot);
    void list_watches_of_slots();
    void find_next_meetings();
    void strike(const Bodies& bodies, SolverWatch& w, float time);
    float size_of(const SolverWatch& w, const Single& at, const Motions& m, const Blow& blow);
    [[nodiscard]] float work_of_movers(const SolverWatch& w,
                                       const Single& at,
                                       const Blow& blow,
                                       float size) const;
    [[nodiscard]] float share_kept(float before, float helped) const;
    void take_back(const Single& at, float left);
    void delay_pulls(const Single& at, float time);
    void note_hit(const Bodies& bodies, const Single& at, std::uint32_t slot, float time);
    [[nodiscard]] Row8 before_of(std::uint32_t slot) const;
    void shove(const ContactBatch& batch,
               std::size_t lane,
               const Single& at,
               const Blow& blow,
               float share);
    void apply(const SolverWatch& w, const Single& at, const Blow& blow, float share);
    bool aim(const SolverWatch& w, const Single& at, Motions m, Blow& blow) const;

    void store(Bodies& bodies, ContactGraph& graph, std::vector<std::uint32_t>& broken);
    void store_batch(const ContactBatch& batch, ContactGraph& graph) const;

    Parameters parameters_;
    compute::Team* team_ = nullptr;
    Softness softness_;
    float h_ = 0.0F;
    float tally_ = 0.0F;  ///< 1 in the pass that notes the carried impulses
    bool leaps_ = false;  ///< solves in the middle of substeps
    float kept_ = 1.0F;   ///< share of a substep's change of velocity that positions have not seen
    SolverBodies moving_;
    JointSolver joints_;
    ContactColoring coloring_;
    std::vector<ContactBatch> batches_;
    std::vector<PointLanes> points_;
    std::vector<Lanes> couplings_;
    std::vector<RollLanes> rolls_;
    std::vector<SolverWatch> watches_;
    std::size_t watched_ = 0;  ///< so many of them in each substep, the others once an impact came
    // Of impacts.
    std::vector<std::uint32_t> meetings_;                ///< watches that see one next
    std::vector<std::uint32_t> struck_;                  ///< slots that one moved
    std::vector<std::pair<std::uint32_t, Row8>> hit_;    ///< slots and how they moved before it
    std::vector<std::uint32_t> first_watch_, watch_of_;  ///< of slot s, from first_watch_[s]
};

}  // namespace zoned::physics
