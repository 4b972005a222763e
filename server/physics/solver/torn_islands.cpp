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
/// A joint that was open already is torn when it has opened further by this share of the gap.
constexpr float kOpened = 0.2F;
/// An island that nothing drives gains no more energy than this share of its energy of motion ...
constexpr float kGain = 0.1F;
/// ... and that of this speed, m/s: contacts push apart what overlaps.
constexpr float kOverlapSpeed = 0.5F;

/// How far the anchors are from where the joint holds them, m.
float gap_of(const Bodies& bodies, const JointEntry& entry) {
    const Vec3 origin = bodies.position[entry.b];
    const JointPose a = entry.a == kNoIndex ? JointPose{-origin, Mat3::Identity()}
                                            : JointPose{bodies.position[entry.a] - origin,
                                                        bodies.rotation[entry.a]};
    JointRows rows;
    write_rows(entry.joint, a, {Vec3::Zero(), bodies.rotation[entry.b]}, rows);
    float square = 0.0F;
    for (std::size_t i = 0; i < rows.count; ++i) {
        const JointRow& row = rows.rows[i];
        if (row.kind == RowKind::kHard && !row.linear.isZero(0.0F)) {
            square += row.error * row.error;
        }
    }
    return std::sqrt(square);
}

std::uint32_t row_of(const Bodies& bodies, const JointEntry& entry) {
    return bodies.simulated(entry.b) ? entry.b : entry.a;
}

std::uint32_t row_of(const Bodies& bodies, const Pair& pair) {
    return bodies.simulated(pair.a) ? pair.a : pair.b;
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
        noted_joints_.push_back({index, view.table[index], gap_of(view.bodies, view.table[index])});
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
        energy.allowed +=
            kGain * before + mass * (0.5F * kOverlapSpeed * kOverlapSpeed + g * limits_.gap_m);
        energy.driven |= !bodies.force[row].isZero(0.0F) || !bodies.torque[row].isZero(0.0F);
    }
    for (const NotedContact& noted : noted_contacts_) {
        const Pair& pair = view.graph.pair(noted.index);
        for (const std::uint32_t row : {pair.a, pair.b}) {
            energy_[view.islands.island_of(row_of(bodies, pair))].driven |=
                !bodies.simulated(row) && moves(bodies, row);
        }
    }
    for (const NotedJoint& noted : noted_joints_) {
        const JointEntry& entry = view.table[noted.index];
        const JointDef& def = entry.joint.def;
        const bool mover =
            entry.a != kNoIndex && !bodies.simulated(entry.a) && moves(bodies, entry.a);
        energy_[view.islands.island_of(row_of(bodies, entry))].driven |=
            def.motor || def.kind == JointKind::kSpring || mover;
    }
}

/// Lists the islands that are torn now.
void TornIslands::judge(const StepView& view, std::span<const std::uint32_t> broken) {
    weigh(view);
    torn_.clear();
    for (const NotedJoint& noted : noted_joints_) {
        const JointEntry& entry = view.table[noted.index];
        const std::uint32_t island = view.islands.island_of(row_of(view.bodies, entry));
        const bool stopped = std::any_of(broken.begin(), broken.end(), [&](std::uint32_t row) {
            return row == entry.a || row == entry.b;
        });
        const float gap = gap_of(view.bodies, entry);
        const bool opened = gap > limits_.gap_m && gap > noted.gap + kOpened * limits_.gap_m;
        const IslandEnergy& energy = energy_[island];
        if (stopped || opened || (!energy.driven && !(energy.gain <= energy.allowed))) {
            torn_.push_back({island, stopped ? INFINITY : gap, 0});
        }
    }
    std::sort(torn_.begin(), torn_.end(), [](const TornIsland& a, const TornIsland& b) {
        return std::tuple(a.island, -a.gap) < std::tuple(b.island, -b.gap);
    });
    const auto same = [](const TornIsland& a, const TornIsland& b) {
        return a.island == b.island;
    };
    torn_.erase(std::unique(torn_.begin(), torn_.end(), same), torn_.end());
}

/// Islands whose joints are open further than before the repeat: more substeps do not help them.
void TornIslands::drop_hopeless() {
    std::erase_if(torn_, [this](const TornIsland& now) {
        const TornIsland* before = find(last_, now.island);
        const bool worse = before != nullptr && now.gap > limits_.gap_m && now.gap >= before->gap;
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
        const bool dear = visits > visits_left_ || substeps > SubstepPolicy::kMostSubsteps;
        given_up_ += dear ? 1 : 0;
        visits_left_ -= dear ? 0 : visits;
        return dear;
    });
}

bool TornIslands::take_back(const StepView& view,
                            int substeps,
                            std::vector<std::uint32_t>& broken) {
    judge(view, broken);
    drop_hopeless();
    keep_affordable(view, substeps);
    put_back(view, torn_, broken);
    last_.swap(torn_);
    return !joints_.empty();
}

bool TornIslands::take_back_hopeless(const StepView& view, std::vector<std::uint32_t>& broken) {
    std::sort(hopeless_.begin(), hopeless_.end(), [](const TornIsland& a, const TornIsland& b) {
        return a.island < b.island;
    });
    put_back(view, hopeless_, broken);
    return !joints_.empty();
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
