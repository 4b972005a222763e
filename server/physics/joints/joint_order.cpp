// The part of the joint solver that runs once per step: groups connected joints and orders them.
#include "server/physics/joints/joint_solver.h"

#include <algorithm>
#include <bit>

namespace zoned::physics {

namespace {

/// The error that a row would have half a substep from now, were it straight, but for what the
/// velocity does until then. The last update saw the joint half a substep ago. Since then it bent
/// by an eighth of v^T H v h^2, and half of that more turns the row's direction until the next
/// update: four eighths are the whole, as one straight move from there to here would see it.
/// `scale`: length of this step's substeps against the last one's.
float straight_error(const JointEntry& entry, float error, float scale, std::size_t row) {
    if (!(entry.substep_s > 0.0F)) {
        return error;
    }
    return entry.straight_error[row] - 2.0F * scale * (error - entry.straight_error[row]);
}

/// A factorisation that takes more multiplications than this is not worth it.
constexpr double kMostWork = 2.0e6;
/// The same where no row has bounds: conjugate gradients are worth more than plain passes.
constexpr double kMostUnboundedWork = 5.0e5;
/// Joints of a layer that would take a further color are solved one by one.
constexpr int kColors = 64;

}  // namespace

void JointSolver::reserve(std::size_t joints) {
    items_.reserve(joints);
    noted_.reserve(2 * joints);
    unordered_.reserve(joints);
    groups_.reserve(joints);
    rows_.reserve(kMostRows * joints);
    unknowns_.reserve(kMostRows * joints);
    starts_.reserve(kMostRows * joints);
    joints_of_.reserve(2 * joints);
    visited_.reserve(joints);
    queue_.reserve(joints);
}

void JointSolver::reserve_bodies(std::size_t bodies) {
    first_of_.reserve(bodies + 2);
    seen_.reserve(bodies + 2);
    tied_.reserve(bodies);
    change_.reserve(bodies + 2);
    way_.reserve(bodies + 2);
    queue_.reserve(bodies + 2);
}

void JointSolver::prepare(Bodies& bodies,
                          const JointTable& table,
                          std::span<const std::uint32_t> joints,
                          SolverBodies& moving,
                          float h,
                          float lead) {
    h_ = h;
    substeps_ = 0;
    unordered_.clear();
    for (const std::uint32_t index : joints) {
        const JointEntry& entry = table[index];
        JointItem item;
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
        unordered_.push_back(item);
    }
    order(moving);
    rows_.clear();
    for (JointItem& item : items_) {
        const JointEntry& entry = table[item.joint];
        JointRows rows;
        write_rows(entry.joint, item.pose_a, item.pose_b, rows);
        item.first = static_cast<std::uint32_t>(rows_.size());
        item.count = static_cast<std::uint32_t>(rows.count);
        const float scale = entry.substep_s > 0.0F ? h_ / entry.substep_s : 0.0F;
        for (std::size_t i = 0; i < rows.count; ++i) {
            rows_.emplace_back();
            Row& row = rows_.back();
            row.impulse = scale * entry.impulse[i];
            place_row(moving, item, rows.rows[i], row);
            row.straight_error = straight_error(entry, row.error, scale, i);
            row.sudden = lead * along(row,
                                      moving.motion[item.a].at - entry.motion[0].at,
                                      moving.motion[item.b].at - entry.motion[1].at);
        }
    }
    seen_.assign(moving.size(), Row8());
    shape_matrix();
}

/// Breadth first over the bodies that joints share, from joints at the ends of chains first: a
/// chain is as narrow as one joint, a tree nearly so.
void JointSolver::order(const SolverBodies& moving) {
    first_of_.assign(moving.size() + 1, 0);
    const auto each_slot = [&](const JointItem& item, auto&& visit) {
        for (const std::uint32_t slot : {item.a, item.b}) {
            if (slot != 0 && moving.moved_by_impulses(slot)) {
                visit(slot);
            }
        }
    };
    for (const JointItem& item : unordered_) {
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
    groups_.clear();
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
    groups_.emplace_back();
    groups_.back().first = static_cast<std::uint32_t>(begin);
    queue_.resize(std::max(queue_.size(), unordered_.size()));
    visited_[from] = 1;
    queue_[from] = static_cast<std::uint32_t>(items_.size());
    items_.push_back(unordered_[from]);
    for (std::size_t at = begin; at < items_.size(); ++at) {
        const JointItem item = items_[at];
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
                    items_.back().layer = item.layer + 1;
                }
            }
        }
    }
    groups_.back().end = static_cast<std::uint32_t>(items_.size());
}

