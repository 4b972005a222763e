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

void JointSolver::solve_batch(SolverBodies& moving, const JointBatch& batch) {
    LaneMotion a(moving.motion, batch.a);
    LaneMotion b(moving.motion, batch.b);
    for (std::uint32_t r = 0; r < batch.count; ++r) {
        RowLanes& row = batch_rows_[batch.first + r];
        const Lanes speed = dot(row.linear, b.velocity - a.velocity) +
                            (dot(row.angular_a, a.spin) + dot(row.angular_b, b.spin));
        const Lanes wanted = speed + (row.bias + undoing_ * row.undo) + row.soft * row.impulse;
        const Lanes impulse = max(min(row.impulse - row.mass * wanted, row.high), row.low);
        const Lanes change = impulse - row.impulse;
        row.impulse = impulse;
        a.change(-change * row.linear, change * row.turn_a);
        b.change(change * row.linear, change * row.turn_b);
    }
    a.store(moving.motion, batch.a);
    b.store(moving.motion, batch.b);
}

}  // namespace zoned::physics
