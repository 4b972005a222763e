// RowSystem: contacts and joints of a step as constraint rows on velocities, in columns.
#pragma once

#include "shared/math/types.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace zoned::physics {

using Mat3d = Eigen::Matrix3d;

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

enum class RowRole : std::uint8_t {
    kBounded,     ///< joints, motors, limits: low <= impulse <= high
    kNormal,      ///< contact: 0 <= impulse
    kFriction,    ///< |impulse| <= friction x that of its normal row
    kConeFirst,   ///< with the row after it: the size of both is at most that
    kConeSecond,  ///< never visited by itself
};

/// A body as rows see it. Slot 0 stands for all that does not move.
struct RowBody {
    Vec3d velocity = Vec3d::Zero();  ///< m/s
    Vec3d spin = Vec3d::Zero();      ///< rad/s, world axes
    double inv_mass = 0.0;           ///< 1/kg; 0: impulses do not move it
    Mat3d inverse = Mat3d::Zero();   ///< inverse inertia, world axes
};

/// C' = linear . (v_b - v_a) + angular_a . w_a + angular_b . w_b.
struct RowShape {
    Vec3d linear = Vec3d::Zero();
    Vec3d angular_a = Vec3d::Zero();
    Vec3d angular_b = Vec3d::Zero();
    Vec3d turn_a = Vec3d::Zero();  ///< inverse inertia times angular part: M^-1 J^T
    Vec3d turn_b = Vec3d::Zero();
};

/// A row as `add` takes it.
struct NewRow {
    std::uint32_t a = 0, b = 0;  ///< slots
    Vec3d linear = Vec3d::Zero();
    Vec3d angular_a = Vec3d::Zero();
    Vec3d angular_b = Vec3d::Zero();
    RowRole role = RowRole::kBounded;
    double low = -kUnbounded, high = kUnbounded;  ///< N s; of kBounded
    std::uint32_t normal = 0;                     ///< of friction: its normal row
    double friction = 0.0;                        ///< of friction: coefficient (m for a moment)
    double lambda = 0.0;                          ///< first guess, N s
    Vec3d arm_a = Vec3d::Zero();                  ///< of contacts: to the point, m
    Vec3d arm_b = Vec3d::Zero();
    bool rub = false;  ///< friction, whatever its bounds
};

/// Consecutive rows that share no moving body with others: an island.
struct RowGroup {
    std::uint32_t first = 0, end = 0;
};

/// Scratch of the solvers, kept for its capacity.
struct SolverScratch {
    std::vector<double> previous, direction, matrix, factors, right, speeds, best;
    std::vector<std::uint32_t> unknowns, pivots;
    std::vector<std::uint32_t> first_of_body;  ///< by slot, and one more: of its rows below
    std::vector<std::uint32_t> row_and_side;   ///< 2 x row, + 1 where the body is its second
    std::vector<std::int8_t> states;
};