void JointSolver::shape_matrix() {
    starts_.clear();
    batches_.clear();
    batch_rows_.clear();
    tied_.clear();
    exact_ = true;
    for (JointGroup& group : groups_) {
        group.first_row = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            JointItem& item = items_[i];
            item.earliest = item.first;
            item.group = static_cast<std::uint32_t>(&group - groups_.data());
            for (const std::uint32_t slot : {item.a, item.b}) {
                for (std::uint32_t k = first_of_[slot]; slot != 0 && k < first_of_[slot + 1]; ++k) {
                    item.earliest = std::min(item.earliest, items_[joints_of_[k]].first);
                }
            }
            starts_.insert(starts_.end(), item.count, item.earliest);
            for (std::uint32_t r = item.first; r < item.first + item.count; ++r) {
                const RowKind kind = rows_[r].kind;
                group.bounded |= kind == RowKind::kLimit || kind == RowKind::kMotor;
                group.springy |= kind == RowKind::kSpring;
            }
        }
        group.end_row = static_cast<std::uint32_t>(starts_.size());
        const auto shape = std::span(starts_).subspan(group.first_row);
        group.direct = EnvelopeSolver::cost(shape, group.first_row) <=
                       (group.bounded ? kMostWork : kMostUnboundedWork);
        exact_ &= group.direct;
        if (!group.direct) {
            for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
                starts_[r] = r;
            }
            batch_joints(group);
        }
    }
    if (!exact_) {
        change_.assign(seen_.size(), Row8());
        way_.assign(seen_.size(), Row8());
    }
    matrix_.shape(starts_);
    unknowns_.assign(starts_.size(), 0.0);
}

/// Layers are in the order of the walk, so that one pass carries from one end of the graph to the
/// other. Within a layer, joints of one color come before those of the next.
void JointSolver::batch_joints(JointGroup& group) {
    colors_.resize(std::max(colors_.size(), seen_.size()), 0);
    group.first_batch = static_cast<std::uint32_t>(batches_.size());
    for (std::uint32_t begin = group.first; begin < group.end;) {
        std::uint32_t end = begin;
        while (end < group.end && items_[end].layer == items_[begin].layer) {
            ++end;
        }
        batch_layer(begin, end);
        begin = end;
    }
    group.end_batch = static_cast<std::uint32_t>(batches_.size());
    list_tied(group);
    for (std::uint32_t i = group.first_batch; i < group.end_batch; ++i) {
        batches_[i].first = static_cast<std::uint32_t>(batch_rows_.size());
        batch_rows_.resize(batch_rows_.size() + batches_[i].count);
    }
}

/// The bodies that its joints move.
void JointSolver::list_tied(JointGroup& group) {
    group.first_slot = static_cast<std::uint32_t>(tied_.size());
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (const std::uint32_t slot : {items_[i].a, items_[i].b}) {
            if (first_of_[slot] != first_of_[slot + 1] && joints_of_[first_of_[slot]] == i) {
                tied_.push_back(slot);
            }
        }
    }
    group.end_slot = static_cast<std::uint32_t>(tied_.size());
}

void JointSolver::batch_layer(std::uint32_t begin, std::uint32_t end) {
    const auto moves = [this](std::uint32_t slot) {
        return first_of_[slot] != first_of_[slot + 1];
    };
    color_of_.resize(end - begin);
    int colors = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
        const JointItem& item = items_[i];
        const std::uint64_t taken = colors_[item.a] | colors_[item.b];
        const int color = std::countr_one(taken);
        for (const std::uint32_t slot : {item.a, item.b}) {
            if (moves(slot) && color < kColors) {
                colors_[slot] |= std::uint64_t{1} << color;
            }
        }
        color_of_[i - begin] = static_cast<std::uint8_t>(color);
        colors = std::max(colors, color + 1);
    }
    for (int color = 0; color < colors; ++color) {
        std::size_t lane = 0;
        for (std::uint32_t i = begin; i < end; ++i) {
            if (color_of_[i - begin] == color) {
                if (lane == 0) {
                    batches_.emplace_back();
                    batches_.back().item.fill(kNoIndex);
                }
                JointBatch& batch = batches_.back();
                batch.item[lane] = i;
                batch.a[lane] = items_[i].a;
                batch.b[lane] = items_[i].b;
                batch.count = std::max(batch.count, items_[i].count);
                lane = lane + 1 < kLanes && color < kColors ? lane + 1 : 0;
            }
        }
    }
    for (std::uint32_t i = begin; i < end; ++i) {
        colors_[items_[i].a] = 0;
        colors_[items_[i].b] = 0;
    }
}

}  // namespace zoned::physics
