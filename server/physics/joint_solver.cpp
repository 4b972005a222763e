#include "server/physics/joint_solver.h"

#include "server/physics/integrate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// A factorisation that takes more multiplications than this is not worth it.
constexpr double kMostWork = 2.0e6;
/// Share of a violated limit that is undone per substep.
constexpr float kLimitRate = 0.2F;

/// Impulse that moves a soft row to where an implicit spring and damper would (E. Catto, "Soft
/// Constraints", GDC 2011).
float spring_change(const JointDef& def,
                    float h,
                    float mass,
                    float speed,
                    float error,
                    float impulse) {
    const float omega = 2.0F * std::numbers::pi_v<float> * def.spring_hz;
    const float a1 = 2.0F * def.spring_damping_ratio + h * omega;
    const float a2 = h * omega * a1;
    const float a3 = 1.0F / (1.0F + a2);
    return -mass * a2 * a3 * (speed + omega / a1 * error) - a3 * impulse;
}

}  // namespace

void JointSolver::reserve(std::size_t joints) {
    items_.reserve(joints);
    unordered_.reserve(joints);
    rows_.reserve(9 * joints);
    unknowns_.reserve(6 * joints);
    starts_.reserve(6 * joints);
    joints_of_.reserve(2 * joints);
    visited_.reserve(joints);
    queue_.reserve(joints);
}

void JointSolver::prepare(Bodies& bodies,
                          const JointTable& table,
                          std::span<const std::uint32_t> joints,
                          SolverBodies& moving,
                          float h) {
    h_ = h;
    unordered_.clear();
    for (const std::uint32_t index : joints) {
        const JointEntry& entry = table[index];
        Item item;
        item.joint = index;
        const Vec3 origin = bodies.position[entry.b];
        const auto place = [&](std::uint32_t row, std::uint32_t& slot, JointPose& pose, Quat& q) {
            if (row == kNoIndex) {
                pose.position = -origin;
                return;
            }
            slot = bodies.awake[row] != 0 ? moving.slot_of(bodies, row) : 0;
            pose.position = bodies.position[row] - origin;
            pose.rotation = bodies.rotation[row];
            q = bodies.orientation[row];
            if (slot != 0) {
                moving.track(bodies, slot);
            }
        };
        place(entry.a, item.a, item.pose_a, item.orientation_a);
        place(entry.b, item.b, item.pose_b, item.orientation_b);
        item.hard_count = static_cast<std::uint32_t>(hard_rows(entry.joint.def.kind));
        unordered_.push_back(item);
    }
    order(moving);
    shape_matrix();
    rows_.clear();
    for (Item& item : items_) {
        const JointEntry& entry = table[item.joint];
        JointRows rows;
        write_rows(entry.joint, item.pose_a, item.pose_b, rows);
        item.first = static_cast<std::uint32_t>(rows_.size());
        item.count = static_cast<std::uint32_t>(rows.count);
        const float scale = entry.substep_s > 0.0F ? h_ / entry.substep_s : 0.0F;
        for (std::size_t i = 0; i < rows.count; ++i) {
            rows_.emplace_back();
            rows_.back().impulse = scale * entry.impulse[i];
        }
    }
}

/// Breadth first over the bodies that joints share, from joints at the ends of chains first: a
/// chain is as narrow as one joint, a tree nearly so.
void JointSolver::order(const SolverBodies& moving) {
    first_of_.assign(moving.size() + 1, 0);
    const auto each_slot = [&](const Item& item, auto&& visit) {
        for (const std::uint32_t slot : {item.a, item.b}) {
            if (slot != 0 && moving.moved_by_impulses(slot)) {
                visit(slot);
            }
        }
    };
    for (const Item& item : unordered_) {
        each_slot(item, [&](std::uint32_t slot) { ++first_of_[slot + 1]; });
    }
    for (std::size_t s = 1; s < first_of_.size(); ++s) {
        first_of_[s] += first_of_[s - 1];
    }
    joints_of_.resize(first_of_.back());
    queue_.assign(first_of_.begin(), first_of_.end());
    for (std::size_t i = 0; i < unordered_.size(); ++i) {
        each_slot(unordered_[i], [&](std::uint32_t slot) {
            joints_of_[queue_[slot]++] = static_cast<std::uint32_t>(i);
        });
    }
    items_.clear();
    visited_.assign(unordered_.size(), 0);
    for (const std::uint32_t most : {2U, ~0U}) {
        for (std::size_t i = 0; i < unordered_.size(); ++i) {
            std::uint32_t neighbours = 0;
            each_slot(unordered_[i], [&](std::uint32_t slot) {
                neighbours += first_of_[slot + 1] - first_of_[slot] - 1;
            });
            if (visited_[i] == 0 && neighbours < most) {
                walk(static_cast<std::uint32_t>(i));
            }
        }
    }
    // From here on the lists hold places in `items_`, which are the order of elimination.
    for (std::uint32_t& joint : joints_of_) {
        joint = queue_[joint];
    }
}

