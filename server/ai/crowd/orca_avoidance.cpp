// build: hot loops
#include "server/ai/crowd/orca_avoidance.h"

#include "server/ai/crowd/orca_lines.h"
#include "shared/core/assert.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::steering {

namespace {

constexpr std::size_t kBatchGrain = 16;  ///< batches
constexpr std::size_t kMostWallPlanes = 32;
constexpr std::size_t kMostNearPlanes = 24;
constexpr std::size_t kMostPathPlanes = 24;
static_assert(kMostWallPlanes + kMostNearPlanes + kMostPathPlanes <= OrcaProgram::kMostRows);
/// Halvings of the slack: down to 1/64 of the largest.
constexpr int kHalvings = 6;
/// Overlaps up to this share of a radius come from rounding and are let be.
constexpr float kRoundingShare = 1e-3F;
/// An agent that overlaps another parts from it by this share a step, so that neither jumps.
constexpr float kPartShare = 0.5F;
/// Smaller differences of paths do not decide which agent goes first, m.
constexpr float kSamePath = 0.1F;
/// The share of avoidance of the agent that goes after is raised by this factor.
constexpr float kGivesWay = 4.0F;
/// Restless agents keep to a direction for this many steps.
constexpr std::uint64_t kTrySteps = 12;
/// Tolerance of half-planes, m/s: rounding.
constexpr float kTolerance = 1e-3F;

/// OrcaAgents: the data of eight agents processed together.
struct OrcaAgents {
    Lanes x, z, vx, vz, radius, yield, path_left, want_x, want_z, speed;
    unsigned moved_here;  ///< bits of the agents that are present and not moved by others
};

struct OrcaPlanes {
    OrcaLineSet<kMostWallPlanes> walls;
    OrcaLineSet<kMostNearPlanes> near;
    OrcaLineSet<kMostPathPlanes> path;
    unsigned pressed = 0;
};

/// Another agent, the same for all lanes.
struct Other {
    float x, z, vx, vz, radius, yield, path_left, want_x, want_z;
};

/// The neighbours of the eight agents, by columns.
class Seen {
  public:
    explicit Seen(const CrowdOrder& order) {
        for (std::size_t c = 0; c < kSortedColumns; ++c) {
            column_[c] = order.column(static_cast<SortedColumn>(c));
        }
    }

    [[nodiscard]] Lanes lanes(SortedColumn c, std::uint32_t at) const {
        return kernels::zk_load(column_[c] + at);
    }

    [[nodiscard]] Other other(std::uint32_t at) const {
        return {column_[kSortedX][at],
                column_[kSortedZ][at],
                column_[kSortedVx][at],
                column_[kSortedVz][at],
                column_[kSortedRadius][at],
                column_[kSortedYield][at],
                column_[kSortedPathLeft][at],
                column_[kSortedWantX][at],
                column_[kSortedWantZ][at]};
    }

    [[nodiscard]] const float* column(SortedColumn c) const { return column_[c]; }

