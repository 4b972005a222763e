// build: hot loops
#include "server/physics/joints/joint_solver.h"

#include "server/physics/integrator/integrate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics {

namespace {

/// A row gives way under its impulse by this share of what its bodies would. Redundant rows of
/// loops differ by the rounding of floats, 1e-7: without this share that difference would be
/// divided by itself, and impulses that cancel each other would grow for ever. Under R times the
/// weight of its own bodies a joint gapes by this times R g h kUndoTime: with R = 1e5 by 0.2 mm.
constexpr float kGive = 1.0e-6F;
/// A row of which others leave no larger share follows from them: twice kGive is left of the
/// diagonal of one that stands twice. It gets no impulse. If it contradicts them, no impulse could
/// help, and the attempt would drown velocities in rounding.
constexpr double kLeastShare = 3.0e-6;
/// The same for limits and motors, and more: a motor that drives into a limit, or against the other
/// motors of a loop, contradicts them. It has to reach its bound and let go, so that neither row
/// may follow from the other.
constexpr float kBoundedGive = 1.0e-5F;
/// What contacts and other joints left of an error is undone within this time, s, and no faster
/// than this, m/s and rad/s: a torn joint (a body that was teleported) closes within sight, not at
/// once.
constexpr float kUndoTime = 0.05F;
constexpr float kUndoSpeed = 20.0F;
/// Slower than this nothing needs to be taken back, m/s and rad/s.
constexpr float kUndoStill = 1.0e-4F;
/// A limit that is passed is left no faster than this besides. A limit that a graph's other joints
/// hold passed would throw the body that it pushes.
constexpr float kLimitSpeed = 1.0F;
/// Joints that contacts open by more than this in a substep are solved again, m and rad.
constexpr float kOpens = 5.0e-4F;
/// How often the set of limits and motors that hold is corrected.
constexpr int kRounds = 4;
/// A limit that closes slower than this does not take hold, m/s and rad/s.
constexpr float kStill = 1.0e-6F;

Row8 row_of(const Vec3& v, const Vec3& w) {
    return {Lanes{v.x(), v.y(), v.z(), 0.0F, w.x(), w.y(), w.z(), 0.0F}};
}

}  // namespace

Row8 JointSolver::give(const SolverBodies& moving,
                       std::uint32_t slot,
                       const Vec3& push,
                       const Vec3& moment) {
    return moving.moved_by_impulses(slot)
               ? row_of(moving.motion[slot].at[3] * push, moving.inverse_times(slot, moment))
               : Row8();
}

/// How fast a point leaves its place because its body turns: in a substep of h at w, the arm's end
/// goes by (w h)^2 / 2 of the arm out of its circle. Twice that, and no more than w h = 1/2
/// accounts for: a speed that grew with itself would have no bound. `arm`: its length, m; 1 for an
/// angle.
float JointSolver::gape(const SolverBodies& moving, std::uint32_t slot, float arm) const {
    const float rate = SolverBodies::angular(moving.motion[slot]).norm();
    return std::min(rate * h_, 0.5F) * rate * arm;
}

/// How fast the two points of a rod leave its length because the rod turns.
float JointSolver::swing(const SolverBodies& moving, const JointItem& item, float length) const {
    const float speed =
        (SolverBodies::linear(moving.motion[item.b]) - SolverBodies::linear(moving.motion[item.a]))
            .norm();
    return std::min(speed * h_, 0.5F * length) * speed / std::max(length, 1.0e-3F);
}

void JointSolver::update(const JointTable& table, const SolverBodies& moving) {
    undoing_ = 1.0F;
    const auto pose = [&](const JointPose& start, const Quat& q, std::uint32_t slot) {
        if (slot == 0) {
            return start;
        }
        return JointPose{start.position + SolverBodies::linear(moving.drift[slot]),
                         moving.orientation(slot, q).toRotationMatrix()};
    };
    JointRows rows;
    for (const JointItem& item : items_) {
        const Joint& joint = table[item.joint].joint;
        const JointPose place_a = pose(item.pose_a, item.orientation_a, item.a);
        const JointPose place_b = pose(item.pose_b, item.orientation_b, item.b);
        write_rows(joint, place_a, place_b, rows);
        // A slider's arm reaches as far as b has moved along it.
        const float reach = joint.def.kind == JointKind::kSlider
                                ? (place_b.position - place_a.position).norm()
                                : 0.0F;
        const float bend =
            gape(moving, item.a, joint.local_a.norm() + reach + 1.0F) +
            gape(moving, item.b, joint.local_b.norm() + 1.0F) +
            (joint.def.kind == JointKind::kDistance ? swing(moving, item, joint.length) : 0.0F);
        for (std::size_t i = 0; i < rows.count; ++i) {
            Row& row = rows_[item.first + i];
            row.straight_error += moved(moving, item, row);
            place_row(moving, item, rows.rows[i], row);
            update_row(moving, item, rows.rows[i], bend, row);
        }
        restrain_motor(item);
    }
    seen_ = moving.drift;
}