void JointSolver::walk(std::uint32_t from) {
    const std::size_t begin = items_.size();
    queue_.resize(std::max(queue_.size(), unordered_.size()));
    visited_[from] = 1;
    queue_[from] = static_cast<std::uint32_t>(items_.size());
    items_.push_back(unordered_[from]);
    for (std::size_t at = begin; at < items_.size(); ++at) {
        const Item item = items_[at];
        for (const std::uint32_t slot : {item.a, item.b}) {
            if (slot == 0) {
                continue;
            }
            for (std::uint32_t k = first_of_[slot]; k < first_of_[slot + 1]; ++k) {
                const std::uint32_t next = joints_of_[k];
                if (visited_[next] == 0) {
                    visited_[next] = 1;
                    queue_[next] = static_cast<std::uint32_t>(items_.size());
                    items_.push_back(unordered_[next]);
                }
            }
        }
    }
}

void JointSolver::shape_matrix() {
    std::uint32_t hard = 0;
    for (Item& item : items_) {
        item.hard = hard;
        hard += item.hard_count;
    }
    starts_.clear();
    for (Item& item : items_) {
        item.earliest = item.hard;
        for (const std::uint32_t slot : {item.a, item.b}) {
            for (std::uint32_t k = first_of_[slot]; slot != 0 && k < first_of_[slot + 1]; ++k) {
                item.earliest = std::min(item.earliest, items_[joints_of_[k]].hard);
            }
        }
        starts_.insert(starts_.end(), item.hard_count, item.earliest);
    }
    direct_ = EnvelopeSolver::cost(starts_) <= kMostWork;
    if (direct_) {
        matrix_.shape(starts_);
    }
    unknowns_.assign(hard, 0.0);
}

void JointSolver::update(const JointTable& table, const SolverBodies& moving) {
    const auto pose = [&](const JointPose& start, const Quat& q, std::uint32_t slot) {
        if (slot == 0) {
            return start;
        }
        return JointPose{start.position + SolverBodies::linear(moving.drift[slot]),
                         moving.orientation(slot, q).toRotationMatrix()};
    };
    for (const Item& item : items_) {
        JointRows rows;
        write_rows(table[item.joint].joint,
                   pose(item.pose_a, item.orientation_a, item.a),
                   pose(item.pose_b, item.orientation_b, item.b),
                   rows);
        const float linear = moving.motion[item.a].at[3] + moving.motion[item.b].at[3];
        for (std::size_t i = 0; i < rows.count; ++i) {
            Row& to = rows_[item.first + i];
            to.row = rows.rows[i];
            to.turn_a = moving.inverse_times(item.a, to.row.angular_a);
            to.turn_b = moving.inverse_times(item.b, to.row.angular_b);
            const float k = linear * to.row.linear.squaredNorm() + to.turn_a.dot(to.row.angular_a) +
                            to.turn_b.dot(to.row.angular_b);
            to.mass = k > 0.0F ? 1.0F / k : 0.0F;
        }
    }
    if (direct_) {
        assemble(moving);
        matrix_.factor();
    }
}

void JointSolver::assemble(const SolverBodies& moving) {
    matrix_.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const Item& p = items_[i];
        for (const std::uint32_t slot : {p.a, p.b}) {
            for (std::uint32_t k = first_of_[slot]; slot != 0 && k < first_of_[slot + 1]; ++k) {
                if (joints_of_[k] <= i) {
                    add_block(moving, p, items_[joints_of_[k]], slot);
                }
            }
        }
    }
}

