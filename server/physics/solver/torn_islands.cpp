#include "server/physics/solver/torn_islands.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace zoned::physics {

namespace {

/// Repeats of a step may always visit so many contacts and joints: thirty of each 128 times.
constexpr std::size_t kLeastVisits = 8192;
/// Repeats of a step may visit so many times what its first solve visits: all of it with twice the
/// substeps.
constexpr std::size_t kRepeated = 2;
/// Where the most substeps do not suffice, up to so many passes in each of them may.
constexpr int kMostSweeps = 8 * SubstepPolicy::kMostSubsteps;
/// A joint that was open already is torn when it opens further by this share of the gap in
/// kOpenedWithin, s.
constexpr float kOpened = 0.1F;
constexpr float kOpenedWithin = 1.0F / 60.0F;
/// An island gains no more energy than what its motors may do, this share of its energy of motion
/// ...
constexpr float kGain = 0.03F;
/// ... and that of this speed, m/s: contacts push apart what overlaps.
constexpr float kOverlapSpeed = 0.1F;

/// How far the anchors are from where the joint holds them, m. A wrong angle counts by its arc on
/// the smaller body.
float gap_of(const Bodies& bodies, const JointEntry& entry) {
    const Vec3 origin = bodies.position[entry.b];
    const JointPose a = entry.a == kNoIndex ? JointPose{-origin, Mat3::Identity()}
                                            : JointPose{bodies.position[entry.a] - origin,
                                                        bodies.rotation[entry.a]};
    JointRows rows;
    write_rows(entry.joint, a, {Vec3::Zero(), bodies.rotation[entry.b]}, rows);
    float apart = 0.0F;
    float turned = 0.0F;
    for (std::size_t i = 0; i < rows.count; ++i) {
        const JointRow& row = rows.rows[i];
        if (row.kind == RowKind::kHard) {
            (row.linear.isZero(0.0F) ? turned : apart) += row.error * row.error;
        }
    }
    const float arm = entry.a == kNoIndex
                          ? bodies.radius[entry.b]
                          : std::min(bodies.radius[entry.a], bodies.radius[entry.b]);
    return std::sqrt(apart) + arm * std::sqrt(turned);
}

std::uint32_t row_of(const Bodies& bodies, const JointEntry& entry) {
    return bodies.simulated(entry.b) ? entry.b : entry.a;
}

std::uint32_t row_of(const Bodies& bodies, const Pair& pair) {
    return bodies.simulated(pair.a) ? pair.a : pair.b;
}

/// Energy that a joint's spring holds, J.
float stored_in(const Bodies& bodies, const JointEntry& entry) {
    const Joint& joint = entry.joint;
    if (joint.def.kind != JointKind::kSpring) {
        return 0.0F;
    }
    const auto anchor = [&](std::uint32_t row, const Vec3& local) {
        return Vec3(bodies.position[row] + bodies.rotation[row] * local);
    };
    const bool held = entry.a == kNoIndex;
    const Vec3 on_a = held ? joint.local_a : anchor(entry.a, joint.local_a);
    const float stretch = (anchor(entry.b, joint.local_b) - on_a).norm() - joint.length;
    const float inverse_mass =
        (bodies.simulated(entry.b) ? bodies.inv_mass[entry.b] : 0.0F) +
        (!held && bodies.simulated(entry.a) ? bodies.inv_mass[entry.a] : 0.0F);
    const SpringConstants spring = spring_constants(joint.def, static_cast<double>(inverse_mass));
    return 0.5F * static_cast<float>(spring.k) * stretch * stretch;
}

/// The most that a joint's motor can do in a step, J: faster than its target it brakes.
float motor_work(const JointDef& def, float dt) {
    return def.motor ? def.motor_max * std::abs(def.motor_speed) * dt : 0.0F;
}

bool moves(const Bodies& bodies, std::uint32_t row) {
    return !bodies.velocity[row].isZero(0.0F) || !bodies.angular_velocity[row].isZero(0.0F);
}

/// Energy of motion, J.
float motion_energy(const Bodies& bodies,
                    std::uint32_t row,
                    const Mat3& rotation,
                    const Vec3& velocity,
                    const Vec3& spin) {
    const Vec3 local = bodies.inertia_axes(row, rotation).transpose() * spin;
    return 0.5F * (velocity.squaredNorm() / bodies.inv_mass[row] +
                   bodies.inertia[row].dot(local.cwiseAbs2()));
}

}  // namespace

void TornIslands::reserve(std::size_t bodies, std::size_t contacts) {
    for (auto* islands : {&torn_, &last_, &hopeless_}) {
        islands->reserve(bodies);
    }
    energy_.reserve(bodies);
    rows_.reserve(bodies);
    noted_joints_.reserve(bodies);
    joints_.reserve(bodies);
    noted_contacts_.reserve(contacts);
    contacts_.reserve(contacts);
}

void TornIslands::begin_step(std::size_t visits, const TearLimits& limits) {
    limits_ = limits;
    opening_m_ = kOpened * limits.gap_m * std::min(limits.dt_s / kOpenedWithin, 1.0F);
    visits_left_ = std::max(kRepeated * visits, kLeastVisits);
    given_up_ = 0;
}