/// How far the bodies moved the row since it was last updated, were it straight.
float JointSolver::moved(const SolverBodies& moving, const JointItem& item, const Row& row) const {
    return along(row,
                 moving.drift[item.a].at - seen_[item.a].at,
                 moving.drift[item.b].at - seen_[item.b].at);
}

void JointSolver::place_row(const SolverBodies& moving,
                            const JointItem& item,
                            const JointRow& from,
                            Row& row) {
    row.along_a = row_of(-from.linear, from.angular_a);
    row.along_b = row_of(from.linear, from.angular_b);
    row.give_a = give(moving, item.a, -from.linear, from.angular_a);
    row.give_b = give(moving, item.b, from.linear, from.angular_b);
    row.push_a = row.give_a;
    row.push_b = row.give_b;
    row.response = along(row, row.give_a.at, row.give_b.at);
    row.error = from.error;
    row.kind = from.kind;
}

void JointSolver::update_row(const SolverBodies& moving,
                             const JointItem& item,
                             const JointRow& from,
                             float bend,
                             Row& row) const {
    constexpr float kInfinite = std::numeric_limits<float>::infinity();
    row.soft = 0.0F;
    row.undo = 0.0F;
    row.low = -kInfinite;
    row.high = kInfinite;
    switch (row.kind) {
        case RowKind::kHard:
            row.soft = kGive * row.response;
            aim_hard(bend, row);
            break;
        case RowKind::kLimit:
            row.soft = kBoundedGive * row.response;
            row.undo = std::clamp(row.error / kUndoTime, -kLimitSpeed, 0.0F);
            row.bias = std::max(row.error, 0.0F) / h_;
            row.low = 0.0F;
            break;
        case RowKind::kMotor:
            row.soft = kBoundedGive * row.response;
            row.bias = -from.target;
            row.high = from.most * h_;
            row.low = -row.high;
            break;
        case RowKind::kSpring:
            update_spring(moving, item, *from.spring, row);
            break;
    }
}

/// A motor drives no further than its own limits: what it wants agrees with what they grant. If the
/// two rows contradicted each other, either would give way by as much as it is soft.
void JointSolver::restrain_motor(const JointItem& item) {
    const auto rows = std::span(rows_).subspan(item.first, item.count);
    const auto motor = std::find_if(
        rows.begin(), rows.end(), [](const Row& row) { return row.kind == RowKind::kMotor; });
    if (motor == rows.end()) {
        return;
    }
    float target = -motor->bias;
    float undone = target;  // the same while velocities undo errors
    float way = 1.0F;       // of the lower limit, then of the upper one
    for (auto limit = motor + 1; limit != rows.end() && limit->kind == RowKind::kLimit; ++limit) {
        target = way * std::max(way * target, -limit->bias);
        undone = way * std::max(way * undone, -limit->bias - limit->undo);
        way = -way;
    }
    motor->bias = -target;
    motor->undo = target - undone;
}

/// An error has two parts. One is new: bodies went in straight lines where their joints bend, by no
/// more than `bend`, or somebody pushed them since the last step. SHAKE undoes it at once, and
/// keeps the energy by that. The rest is what velocities left open that contacts changed after the
/// joints had been solved. Undone at once it would push into those contacts again, harder with each
/// substep. It is undone within kUndoTime, by velocities that last for one substep (see `relax`).
void JointSolver::aim_hard(float bend, Row& row) const {
    const float most = h_ * bend;
    const float bent = std::clamp(row.error - row.straight_error, -most, most) + row.sudden;
    row.sudden = 0.0F;
    row.undo = std::clamp((row.error - bent) / std::max(kUndoTime, h_), -kUndoSpeed, kUndoSpeed);
    row.bias = bent / h_;
    row.straight_error = row.error;
}

bool JointSolver::relax() {
    undoing_ = 0.0F;
    return std::any_of(
        rows_.begin(), rows_.end(), [](const Row& row) { return std::abs(row.undo) > kUndoStill; });
}