/// What impulses of q's rows do to the speeds of p's rows through one body.
void JointSolver::add_block(const SolverBodies& moving,
                            const Item& p,
                            const Item& q,
                            std::uint32_t slot) {
    const bool b_of_p = p.b == slot;
    const bool b_of_q = q.b == slot;
    const float inv_mass = (b_of_p == b_of_q ? 1.0F : -1.0F) * moving.motion[slot].at[3];
    for (std::size_t i = 0; i < p.hard_count; ++i) {
        const Row& row = rows_[p.first + i];
        const Vec3& angular = b_of_p ? row.row.angular_b : row.row.angular_a;
        const std::size_t last = p.hard == q.hard ? i + 1 : q.hard_count;
        for (std::size_t j = 0; j < last; ++j) {
            const Row& other = rows_[q.first + j];
            matrix_.at(p.hard + i, q.hard + j) +=
                static_cast<double>(inv_mass * row.row.linear.dot(other.row.linear)) +
                static_cast<double>(angular.dot(b_of_q ? other.turn_b : other.turn_a));
        }
    }
}

float JointSolver::speed(const SolverBodies& moving, const Item& item, const Row& row) {
    const Row8& a = moving.motion[item.a];
    const Row8& b = moving.motion[item.b];
    return row.row.linear.dot(SolverBodies::linear(b) - SolverBodies::linear(a)) +
           row.row.angular_a.dot(SolverBodies::angular(a)) +
           row.row.angular_b.dot(SolverBodies::angular(b));
}

void JointSolver::apply(SolverBodies& moving, const Item& item, const Row& row, float impulse) {
    moving.change(item.a, -impulse * row.row.linear, impulse * row.turn_a);
    moving.change(item.b, impulse * row.row.linear, impulse * row.turn_b);
}

void JointSolver::warm_start(SolverBodies& moving) {
    for (const Item& item : items_) {
        for (std::size_t i = item.first; i < item.first + item.count; ++i) {
            apply(moving, item, rows_[i], rows_[i].impulse);
        }
    }
}

void JointSolver::solve(SolverBodies& moving, bool biased) {
    for (const Item& item : items_) {
        for (std::size_t i = direct_ ? item.hard_count : 0; i < item.count; ++i) {
            solve_single(moving, item, rows_[item.first + i], biased);
        }
    }
    if (direct_ && !unknowns_.empty()) {
        solve_hard(moving, biased);
    }
}

void JointSolver::solve_hard(SolverBodies& moving, bool biased) {
    for (const Item& item : items_) {
        for (std::size_t i = 0; i < item.hard_count; ++i) {
            const Row& row = rows_[item.first + i];
            const float bias = biased ? row.row.error / h_ : 0.0F;
            unknowns_[item.hard + i] = -static_cast<double>(speed(moving, item, row) + bias);
        }
    }
    matrix_.solve(unknowns_);
    for (const Item& item : items_) {
        for (std::size_t i = 0; i < item.hard_count; ++i) {
            Row& row = rows_[item.first + i];
            const auto change = static_cast<float>(unknowns_[item.hard + i]);
            row.impulse += change;
            apply(moving, item, row, change);
        }
    }
}

void JointSolver::solve_single(SolverBodies& moving,
                               const Item& item,
                               Row& row,
                               bool biased) const {
    const float rate = speed(moving, item, row);
    const float error = row.row.error;
    float impulse = row.impulse;
    switch (row.row.kind) {
        case RowKind::kHard:
            impulse -= row.mass * (rate + (biased ? kLimitRate * error / h_ : 0.0F));
            break;
        case RowKind::kLimit: {
            const float undo = biased ? kLimitRate * error / h_ : 0.0F;
            impulse -= row.mass * (rate + (error > 0.0F ? error / h_ : undo));
            impulse = std::max(impulse, 0.0F);
            break;
        }
        case RowKind::kMotor:
            impulse -= row.mass * (rate - row.row.target);
            impulse = std::clamp(impulse, -row.row.most * h_, row.row.most * h_);
            break;
        case RowKind::kSpring:
            if (biased) {
                impulse += spring_change(*row.row.spring, h_, row.mass, rate, error, impulse);
            }
            break;
    }
    apply(moving, item, row, impulse - row.impulse);
    row.impulse = impulse;
}

void JointSolver::store(JointTable& table) const {
    for (const Item& item : items_) {
        JointEntry& entry = table[item.joint];
        Vec3 force = Vec3::Zero();
        for (std::size_t i = 0; i < item.count; ++i) {
            const Row& row = rows_[item.first + i];
            entry.impulse[i] = row.impulse;
            force += row.impulse * row.row.linear;
        }
        entry.substep_s = h_;
        entry.force_n = force.norm() / h_;
    }
}

}  // namespace zoned::physics