  private:
    const float* column_[kSortedColumns];
};

Lanes length(const Lanes& x, const Lanes& z) {
    return kernels::zk_sqrt(x * x + z * z);
}

/// OrcaEscape: the half-plane of reciprocal avoidance, for discs that do not overlap. `px`, `pz`
/// lead to the other and `vx`, `vz` are relative to it. `both` is the sum of radii, and d2 > both^2
/// the squared distance.
struct OrcaEscape {
    Lanes nx, nz;  ///< out of the velocity obstacle
    Lanes depth;   ///< how far the relative velocity is within it (negative: outside)
};

OrcaEscape escape(const Lanes& px,
                  const Lanes& pz,
                  const Lanes& vx,
                  const Lanes& vz,
                  const Lanes& both,
                  const Lanes& d2,
                  float per_horizon) {
    // Off the small disc at the cone's tip.
    const Lanes wx = vx - per_horizon * px;
    const Lanes wz = vz - per_horizon * pz;
    const Lanes w2 = wx * wx + wz * wz;
    const Lanes w = kernels::zk_sqrt(w2);
    const Lanes per_w = 1.0F / pick(w > 0.0F, w, splat(1.0F));
    const Lanes along = wx * px + wz * pz;
    const LaneInts tip = (along < 0.0F) & (along * along > both * both * w2);
    // The plane of a leg of the cone, the nearer one.
    const Lanes leg = kernels::zk_sqrt(pick(d2 > both * both, d2 - both * both, Lanes{}));
    const Lanes side = pick(px * wz - pz * wx > 0.0F, splat(1.0F), splat(-1.0F));
    const Lanes per_d2 = 1.0F / d2;
    const Lanes dx = (px * leg - side * pz * both) * per_d2;
    const Lanes dz = (side * px * both + pz * leg) * per_d2;
    // Outwards is to the left of the left leg and to the right of the right one.
    const Lanes leg_nx = -side * dz;
    const Lanes leg_nz = side * dx;
    OrcaEscape e;
    e.nx = pick(tip, wx * per_w, leg_nx);
    e.nz = pick(tip, wz * per_w, leg_nz);
    e.depth = pick(tip, both * per_horizon - w, -(vx * leg_nx + vz * leg_nz));
    return e;
}

/// Adds the constraints of one other agent to eight agents; `before`: lanes that are sorted before
/// it.
void next_proximity_check(const OrcaAgents& a,
                          const Other& o,
                          unsigned others,
                          const LaneInts& before,
                          const AvoidanceSettings& settings,
                          OrcaPlanes& planes) {
    const Lanes px = o.x - a.x;
    const Lanes pz = o.z - a.z;
    const Lanes d2 = px * px + pz * pz;
    const unsigned near = bits_of(d2 < settings.neighbour_m * settings.neighbour_m) & others;
    if (near == 0) {
        return;
    }
    const Lanes none{};
    const Lanes both = a.radius + o.radius;
    const Lanes d = kernels::zk_sqrt(d2);
    const Lanes gap = d - both;
    // a.yield > 0 in lanes that count.
    const Lanes share = a.yield / (a.yield + o.yield);
    const float per_step = 1.0F / settings.step_s;
    // The share of the gap: -p / d v >= -share gap / step. An other that is moved by others comes
    // on by itself.
    const LaneInts apart = d > none;
    const Lanes per_d = 1.0F / pick(apart, d, splat(1.0F));
    // On the same spot one goes left, the other right.
    const Lanes nx = pick(apart, -px * per_d, pick(before, splat(-1.0F), splat(1.0F)));
    const Lanes nz = -pz * per_d;
    Lanes room = share * gap * per_step;
    if (o.yield <= 0.0F) {
        room = room - (nx * o.vx + nz * o.vz);
    }
    const LaneInts overlap = gap < -kRoundingShare * a.radius;
    const Lanes parting = -0.5F * a.speed;
    room = pick(overlap, kPartShare * room, pick(room > none, room, none));
    room = pick(room > parting, room, parting);
    const unsigned tight = bits_of(room < a.speed) & near;
    planes.near.add(tight, {nx, nz, -room});
    planes.pressed |= bits_of(overlap) & near;
    // An agent that goes first is taken to move as it wants, also while it is blocked; it then
    // takes less of the avoidance.
    const LaneInts after = o.path_left < a.path_left - kSamePath;
    const LaneInts ahead = o.path_left > a.path_left + kSamePath;
    const Lanes weight =
        a.yield * pick(after, splat(kGivesWay), pick(ahead, splat(1.0F / kGivesWay), splat(1.0F)));
    const Lanes part = weight / (weight + o.yield);
    const Lanes vx = a.vx - pick(after, splat(o.want_x), splat(o.vx));
    const Lanes vz = a.vz - pick(after, splat(o.want_z), splat(o.vz));
    const OrcaEscape e = escape(px, pz, vx, vz, both, d2, 1.0F / settings.horizon_s);
    const Lanes c = e.nx * a.vx + e.nz * a.vz + part * e.depth;
    const unsigned bound = bits_of((c > -a.speed) & (gap > none)) & near;
    planes.path.add(bound, {e.nx, e.nz, c});
    // An agent that goes after keeps a distance. Without it queues are pressed into arches that no
    // agent can leave. Where neither goes first both keep it.
    const Lanes spare =
        pick(after, splat(1.0F), share) * (gap - settings.comfort_m) * (1.0F / settings.comfort_s);
    const unsigned kept = bits_of((spare < a.speed) & ~ahead) & near;
    planes.path.add(kept, {nx, nz, -spare});
}

/// Adds the constraint of a wall to eight agents. No agent may come nearer to the wall than its
/// distance less its walk in the horizon. The whole wall lies beyond the plane through its nearest
/// point.
void look_at_wall(const OrcaAgents& a,
                  const Wall& w,
                  const AvoidanceSettings& settings,
                  OrcaPlanes& planes) {
    const Lanes none{};
    const float ex = w.bx - w.ax;
    const float ez = w.bz - w.az;
    const float length2 = ex * ex + ez * ez;
    const float per_length2 = length2 > 0.0F ? 1.0F / length2 : 0.0F;
    const Lanes along = ((a.x - w.ax) * ex + (a.z - w.az) * ez) * per_length2;
    const Lanes t = kernels::zk_clamp(along, none, splat(1.0F));
    const Lanes px = (w.ax + t * ex) - a.x;
    const Lanes pz = (w.az + t * ez) - a.z;
    const Lanes d = length(px, pz);
    const Lanes gap = d - a.radius;
    const Lanes room = pick(gap > none, gap, none) * (1.0F / settings.wall_horizon_s);
    const unsigned tight = bits_of(room < a.speed) & a.moved_here;
    if (tight == 0) {
        return;
    }
    // Right on the wall, either side will do.
    const float per_length = std::sqrt(per_length2);
    const LaneInts on_it = d <= none;
    const Lanes per_d = 1.0F / pick(on_it, splat(1.0F), d);
    const Lanes nx = pick(on_it, splat(-ez * per_length), -px * per_d);
    const Lanes nz = pick(on_it, splat(ex * per_length), -pz * per_d);
    planes.walls.add(tight, {nx, nz, -room});
    // An agent that was put into the wall is pushed out.
    const float per_step = 1.0F / settings.step_s;
    const unsigned inside = bits_of(gap < -kRoundingShare * a.radius) & tight;
    planes.near.add(
        inside, {nx, nz, kPartShare * pick(-gap * per_step < a.speed, -gap * per_step, a.speed)});
    planes.pressed |= inside;
}

/// The desired velocities of agents, turned a little where they make no progress.
OrcaVelocity desired(const OrcaAgents& a,
                     const std::uint32_t* rows,
                     std::size_t count,
                     const CrowdAgents& agents,
                     std::uint64_t tick,
                     const AvoidanceSettings& settings) {
    const Lanes none{};
    const Lanes one = splat(1.0F);
    const Lanes wanted = length(a.want_x, a.want_z);
    const Lanes per_wanted = 1.0F / pick(wanted > none, wanted, one);
    const Lanes gone = (a.vx * a.want_x + a.vz * a.want_z) * per_wanted * per_wanted;
    const Lanes blocked = one - kernels::zk_clamp(gone, none, one);
    Lanes x = a.want_x;
    Lanes z = a.want_z;
    // Right of (x, z) with y up, z towards the viewer: (-z, x).
    x = x - settings.keep_right * blocked * a.want_z;
    z = z + settings.keep_right * blocked * a.want_x;
    Lanes stray_x{};
    Lanes stray_z{};
    for (std::size_t lane = 0; lane < count; ++lane) {
        const std::uint32_t id = agents.id[rows[lane]];
        const std::uint64_t drawn =
            core::mix((std::uint64_t{id} << 32U) ^ ((tick + id) / kTrySteps));
        stray_x[lane] = static_cast<float>(static_cast<std::int32_t>(drawn)) * 0x1.0p-31F;
        stray_z[lane] = static_cast<float>(static_cast<std::int32_t>(drawn >> 32U)) * 0x1.0p-31F;
    }
    const Lanes reach = settings.restless * blocked * wanted;
    x = x + reach * stray_x;
    z = z + reach * stray_z;
    const Lanes speed = length(x, z);
    const Lanes cut = pick(speed > a.speed, a.speed / pick(speed > none, speed, one), one);
    return {x * cut, z * cut};
}

LaneInts lanes_of(unsigned bits) {
    const LaneInts each{1, 2, 4, 8, 16, 32, 64, 128};
    return (each & static_cast<std::int32_t>(bits)) != 0;
}

/// True if v is within the planes, but for rounding.
LaneInts within(const OrcaProgram& p, std::size_t rows, const OrcaVelocity& v) {
    LaneInts all = LaneInts{} - 1;
    for (std::size_t k = 0; k < rows; ++k) {
        all = all & (p.row[k]->nx * v.x + p.row[k]->nz * v.z >= p.row[k]->c - kTolerance);
    }
    return all;
}

OrcaVelocity choose(const OrcaAgents& a,
                    const OrcaPlanes& planes,
                    const OrcaVelocity& want,
                    const AvoidanceSettings& settings,
                    AvoidanceReport& report) {
    OrcaProgram p;
    p.want = want;
    p.most_speed = a.speed;
    p.append(planes.walls);
    const std::size_t walls = p.rows;
    p.append(planes.near);
    const std::size_t fixed = p.rows;
    p.append(planes.path);
    p.fixed = fixed;
    OrcaSolution s = solve_with_slack(p, 2.0F * a.speed, kHalvings);
    // An agent without overlap can always stand; one with overlap may have no allowed velocity.
    const LaneInts failed = s.failed_at < static_cast<std::int32_t>(fixed);
    const LaneInts overlapping = failed & lanes_of(planes.pressed);
    if ((bits_of(overlapping) & a.moved_here) != 0) {
        // Those that were put into others: apart from them as fast as walls allow.
        p.rows = fixed;
        p.fixed = walls;
        const OrcaSolution apart = solve_with_slack(p, 4.0F * a.speed, kHalvings);
        s.v.x = pick(overlapping, apart.v.x, s.v.x);
        s.v.z = pick(overlapping, apart.v.z, s.v.z);
    }
    // A wall that there was no room for matters where it can be reached within the step.
    const unsigned walled =
        planes.walls.full() &
        bits_of(planes.walls.lost() * settings.wall_horizon_s > -a.speed * settings.step_s);
    const unsigned full = walled | (planes.near.full() & ~planes.pressed);
    const LaneInts parting = within(p, walls, s.v) & lanes_of(planes.pressed);
    const LaneInts stand = ~(within(p, fixed, s.v) | parting) | lanes_of(full);
    report.stuck += static_cast<std::uint32_t>(__builtin_popcount(full & a.moved_here));
    report.relaxed +=
        static_cast<std::uint32_t>(__builtin_popcount(bits_of(s.gave_way) & a.moved_here));
    report.pressed += static_cast<std::uint32_t>(__builtin_popcount(planes.pressed & a.moved_here));
    return {pick(stand, Lanes{}, s.v.x), pick(stand, Lanes{}, s.v.z)};
}

OrcaAgents load_agents(const Seen& seen, const CrowdBatch& batch) {
    OrcaAgents a;
    a.x = seen.lanes(kSortedX, batch.begin);
    a.z = seen.lanes(kSortedZ, batch.begin);
    a.vx = seen.lanes(kSortedVx, batch.begin);
    a.vz = seen.lanes(kSortedVz, batch.begin);
    a.radius = seen.lanes(kSortedRadius, batch.begin);
    a.yield = seen.lanes(kSortedYield, batch.begin);
    a.path_left = seen.lanes(kSortedPathLeft, batch.begin);
    a.want_x = seen.lanes(kSortedWantX, batch.begin);
    a.want_z = seen.lanes(kSortedWantZ, batch.begin);
    a.speed = seen.lanes(kSortedSpeed, batch.begin);
    a.moved_here = bits_of(a.yield > 0.0F) & ((1U << (batch.end - batch.begin)) - 1U);
    return a;
}

void look_around(const OrcaAgents& a,
                 const CrowdOrder& order,
                 const Seen& seen,
                 const CrowdBatch& batch,
                 const AvoidanceSettings& settings,
                 OrcaPlanes& planes) {
    const LaneInts place =
        LaneInts{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<std::int32_t>(batch.begin);
    for (int row = batch.row - 1; row <= batch.row + 1; ++row) {
        const auto [begin, end] = order.stretch(row, batch.first_cell - 1, batch.last_cell + 1);
        for (std::uint32_t i = begin; i < end; ++i) {
            const bool own = i >= batch.begin && i < batch.end;
            const unsigned others = own ? a.moved_here & ~(1U << (i - batch.begin)) : a.moved_here;
            next_proximity_check(
                a, seen.other(i), others, place < static_cast<std::int32_t>(i), settings, planes);
        }
    }
}

void look_at_walls(const OrcaAgents& a,
                   const Walls& walls,
                   const CrowdBatch& batch,
                   const AvoidanceSettings& settings,
                   OrcaPlanes& planes) {
    if (walls.empty()) {
        return;
    }
    float low_x = a.x[0];
    float high_x = low_x;
    float low_z = a.z[0];
    float high_z = low_z;
    float reach = 0.0F;
    for (std::size_t lane = 0; lane < batch.end - batch.begin; ++lane) {
        low_x = std::min(low_x, a.x[lane]);
        high_x = std::max(high_x, a.x[lane]);
        low_z = std::min(low_z, a.z[lane]);
        high_z = std::max(high_z, a.z[lane]);
        reach = std::max(reach, a.radius[lane] + a.speed[lane] * settings.wall_horizon_s);
    }
    walls.for_each_near(
        low_x - reach, low_z - reach, high_x + reach, high_z + reach, [&](const Wall& w) {
            look_at_wall(a, w, settings, planes);
        });
}

/// With neighbours at least as far as two can touch within a step.
AvoidanceSettings within_reach(const CrowdAgents& agents, AvoidanceSettings settings) {
    float radius = 0.0F;
    float speed = 0.0F;
    for (std::size_t i = 0; i < agents.size(); ++i) {
        radius = std::max(radius, agents.radius[i]);
        speed = std::max(speed, agents.most_speed[i]);
    }
    settings.neighbour_m =
        std::max(settings.neighbour_m, 2.0F * (radius + speed * settings.step_s));
    return settings;
}

}  // namespace

AvoidanceReport OrcaAvoidance::step(CrowdAgents& agents,
                                    const Walls& walls,
                                    std::uint64_t tick,
                                    compute::Team& team) {
    ZONED_ASSERT(settings_.step_s > 0.0F && settings_.horizon_s >= settings_.step_s &&
                     settings_.wall_horizon_s >= settings_.step_s && settings_.neighbour_m > 0.0F,
                 "times and distances are positive, horizons no shorter than a step");
    const AvoidanceSettings settings = within_reach(agents, settings_);
    order_.sort(agents, settings.neighbour_m, team);
    const Seen seen(order_);
    of_batch_.assign(order_.batches().size(), {});
    team.run(of_batch_.size(), kBatchGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const CrowdBatch& batch = order_.batches()[b];
            const OrcaAgents a = load_agents(seen, batch);
            const std::uint32_t* const rows = order_.rows().data() + batch.begin;
            const std::size_t count = batch.end - batch.begin;
            OrcaPlanes planes;
            look_around(a, order_, seen, batch, settings, planes);
            look_at_walls(a, walls, batch, settings, planes);
            const OrcaVelocity want = desired(a, rows, count, agents, tick, settings);
            const OrcaVelocity v = choose(a, planes, want, settings, of_batch_[b]);
            for (std::size_t lane = 0; lane < count; ++lane) {
                if ((a.moved_here >> lane & 1U) != 0) {
                    agents.vx[rows[lane]] = v.x[lane];
                    agents.vz[rows[lane]] = v.z[lane];
                    agents.x[rows[lane]] = a.x[lane] + settings.step_s * v.x[lane];
                    agents.z[rows[lane]] = a.z[lane] + settings.step_s * v.z[lane];
                }
            }
        }
    });
    AvoidanceReport sum;
    for (const AvoidanceReport& r : of_batch_) {
        sum.relaxed += r.relaxed;
        sum.pressed += r.pressed;
        sum.stuck += r.stuck;
    }
    return sum;
}

}  // namespace zoned::ai::steering