/// The implicit midpoint rule for a spring of stiffness k and damping c: with x in the middle of
/// the substep and speeds v before and w after it, its impulse is
///
///     p = -h k (x + h / 4 ((1 + m) w - (1 - m) v)) - h c (t w + (1 - t) v)
///
/// with m = 0 and t = 1/2, which keeps the energy of an undamped spring however stiff it is. Where
/// the damping is too strong for the step and the effective mass at the anchors, t and m go up to
/// 1, implicit Euler's, which do not ring.
void JointSolver::update_spring(const SolverBodies& moving,
                                const JointItem& item,
                                const JointDef& def,
                                Row& row) const {
    const float inverse_mass = moving.motion[item.a].at[3] + moving.motion[item.b].at[3];
    const SpringConstants spring = spring_constants(def, static_cast<double>(inverse_mass));
    const float pull = static_cast<float>(spring.k) * h_;  // impulse per metre
    const float drag = static_cast<float>(spring.c) * h_;
    const float fade = drag * row.response;
    const float t = fade > 2.0F ? 1.0F - 1.0F / fade : 0.5F;
    const float m = std::min(1.0F, 0.5F * fade * std::sqrt(pull * h_ * row.response));
    const float after = 0.25F * pull * h_ * (1.0F + m) + drag * t;
    if (!(after > 0.0F)) {
        row.low = row.high = 0.0F;
        row.bias = 0.0F;
        return;
    }
    const float before = drag * (1.0F - t) - 0.25F * pull * h_ * (1.0F - m);
    row.soft = 1.0F / after;
    row.bias = (pull * row.error + before * speed(moving, item, row)) / after;
}

void JointSolver::warm_start(SolverBodies& moving) {
    for (const JointItem& item : items_) {
        for (std::size_t i = item.first; i < item.first + item.count; ++i) {
            rows_[i].impulse = std::clamp(rows_[i].impulse, rows_[i].low, rows_[i].high);
            apply(moving, item, rows_[i], rows_[i].impulse);
        }
    }
    for (const JointGroup& group : groups_) {
        if (group.direct) {
            choose_held(moving, group);
            factor(group);
        } else {
            fill_batches(group);
        }
    }
}

/// Motors hold that have force left, limits that carry or are about to be reached.
void JointSolver::choose_held(const SolverBodies& moving, const JointGroup& group) {
    for (std::uint32_t i = group.first; group.bounded && i < group.end; ++i) {
        for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
            Row& row = rows_[r];
            if (row.kind == RowKind::kMotor) {
                row.held = row.impulse > row.low && row.impulse < row.high;
            } else if (row.kind == RowKind::kLimit) {
                row.held =
                    row.impulse > 0.0F || speed(moving, items_[i], row) + bias_of(row) < -kStill;
            }
        }
    }
}

void JointSolver::factor(const JointGroup& group) {
    matrix_.clear(group.first_row, group.end_row);
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        assemble(items_[i]);
    }
    for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
        double& diagonal = matrix_.at(r, r);
        diagonal = rows_[r].held ? diagonal + static_cast<double>(rows_[r].soft) : 1.0;
    }
    matrix_.factor(group.first_row, group.end_row, kLeastShare);
}

void JointSolver::assemble(const JointItem& item) {
    for (const std::uint32_t slot : {item.a, item.b}) {
        for (std::size_t first = 0; slot != 0 && first < item.count; first += kLanes) {
            add_column_blocks(item, first, slot);
        }
    }
}

/// The effect of impulses of up to eight of q's rows, from this one on, on the speeds of the rows
/// before and of its own, through one body. A row that does not hold has none.
void JointSolver::add_column_blocks(const JointItem& q, std::size_t first, std::uint32_t slot) {
    Block8 give;
    for (std::size_t i = 0; i < kLanes; ++i) {
        const Row* row = first + i < q.count ? &rows_[q.first + first + i] : nullptr;
        const bool held = row != nullptr && row->held;
        give.row[i] = held ? (q.b == slot ? row->give_b : row->give_a).at : lanes(0.0F);
    }
    transpose(give);
    for (std::uint32_t k = first_of_[slot]; k < first_of_[slot + 1]; ++k) {
        const JointItem& p = items_[joints_of_[k]];
        if (p.first > q.first) {
            continue;
        }
        for (std::size_t i = p.first; i < p.first + p.count; ++i) {
            const Row& row = rows_[i];
            if (row.held) {
                const Lanes& along = (p.b == slot ? row.along_b : row.along_a).at;
                matrix_.add_column(
                    q.first + first,
                    i,
                    (along[0] * give.row[0] + along[1] * give.row[1] + along[2] * give.row[2]) +
                        (along[4] * give.row[4] + along[5] * give.row[5] + along[6] * give.row[6]));
            }
        }
    }
}

