// build: hot loops
// The part of the joint solver that solves rows one after the other, eight joints at a time.
#include "server/physics/joints/joint_solver.h"

namespace zoned::physics {

namespace {

/// Passes over the rows of a graph whose matrix would be too wide; even. With fewer, joints that
/// stay open cost as much time in substeps.
constexpr int kSinglePasses = 10;

[[gnu::always_inline]] inline Lanes3 linear_of(const Block8& m) {
    return {m.row[0], m.row[1], m.row[2]};
}

[[gnu::always_inline]] inline Lanes3 angular_of(const Block8& m) {
    return {m.row[4], m.row[5], m.row[6]};
}

/// How one body of each of eight joints moves.
struct LaneMotion {
    Lanes3 velocity, spin;
    Lanes inv_mass, rest;

    [[gnu::always_inline]] LaneMotion(const std::vector<Row8>& table, const LaneRows& slots) {
        const Block8 m = gather(table.data(), slots);
        velocity = linear_of(m);
        inv_mass = m.row[3];
        spin = angular_of(m);
        rest = m.row[7];
    }

    [[gnu::always_inline]] void change(const Lanes3& impulse, const Lanes3& turn) {
        velocity = velocity + inv_mass * impulse;
        spin = spin + turn;
    }

    [[gnu::always_inline]] void store(std::vector<Row8>& table, const LaneRows& slots) const {
        Block8 m{{velocity.x, velocity.y, velocity.z, inv_mass, spin.x, spin.y, spin.z, rest}};
        transpose(m);
        for (std::size_t i = 0; i < kLanes; ++i) {
            table[slots[i]].at = m.row[i];
        }
    }
};

/// Steps of conjugate gradients, at most.
constexpr int kMostGradients = 12;
/// Rows that open by less than this in a substep are solved, m and rad.
constexpr float kRowSolved = 3.0e-4F;
/// The inverse mass of a motion, and the rest of it.
constexpr Lanes kMassAlone{0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 0.0F};
constexpr Lanes kMotionAlone{1.0F, 1.0F, 1.0F, 0.0F, 1.0F, 1.0F, 1.0F, 0.0F};

template <class RowLanes>
[[gnu::always_inline]] inline Lanes speed_of(const RowLanes& row,
                                             const LaneMotion& a,
                                             const LaneMotion& b) {
    return dot(row.linear, b.velocity - a.velocity) +
           (dot(row.angular_a, a.spin) + dot(row.angular_b, b.spin));
}

template <class RowLanes>
[[gnu::always_inline]] inline void push_apart(const RowLanes& row,
                                              const Lanes& impulse,
                                              LaneMotion& a,
                                              LaneMotion& b) {
    a.change(-impulse * row.linear, impulse * row.turn_a);
    b.change(impulse * row.linear, impulse * row.turn_b);
}

}  // namespace

/// Takes the rows as they are after an update.
void JointSolver::fill_batches(const JointGroup& group) {
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        for (std::uint32_t r = 0; r < batch.count; ++r) {
            RowLanes& to = batch_rows_[batch.first + r];
            to = RowLanes();
            Block8 along_a{};
            Block8 along_b{};
            for (std::size_t lane = 0; lane < kLanes && batch.item[lane] != kNoIndex; ++lane) {
                const JointItem& item = items_[batch.item[lane]];
                if (r >= item.count) {
                    continue;
                }
                const Row& row = rows_[item.first + r];
                const float whole = row.response + row.soft;
                along_a.row[lane] = row.along_a.at;
                along_b.row[lane] = row.along_b.at;
                to.mass[lane] = whole > 0.0F ? 1.0F / whole : 0.0F;
                to.soft[lane] = row.soft;
                to.bias[lane] = row.bias;
                to.undo[lane] = row.undo;
                to.low[lane] = row.low;
                to.high[lane] = row.high;
            }
            transpose(along_a);
            transpose(along_b);
            to.linear = linear_of(along_b);
            to.angular_a = angular_of(along_a);
            to.angular_b = angular_of(along_b);
        }
    }
    fill_turns(group);
}