void TornIslands::note(const StepView& view, const SubstepPolicy::SubstepBatch& batch) {
    noted_contacts_.clear();
    noted_joints_.clear();
    last_.clear();
    hopeless_.clear();
    for (const std::uint32_t index : batch.contacts) {
        noted_contacts_.push_back({index, view.graph[index]});
    }
    for (const std::uint32_t index : batch.joints) {
        const JointEntry& entry = view.table[index];
        noted_joints_.push_back(
            {index, entry, gap_of(view.bodies, entry), stored_in(view.bodies, entry)});
    }
    list_rows(view);
}

void TornIslands::list_rows(const StepView& view) {
    rows_.clear();
    listed_.resize(view.bodies.rows());
    const auto list = [&](std::uint32_t row) {
        if (row != kNoIndex && view.bodies.simulated(row) && listed_[row] == 0) {
            listed_[row] = 1;
            rows_.push_back(row);
        }
    };
    for (const NotedContact& noted : noted_contacts_) {
        list(view.graph.pair(noted.index).a);
        list(view.graph.pair(noted.index).b);
    }
    for (const NotedJoint& noted : noted_joints_) {
        list(view.table[noted.index].a);
        list(view.table[noted.index].b);
    }
    for (const std::uint32_t row : rows_) {
        listed_[row] = 0;
    }
}

const TornIslands::TornIsland* TornIslands::find(std::span<const TornIsland> some,
                                                 std::uint32_t island) {
    const auto at = std::lower_bound(
        some.begin(), some.end(), island, [](const TornIsland& torn, std::uint32_t wanted) {
            return torn.island < wanted;
        });
    return at != some.end() && at->island == island ? &*at : nullptr;
}

/// The energy that each island has won or lost in the step.
void TornIslands::weigh(const StepView& view) {
    const Bodies& bodies = view.bodies;
    energy_.resize(bodies.awake_list.size());
    for (const std::uint32_t row : rows_) {
        energy_[view.islands.island_of(row)] = {};
    }
    const float g = limits_.gravity.norm();
    for (const std::uint32_t row : rows_) {
        if (bodies.inv_mass[row] == 0.0F) {
            continue;
        }
        const StepStart& start = view.starts[row];
        const float mass = 1.0F / bodies.inv_mass[row];
        const float before = motion_energy(
            bodies, row, start.orientation.toRotationMatrix(), start.velocity, start.spin);
        const float after = motion_energy(
            bodies, row, bodies.rotation[row], bodies.velocity[row], bodies.angular_velocity[row]);
        const float fall = limits_.gravity.dot(bodies.position[row] - start.position);
        IslandEnergy& energy = energy_[view.islands.island_of(row)];
        energy.gain += after - before - mass * fall;
        energy.motion += after;
        energy.allowed +=
            kGain * before + mass * (0.5F * kOverlapSpeed * kOverlapSpeed + g * limits_.gap_m);
        energy.driven |= !bodies.force[row].isZero(0.0F) || !bodies.torque[row].isZero(0.0F);
    }
    for (const NotedContact& noted : noted_contacts_) {
        const Pair& pair = view.graph.pair(noted.index);
        IslandEnergy& energy = energy_[view.islands.island_of(row_of(bodies, pair))];
        for (const std::uint32_t row : {pair.a, pair.b}) {
            energy.driven |= !bodies.simulated(row) && moves(bodies, row);
            energy.held |= !bodies.simulated(row);
        }
    }
    for (const NotedJoint& noted : noted_joints_) {
        const JointEntry& entry = view.table[noted.index];
        IslandEnergy& energy = energy_[view.islands.island_of(row_of(bodies, entry))];
        energy.gain += stored_in(bodies, entry) - noted.stored;
        energy.allowed += motor_work(entry.joint.def, limits_.dt_s);
        const bool held = entry.a == kNoIndex || !bodies.simulated(entry.a);
        energy.driven |= held && entry.a != kNoIndex && moves(bodies, entry.a);
        energy.held |= held;
    }
}

/// Lists the islands that are torn now.
void TornIslands::judge(const StepView& view,
                        std::span<const std::uint32_t> passed,
                        std::span<const std::uint32_t> broken) {
    weigh(view);
    torn_.clear();
    for (const std::uint32_t row : passed) {
        torn_.push_back({view.islands.island_of(row)});
    }
    for (const NotedJoint& noted : noted_joints_) {
        const JointEntry& entry = view.table[noted.index];
        const std::uint32_t island = view.islands.island_of(row_of(view.bodies, entry));
        const bool stopped = std::any_of(broken.begin(), broken.end(), [&](std::uint32_t row) {
            return row == entry.a || row == entry.b;
        });
        const float gap = gap_of(view.bodies, entry);
        const bool opened = gap > limits_.gap_m && gap > noted.gap + opening_m_;
        const IslandEnergy& energy = energy_[island];
        if (stopped || opened || !(energy.over() <= 0.0F)) {
            torn_.push_back({island, stopped ? INFINITY : gap, 0, energy.over()});
        }
    }
    sort_islands(torn_);
}

