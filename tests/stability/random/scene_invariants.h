// SceneInvariants: what must hold in every sound scene, checked from outside in double precision.
#pragma once

#include "tests/stability/random/random_scene.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace zoned::stability {

enum class Invariant : std::uint8_t {
    /// All states are finite, and the engine stopped no body.
    kFinite,
    /// Mechanical energy (motion, spin, height, springs) of each group of bodies that may have met
    /// is at most its start plus the work of motors and movers. Allowed are 1 % of the largest
    /// energy of the group so far, and the energy of error_budget_m under gravity. The largest
    /// energy counts from its lowest rest: all centres at the lowest ground, or as low as they
    /// went.
    ///
    /// A motor's work in a step is at most its force times its speed: the smaller of its target and
    /// the larger of the speeds before and after. A mover's work is at most what it pushes times
    /// its speed at the contact, with friction on top, and joint force times speed at the anchor.
    kEnergy,
    /// Without gravity, ground, movers and joints to the world: linear and angular momentum stay to
    /// 1e-4 of the sum of the sizes of their terms and of what joints and motors exchange in a
    /// step, and the rounding of coordinates. Ends when a body falls asleep, which takes its
    /// momentum.
    kMomentum,
    /// Joints are closed within the larger of 1 cm and a thousandth of their larger body. A wrong
    /// angle counts by its arc on the smaller body.
    kJoint,
    /// A body that stays within 5 mm and 0.01 rad for 10 s, with all that it may touch, is asleep
    /// at their end. Motors and movers that it may touch excuse it.
    kSleep,
    /// No centre of a convex part goes through static boxes, spheres or the ground.
    kTunnel,
};

inline constexpr std::size_t kInvariants = 6;

/// Names as on the command line, in the order of the kinds.
const std::array<std::string, kInvariants>& invariant_names();

/// A step as the checks see it.
struct Observation {
    std::vector<physics::BodyState> states;
    std::vector<bool> held;     ///< joints that are still there
    std::vector<float> forces;  ///< of joints, N
    std::vector<physics::ContactEvent> contacts;
    physics::StepStats stats;
};

/// An invariant that does not hold.
struct Breach {
    Invariant what = Invariant::kFinite;
    double figure = 0.0;  ///< the worst until the end of the run
    double bound = 0.0;
    double time = 0.0;     ///< when it first broke, s
    std::size_t item = 0;  ///< body or joint, of the worst figure
    /// Joints: the engine had said before that its effort does not suffice.
    bool gave_up = false;
};

class SceneInvariants {
  public:
    /// Both outlive this.
    SceneInvariants(const RandomScene& scene, const LiveScene& live);

    void look(const Observation& now);

    /// At most one of each kind, by kind.
    [[nodiscard]] std::vector<Breach> breaches() const;
    [[nodiscard]] bool broken(Invariant what) const;

    /// Highest speed of a dynamic body so far, m/s.
    [[nodiscard]] double top_speed() const { return top_speed_; }

  private:
    struct BodyWatch {
        bool dynamic = false;
        bool mover = false;
        double mass = 0.0;
        double low = 0.0;  ///< m, of the centre
        Vec3d rest_at = Vec3d::Zero();
        Eigen::Quaterniond rest_turn = Eigen::Quaterniond::Identity();
        double rest_since = 0.0;  ///< s
        std::vector<Vec3d> centres;
        std::vector<bool> above;  ///< centres that were over the ground
    };

    struct JointWatch {
        Vec3d local_a = Vec3d::Zero();  ///< of the body, or in the world
        Vec3d local_b = Vec3d::Zero();
        Vec3d axis_a = Vec3d::UnitY();
        Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< of b as seen from a
        double length = 0.0;
        double stiffness = 0.0;
        double bound = 0.01;
        double arm = 0.0;
        double speed = 0.0;  ///< of the motor after the last step
        bool motor = false;
        bool warned = false;
    };

    struct EnergyGroup {
        double allowance = 0.0;  ///< energy at the start and work, J
        double largest = 0.0;    ///< J
    };

    struct Place {
        Vec3d at, velocity, spin;
        Eigen::Quaterniond turn;
        bool asleep = false;
    };

    void report(Invariant what,
                double figure,
                double bound,
                std::size_t item,
                bool gave_up = false);
    void take_places(const Observation& now);
    void check_energy(const Observation& now);
    void check_momentum(const Observation& now);
    void check_joints(const Observation& now);
    void check_sleep(const Observation& now);
    void check_tunnel();

    [[nodiscard]] std::size_t group_of(std::size_t body);
    void unite(std::size_t a, std::size_t b);
    void unite_near();
    [[nodiscard]] bool near(std::size_t a, std::size_t b) const;
    void add_motor_work(const Observation& now);
    void add_mover_work(const Observation& now);
    [[nodiscard]] double energy_of(std::size_t body) const;
    [[nodiscard]] Place place_of(int body) const;
    [[nodiscard]] Vec3d anchor_of(const RandomJoint& joint,
                                  const JointWatch& watch,
                                  bool of_b) const;
    [[nodiscard]] double spring_energy(std::size_t joint) const;
    [[nodiscard]] double motor_speed(std::size_t joint) const;
    [[nodiscard]] double gap_of(std::size_t joint) const;
    [[nodiscard]] double misturn_of(std::size_t joint) const;
    void sum_momentum(Vec3d& linear, Vec3d& angular, double& size, double& angular_size) const;
    [[nodiscard]] double stray_of(std::size_t body, const Vec3d& from, const Vec3d& to) const;
    [[nodiscard]] bool passed_static(std::size_t wall,
                                     const Vec3d& from,
                                     const Vec3d& to,
                                     double stray) const;

    const RandomScene& scene_;
    const LiveScene& live_;
    std::vector<BodyWatch> bodies_;
    std::vector<JointWatch> joints_;
    std::vector<Place> places_, before_;
    std::vector<std::size_t> parents_;
    std::vector<EnergyGroup> groups_;
    std::array<std::optional<Breach>, kInvariants> breaches_;
    Vec3d gravity_, middle_;
    Vec3d linear_ = Vec3d::Zero(), angular_ = Vec3d::Zero();
    bool isolated_ = false;
    double time_ = 0.0;
    double warned_at_ = -1.0e9;  ///< s, the last step whose effort did not suffice
    double top_speed_ = 0.0;
    double momentum_size_ = 0.0, angular_size_ = 0.0;
    std::uint64_t steps_ = 0;
};

}  // namespace zoned::stability