/// What motions or shifts of the two bodies are to the row.
float JointSolver::along(const Row& row, const Lanes& a, const Lanes& b) {
    return sum_of(row.along_a.at * a + row.along_b.at * b);
}

float JointSolver::speed(const SolverBodies& moving, const JointItem& item, const Row& row) {
    return along(row, moving.motion[item.a].at, moving.motion[item.b].at);
}

void JointSolver::apply(SolverBodies& moving,
                        const JointItem& item,
                        const Row& row,
                        float impulse) {
    moving.motion[item.a].at += impulse * row.push_a.at;
    moving.motion[item.b].at += impulse * row.push_b.at;
}

void JointSolver::move_impulse(SolverBodies& moving,
                               const JointItem& item,
                               Row& row,
                               float impulse) {
    const float to = std::clamp(impulse, row.low, row.high);
    apply(moving, item, row, to - row.impulse);
    row.impulse = to;
}

void JointSolver::solve(SolverBodies& moving) {
    for (const JointGroup& group : groups_) {
        solve(moving, group);
    }
}

void JointSolver::solve(SolverBodies& moving, const JointGroup& group) {
    if (group.direct) {
        solve_group(moving, group);
    } else {
        solve_singly(moving, group);
    }
}

void JointSolver::solve_around(SolverBodies& moving, std::uint32_t slot_a, std::uint32_t slot_b) {
    for_each_around(slot_a, slot_b, [&](const JointGroup& group) { solve(moving, group); });
}

void JointSolver::begin_blow(std::uint32_t slot_a, std::uint32_t slot_b) {
    for_each_around(slot_a, slot_b, [this](const JointGroup& group) {
        hold_springs(group, false);
        for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
            rows_[r].noted = rows_[r].impulse;
        }
    });
}

void JointSolver::end_blow(std::uint32_t slot_a, std::uint32_t slot_b) {
    for_each_around(slot_a, slot_b, [this](const JointGroup& group) { hold_springs(group, true); });
}

void JointSolver::hold_springs(const JointGroup& group, bool held) {
    if (!group.springy) {
        return;
    }
    for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
        if (rows_[r].kind == RowKind::kSpring) {
            rows_[r].held = held;
        }
    }
    factor(group);
}

void JointSolver::restore_impulses(std::uint32_t slot_a, std::uint32_t slot_b, float left) {
    for_each_around(slot_a, slot_b, [this, left](const JointGroup& group) {
        for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
            Row& row = rows_[r];
            row.impulse = row.noted + (left > 0.0F ? left * (row.impulse - row.noted) : 0.0F);
        }
    });
}

float JointSolver::work_of_movers(const SolverBodies& moving,
                                  std::uint32_t slot_a,
                                  std::uint32_t slot_b) const {
    const auto motion = [&](std::uint32_t slot) {
        return moving.moved_by_impulses(slot) ? Lanes() : moving.motion[slot].at;
    };
    float work = 0.0F;
    for_each_around(slot_a, slot_b, [&](const JointGroup& group) {
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            const Lanes a = motion(items_[i].a);
            const Lanes b = motion(items_[i].b);
            for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
                work -= (rows_[r].impulse - rows_[r].noted) * along(rows_[r], a, b);
            }
        }
    });
    return work;
}

std::uint32_t JointSolver::group_of(std::uint32_t slot) const {
    if (items_.empty() || first_of_[slot] == first_of_[slot + 1]) {
        return kNoIndex;
    }
    const std::uint32_t group = items_[joints_of_[first_of_[slot]]].group;
    return groups_[group].direct ? group : kNoIndex;
}

/// Of the limits and motors those hold that carry or can still push. Each round ends with hard rows
/// solved for the bounded ones as they are. If an impulse were cut off at a bound without solving
/// again for the rest, they would pull against nothing.
void JointSolver::solve_group(SolverBodies& moving, const JointGroup& group) {
    for (int round = 1;; ++round) {
        find_unknowns(moving, group);
        while (group.bounded && release(moving, group)) {  // fewer rows hold each time
            factor(group);
            find_unknowns(moving, group);
        }
        apply_unknowns(moving, group);
        if (!group.bounded || round == kRounds || !take_hold(moving, group)) {
            return;
        }
        factor(group);
    }
}