/// w = J V + bias + soft x lambda, and V moves by M^-1 J^T lambda. A solution has for each row
/// w = 0 with lambda within its bounds, or w > 0 at the lower, w < 0 at the upper bound: a mixed
/// linear complementarity problem (D. Stewart, J. Trinkle, IJNME 39, 1996; M. Anitescu, F. Potra,
/// Nonlinear Dynamics 14, 1997), with friction's bounds depending on the normal rows.
///
/// In doubles: residuals can be followed below a float's rounding, and mass ratios of 1e5 leave
/// digits to work with.
class RowSystem {
  public:
    std::vector<RowBody> bodies;  ///< by slot; velocities follow the impulses
    // Columns, by row.
    std::vector<std::uint32_t> a, b;
    std::vector<RowShape> shape;
    std::vector<RowRole> role;
    std::vector<std::uint32_t> normal;
    std::vector<double> friction;
    std::vector<double> low, high;  ///< N s
    std::vector<double> bias;       ///< m/s; the caller's to set
    std::vector<double> soft;       ///< m/s per N s; the caller's to set
    std::vector<double> response;  ///< J M^-1 J^T, 1/kg; of the pair's stiffest direction in a cone
    std::vector<double> split;     ///< the same with each body's mass shared by all of its rows
    std::vector<double> kind_split;  ///< shared by its rows of friction, or by all others
    std::vector<double> lambda;      ///< N s
    std::vector<double>
        pull;  ///< of contacts: relative acceleration by forces along the normal, m/s2
    std::vector<double> restitution;   ///< of the collision response; the caller's to set
    std::vector<double> gap;           ///< C, m; the caller's to set; negative: overlap
    std::vector<std::uint8_t> undoes;  ///< 1: its bias undoes an error
    std::vector<std::uint8_t> rub;     ///< 1: friction, whatever its bounds
    std::vector<Vec3d> arm_a, arm_b;   ///< of contacts: from the bodies' centres to the point, m
    std::vector<std::uint32_t> order;  ///< rows in the order of visits, without kConeSecond
    std::vector<RowGroup> groups;
    SolverScratch scratch;

    /// Drops all rows and groups, and all bodies but slot 0.
    void clear();
    void clear_rows();
    std::uint32_t add_body(const RowBody& body);
    /// Appends a row; rows of a contact's friction come after its normal row, the two of a cone
    /// one after the other.
    std::uint32_t add(const NewRow& row);
    /// To be called after the last row: masses of cones and shares, order of visits. `shuffle` not
    /// 0: an order drawn from it, the same for the same number of rows.
    void finish(std::uint32_t shuffle);
    /// Gives the bodies the first guesses.
    void apply_guess();

    [[nodiscard]] std::size_t size() const { return a.size(); }

    /// J V, m/s.
    [[nodiscard]] double speed(std::size_t i) const {
        const RowShape& s = shape[i];
        const RowBody& p = bodies[a[i]];
        const RowBody& q = bodies[b[i]];
        return s.linear.dot(q.velocity - p.velocity) + s.angular_a.dot(p.spin) +
               s.angular_b.dot(q.spin);
    }

    /// w: the error of a row's constraint, m/s.
    [[nodiscard]] double excess(std::size_t i) const {
        return speed(i) + bias[i] + soft[i] * lambda[i];
    }

    /// Gives the bodies an impulse along the row, N s; `lambda` is left alone.
    void push(std::size_t i, double impulse) {
        push_first(i, impulse);
        push_second(i, impulse);
    }

    /// The same for one of its bodies.
    void push_first(std::size_t i, double impulse) {
        RowBody& p = bodies[a[i]];
        p.velocity -= (p.inv_mass * impulse) * shape[i].linear;
        p.spin += impulse * shape[i].turn_a;
    }

    void push_second(std::size_t i, double impulse) {
        RowBody& q = bodies[b[i]];
        q.velocity += (q.inv_mass * impulse) * shape[i].linear;
        q.spin += impulse * shape[i].turn_b;
    }

    /// The bound of a friction row as things stand, N s.
    [[nodiscard]] double friction_limit(std::size_t i) const {
        return friction[i] * std::max(lambda[normal[i]], 0.0);
    }

    /// The effect of an impulse along row j on the speed of row i, 1/kg.
    [[nodiscard]] double coupling(std::size_t i, std::size_t j) const;

  private:
    void weigh_cones();
    void share_masses();

    // By slot: how many rows it takes part in.
    std::vector<std::uint32_t> rows_of_, frictions_of_;
};

/// Puts a pair of impulses back onto the disc of radius `limit`.
inline void project_on_disc(double limit, double& x, double& y) {
    const double size2 = x * x + y * y;
    if (size2 > limit * limit) {
        const double scale = limit / std::sqrt(size2);
        x *= scale;
        y *= scale;
    }
}

}  // namespace zoned::physics