/// Takes what an impulse does where the bodies are by now.
void JointSolver::fill_turns(const JointGroup& group) {
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        for (std::uint32_t r = 0; r < batch.count; ++r) {
            Block8 push_a{};
            Block8 push_b{};
            for (std::size_t lane = 0; lane < kLanes && batch.item[lane] != kNoIndex; ++lane) {
                const JointItem& item = items_[batch.item[lane]];
                if (r < item.count) {
                    push_a.row[lane] = rows_[item.first + r].push_a.at;
                    push_b.row[lane] = rows_[item.first + r].push_b.at;
                }
            }
            transpose(push_a);
            transpose(push_b);
            batch_rows_[batch.first + r].turn_a = angular_of(push_a);
            batch_rows_[batch.first + r].turn_b = angular_of(push_b);
        }
    }
}

void JointSolver::load_impulses(const JointGroup& group) {
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        for (std::size_t lane = 0; lane < kLanes && batch.item[lane] != kNoIndex; ++lane) {
            const JointItem& item = items_[batch.item[lane]];
            for (std::uint32_t r = 0; r < item.count; ++r) {
                batch_rows_[batch.first + r].impulse[lane] = rows_[item.first + r].impulse;
            }
        }
    }
}

void JointSolver::store_impulses(const JointGroup& group) {
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        for (std::size_t lane = 0; lane < kLanes && batch.item[lane] != kNoIndex; ++lane) {
            const JointItem& item = items_[batch.item[lane]];
            for (std::uint32_t r = 0; r < item.count; ++r) {
                rows_[item.first + r].impulse = batch_rows_[batch.first + r].impulse[lane];
            }
        }
    }
}

/// Joints one after the other, from one end of the graph to the other and back: what happens at one
/// end is felt at the other in the same visit.
void JointSolver::solve_singly(SolverBodies& moving, const JointGroup& group) {
    if (!group.bounded) {
        solve_by_gradients(moving, group);
        return;
    }
    load_impulses(group);
    for (int pass = 0; pass < kSinglePasses; pass += 2) {
        for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
            solve_batch(moving, batches_[i]);
        }
        for (std::uint32_t i = group.end_batch; i-- > group.first_batch;) {
            solve_batch(moving, batches_[i]);
        }
    }
    store_impulses(group);
}

/// Finds what the rows lack with the impulses as they are.
void JointSolver::begin_gradients(const SolverBodies& moving, const JointGroup& group) {
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        const LaneMotion a(moving.motion, batch.a);
        const LaneMotion b(moving.motion, batch.b);
        for (std::uint32_t r = 0; r < batch.count; ++r) {
            RowLanes& row = batch_rows_[batch.first + r];
            row.open =
                -(speed_of(row, a, b) + (row.bias + undoing_ * row.undo) + row.soft * row.impulse);
            row.way = row.bend = lanes(0.0F);
        }
    }
    for (std::uint32_t i = group.first_slot; i < group.end_slot; ++i) {
        change_[tied_[i]].at = moving.motion[tied_[i]].at * kMassAlone;
        way_[tied_[i]] = Row8();
    }
}

/// Takes the last step in the rows, and passes over them from nothing. The largest opening, m/s and
/// rad/s, after that step.
float JointSolver::pass_forward(const JointGroup& group, float step) {
    for (std::uint32_t i = group.first_slot; i < group.end_slot; ++i) {
        change_[tied_[i]].at *= kMassAlone;
    }
    Lanes most = lanes(0.0F);
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        LaneMotion a(change_, batch.a);
        LaneMotion b(change_, batch.b);
        for (std::uint32_t r = 0; r < batch.count; ++r) {
            RowLanes& row = batch_rows_[batch.first + r];
            row.impulse += step * row.way;
            row.open -= step * row.bend;
            most = max(most, max(row.open, -row.open));
            row.more = row.mass * (row.open - speed_of(row, a, b));
            push_apart(row, row.more, a, b);
        }
        a.store(change_, batch.a);
        b.store(change_, batch.b);
    }
    return -lowest_of(-most);
}