/// The changes of all held impulses that bring their rows to rest.
void JointSolver::find_unknowns(const SolverBodies& moving, const JointGroup& group) {
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        const JointItem& item = items_[i];
        for (std::size_t r = item.first; r < item.first + item.count; ++r) {
            const Row& row = rows_[r];
            unknowns_[r] = row.held ? -static_cast<double>(speed(moving, item, row) + bias_of(row) +
                                                           row.soft * row.impulse)
                                    : 0.0;
        }
    }
    matrix_.solve(unknowns_, group.first_row, group.end_row);
}

/// The share of its unknown that brings a row to a bound; infinite: none within bounds that there
/// are.
double JointSolver::share_to_bound(const Row& row, double unknown) {
    const float bound = unknown < 0.0 ? row.low : row.high;
    if (!row.held || unknown == 0.0 || std::isinf(bound)) {
        return std::numeric_limits<double>::infinity();
    }
    const double way = static_cast<double>(bound) - static_cast<double>(row.impulse);
    return std::max(0.0, way / unknown);
}

/// Goes as far as the first bound; rows there hold no longer. True if there are any, and then the
/// others have to be solved for anew. Each such step lowers the energy of the impulses. A full step
/// with a cut at the bounds might not (the primal active-set method: J. Nocedal, S. J. Wright,
/// "Numerical Optimization", 2nd ed., 16.5).
bool JointSolver::release(SolverBodies& moving, const JointGroup& group) {
    double share = 1.0;
    for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
        if (rows_[r].kind != RowKind::kHard) {  // most rows are, and have no bounds
            share = std::min(share, share_to_bound(rows_[r], unknowns_[r]));
        }
    }
    if (share >= 1.0) {
        return false;
    }
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
            Row& row = rows_[r];
            if (!row.held) {
                continue;
            }
            const bool there = share_to_bound(row, unknowns_[r]) <= share;
            const float bound = unknowns_[r] < 0.0 ? row.low : row.high;
            const auto step = static_cast<float>(share * unknowns_[r]);
            move_impulse(moving, items_[i], row, there ? bound : row.impulse + step);
            row.held = !there;
        }
    }
    return true;
}

/// Limits that close and motors that push too far hold again; true if there are any.
bool JointSolver::take_hold(const SolverBodies& moving, const JointGroup& group) {
    bool any = false;
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
            Row& row = rows_[r];
            if (row.held || row.low == row.high) {
                continue;
            }
            const float over =
                speed(moving, items_[i], row) + bias_of(row) + row.soft * row.impulse;
            if ((row.impulse <= row.low && over < -kStill) ||
                (row.impulse >= row.high && over > kStill)) {
                row.held = true;
                any = true;
            }
        }
    }
    return any;
}

void JointSolver::apply_unknowns(SolverBodies& moving, const JointGroup& group) {
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
            if (rows_[r].held) {
                move_impulse(moving,
                             items_[i],
                             rows_[r],
                             rows_[r].impulse + static_cast<float>(unknowns_[r]));
            }
        }
    }
}

bool JointSolver::close(SolverBodies& moving) {
    bool any = false;
    for (const JointGroup& group : groups_) {
        if (opens(moving, group)) {
            solve(moving, group);
            any = true;
        }
    }
    return any;
}

bool JointSolver::opens(const SolverBodies& moving, const JointGroup& group) const {
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
            const Row& row = rows_[r];
            const float left =
                speed(moving, items_[i], row) + bias_of(row) + row.soft * row.impulse;
            if (row.kind == RowKind::kHard && std::abs(left) * h_ > kOpens) {
                return true;
            }
        }
    }
    return false;
}

void JointSolver::add_totals() {
    ++substeps_;
    for (JointItem& item : items_) {
        for (std::size_t r = item.first; r < item.first + item.count; ++r) {
            item.carried += rows_[r].impulse * SolverBodies::linear(rows_[r].along_b);
        }
    }
}

void JointSolver::store(JointTable& table, const SolverBodies& moving) const {
    for (const JointItem& item : items_) {
        JointEntry& entry = table[item.joint];
        float sum = 0.0F;
        for (std::size_t i = 0; i < item.count; ++i) {
            const Row& row = rows_[item.first + i];
            entry.impulse[i] = row.impulse;
            entry.straight_error[i] = row.straight_error + moved(moving, item, row);
            sum += entry.impulse[i];
        }
        if (!std::isfinite(sum)) {
            entry.impulse.fill(0.0F);  // the bodies are stopped; nobody shall inherit it
        }
        entry.motion = {moving.motion[item.a], moving.motion[item.b]};
        entry.substep_s = h_;
        entry.force_n = item.carried.norm() / (h_ * static_cast<float>(substeps_));
    }
}

}  // namespace zoned::physics