/// By island, each once, with its largest gap.
void TornIslands::sort_islands(std::vector<TornIsland>& some) {
    std::sort(some.begin(), some.end(), [](const TornIsland& a, const TornIsland& b) {
        return std::tuple(a.island, -a.gap) < std::tuple(b.island, -b.gap);
    });
    const auto same = [](const TornIsland& a, const TornIsland& b) {
        return a.island == b.island;
    };
    some.erase(std::unique(some.begin(), some.end(), same), some.end());
}

/// Islands whose joints are open further than before the repeat, or which gained more energy: more
/// substeps do not help them.
void TornIslands::drop_hopeless() {
    std::erase_if(torn_, [this](const TornIsland& now) {
        const TornIsland* before = find(last_, now.island);
        const bool worse = before != nullptr &&
                           (now.gap > limits_.gap_m ? now.gap >= before->gap
                                                    : now.over > 0.0F && now.over >= before->over);
        if (worse) {
            hopeless_.push_back(now);
            ++given_up_;
        }
        return worse;
    });
}

/// The islands for whose repeats there are visits left, the first ones first.
void TornIslands::keep_affordable(const StepView& view, int substeps) {
    const auto count = [&](std::uint32_t row) {
        const TornIsland* torn = find(torn_, view.islands.island_of(row));
        if (torn != nullptr) {
            ++torn_[static_cast<std::size_t>(torn - torn_.data())].visits;
        }
    };
    for (const NotedContact& noted : noted_contacts_) {
        count(row_of(view.bodies, view.graph.pair(noted.index)));
    }
    for (const NotedJoint& noted : noted_joints_) {
        count(row_of(view.bodies, view.table[noted.index]));
    }
    std::erase_if(torn_, [&](const TornIsland& torn) {
        const std::size_t visits = torn.visits * static_cast<std::size_t>(substeps);
        const bool dear = visits > visits_left_ || substeps > kMostSweeps;
        given_up_ += dear ? 1 : 0;
        visits_left_ -= dear ? 0 : visits;
        return dear;
    });
}

bool TornIslands::take_back(const StepView& view,
                            int substeps,
                            std::span<const std::uint32_t> passed,
                            std::vector<std::uint32_t>& broken) {
    judge(view, passed, broken);
    drop_hopeless();
    keep_affordable(view, substeps);
    put_back(view, torn_, broken);
    last_.swap(torn_);
    return !joints_.empty();
}

bool TornIslands::take_back_of(const StepView& view,
                               std::span<const std::uint32_t> rows,
                               int substeps,
                               std::vector<std::uint32_t>& broken) {
    torn_.clear();
    for (const std::uint32_t row : rows) {
        torn_.push_back({view.islands.island_of(row)});
    }
    sort_islands(torn_);
    keep_affordable(view, substeps);
    put_back(view, torn_, broken);
    return !joints_.empty();
}

bool TornIslands::take_back_hopeless(const StepView& view, std::vector<std::uint32_t>& broken) {
    std::sort(hopeless_.begin(), hopeless_.end(), [](const TornIsland& a, const TornIsland& b) {
        return a.island < b.island;
    });
    put_back(view, hopeless_, broken);
    return !joints_.empty();
}

void TornIslands::take_out_gain(const StepView& view) {
    if (given_up_ == 0) {
        return;
    }
    weigh(view);
    for (const std::uint32_t row : rows_) {
        const IslandEnergy& energy = energy_[view.islands.island_of(row)];
        if (energy.held && energy.over() > 0.0F && energy.motion > 0.0F) {
            const float left =
                std::sqrt(std::max(energy.motion - energy.over(), 0.0F) / energy.motion);
            view.bodies.velocity[row] *= left;
            view.bodies.angular_velocity[row] *= left;
        }
    }
}

/// Lists the contacts and joints of these islands, and takes them and their bodies to the step's
/// start. Bodies that were stopped go on.
void TornIslands::put_back(const StepView& view,
                           std::span<const TornIsland> which,
                           std::vector<std::uint32_t>& broken) {
    contacts_.clear();
    joints_.clear();
    if (which.empty()) {
        return;
    }
    const auto meant = [&](std::uint32_t row) {
        return find(which, view.islands.island_of(row)) != nullptr;
    };
    for (const NotedContact& noted : noted_contacts_) {
        if (meant(row_of(view.bodies, view.graph.pair(noted.index)))) {
            view.graph[noted.index] = noted.contact;
            contacts_.push_back(noted.index);
        }
    }
    for (const NotedJoint& noted : noted_joints_) {
        JointEntry& entry = view.table[noted.index];
        if (meant(row_of(view.bodies, entry))) {
            static_cast<JointState&>(entry) = noted.state;
            joints_.push_back(noted.index);
        }
    }
    for (const std::uint32_t row : rows_) {
        if (meant(row)) {
            const StepStart& start = view.starts[row];
            view.bodies.set_pose(row, start.position, start.orientation);
            view.bodies.velocity[row] = start.velocity;
            view.bodies.angular_velocity[row] = start.spin;
        }
    }
    std::erase_if(broken, meant);
}

}  // namespace zoned::physics