/// The same pass back, row by row in the opposite order, so that both are one symmetric matrix.
/// Returns the product of `open` and `more`.
double JointSolver::pass_back(const JointGroup& group) {
    double sum = 0.0;
    for (std::uint32_t i = group.end_batch; i-- > group.first_batch;) {
        const JointBatch& batch = batches_[i];
        LaneMotion a(change_, batch.a);
        LaneMotion b(change_, batch.b);
        Lanes product = lanes(0.0F);
        for (std::uint32_t r = batch.count; r-- > 0;) {
            RowLanes& row = batch_rows_[batch.first + r];
            const Lanes more = row.mass * (row.open - speed_of(row, a, b) - row.soft * row.more);
            push_apart(row, more, a, b);
            row.more += more;
            product += row.open * row.more;
        }
        sum += static_cast<double>(sum_of(product));
        a.store(change_, batch.a);
        b.store(change_, batch.b);
    }
    return sum;
}

/// Turns the way to where the pass went, and `keep` times as far as before. Returns the product of
/// the way and its bend.
double JointSolver::lead_way(const JointGroup& group, float keep) {
    for (std::uint32_t i = group.first_slot; i < group.end_slot; ++i) {
        Lanes& way = way_[tied_[i]].at;
        way = change_[tied_[i]].at + keep * way;
    }
    double sum = 0.0;
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        const JointBatch& batch = batches_[i];
        const LaneMotion a(way_, batch.a);
        const LaneMotion b(way_, batch.b);
        Lanes product = lanes(0.0F);
        for (std::uint32_t r = 0; r < batch.count; ++r) {
            RowLanes& row = batch_rows_[batch.first + r];
            row.way = row.more + keep * row.way;
            row.bend = speed_of(row, a, b) + row.soft * row.way;
            product += row.way * row.bend;
        }
        sum += static_cast<double>(sum_of(product));
    }
    return sum;
}

/// Conjugate gradients for the change x of the impulses, A x = r with A = J M^-1 J^T. A pass over
/// the joints from one end of the graph to the other and back, from nothing, is the preconditioner:
/// symmetric Gauss-Seidel (Y. Saad, "Iterative methods for sparse linear systems", 2nd ed.,
/// 2003, 9.2 and 10.2). Over a sheet of n links passes alone take n^2 of them, these n. No matrix
/// is formed: what a step does to the bodies tells what it does to the rows.
void JointSolver::solve_by_gradients(SolverBodies& moving, const JointGroup& group) {
    load_impulses(group);
    begin_gradients(moving, group);
    double last = 0.0;
    float step = 0.0F;
    for (int i = 0; i < kMostGradients; ++i) {
        const float widest = pass_forward(group, step);
        step = 0.0F;
        if (!(widest * h_ > kRowSolved)) {
            break;
        }
        const double now = pass_back(group);
        const double across = lead_way(group, last > 0.0 ? static_cast<float>(now / last) : 0.0F);
        if (!(across > 0.0)) {
            break;
        }
        last = now;
        step = static_cast<float>(now / across);
        for (std::uint32_t k = group.first_slot; k < group.end_slot; ++k) {
            moving.motion[tied_[k]].at += step * (way_[tied_[k]].at * kMotionAlone);
        }
    }
    const JointBatch& end = batches_[group.end_batch - 1];
    for (std::uint32_t r = batches_[group.first_batch].first; r < end.first + end.count; ++r) {
        batch_rows_[r].impulse += step * batch_rows_[r].way;
    }
    store_impulses(group);
}

void JointSolver::solve_batch(SolverBodies& moving, const JointBatch& batch) {
    LaneMotion a(moving.motion, batch.a);
    LaneMotion b(moving.motion, batch.b);
    for (std::uint32_t r = 0; r < batch.count; ++r) {
        RowLanes& row = batch_rows_[batch.first + r];
        const Lanes wanted =
            speed_of(row, a, b) + (row.bias + undoing_ * row.undo) + row.soft * row.impulse;
        const Lanes impulse = max(min(row.impulse - row.mass * wanted, row.high), row.low);
        const Lanes change = impulse - row.impulse;
        row.impulse = impulse;
        push_apart(row, change, a, b);
    }
    a.store(moving.motion, batch.a);
    b.store(moving.motion, batch.b);
}

}  // namespace zoned::physics
