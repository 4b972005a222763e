#include "server/app/planner/world_probe.h"

#include "server/app/runtime/tick_loop.h"
#include "shared/core/elementary/elementary.h"
#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace zoned::app {

namespace {

/// A step of the pile of SpeedMeter on the reference machine, ns.
constexpr double kReferenceStep_ns = 60000.0;
constexpr int kPileSide = 6;
constexpr int kSettlingSteps = 30;
/// The machine's speed is sampled once in this many ticks.
constexpr Tick kSpeedEvery = 4;

/// A prop this far above or below the ground does not lie on it, m.
constexpr float kOnGround_m = 0.02F;
/// Rounding of a place, m: what lies no deeper has not moved since it was placed.
constexpr double kRounding_m = 2e-5;

/// Height of the lowest point of a box or ball above its centre, m; 0: another shape.
float lowest_of(const world::EntityType& type, const Quat& turn) {
    if (type.shape == world::TypeShape::kSphere) {
        return -type.radius;
    }
    if (type.shape != world::TypeShape::kBox) {
        return 0.0F;
    }
    const Mat3 axes = turn.toRotationMatrix();
    return -axes.row(1).cwiseAbs().dot(type.half_extents);
}

/// A prop that has left its place by more has slid, m, or turned, rad.
constexpr double kSlid_m = 0.01;
constexpr float kTurned_rad = 0.02F;
/// A prop that sank by more has fallen: multiples of physics.error_budget_m.
constexpr double kFallen = 8.0;

template <class Visit>
void for_each_prop(const World& world, const config::Settings& settings, const Visit& visit) {
    for (std::size_t z = 0; z < world.zones().size(); ++z) {
        const world::Entities& e = world.zones()[z]->state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const world::EntityType& type = settings.types[e.type[row]];
            if (!e.has(row, world::kGhost) && type.kind == world::EntityKind::kProp &&
                type.shape != world::TypeShape::kSoft) {
                const Vec3d at = settings.zones[z].origin() + e.position[row].cast<double>();
                visit(e.id[row], at, e.orientation[row]);
            }
        }
    }
}

}  // namespace

SpeedMeter::SpeedMeter()
    : pile_([] {
          physics::PhysicsSettings settings;
          settings.sleep_after_s = 0.0F;
          return settings;
      }()) {
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = physics::Shape::plane();
    static_cast<void>(pile_.add(ground));
    physics::BodyDef box;
    box.shape = physics::Shape::box(Vec3::Constant(0.5F));
    for (int i = 0; i < kPileSide * kPileSide; ++i) {
        box.position = Vec3(1.5F * static_cast<float>(i % kPileSide),
                            0.5F + static_cast<float>(i / kPileSide),
                            0.0F);
        static_cast<void>(pile_.add(box));
    }
    for (int step = 0; step < kSettlingSteps; ++step) {
        sample();
    }
}

double SpeedMeter::sample() {
    const std::uint64_t begin = thread_cpu_ns();
    pile_.step(1.0F / 30.0F);
    return static_cast<double>(thread_cpu_ns() - begin) / kReferenceStep_ns;
}

void ZoneSums::add(const ZoneSums& other) {
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        passes[p].ran += other.passes[p].ran;
        passes[p].ns += other.passes[p].ns;
        passes[p].count += other.passes[p].count;
        for (std::size_t k = 0; k < config::kUnitKinds; ++k) {
            passes[p].units[k] += other.passes[p].units[k];
        }
    }
    ticks += other.ticks;
    bytes += other.bytes;
    packets += other.packets;
    viewer_ticks += other.viewer_ticks;
}

WorldProbe::WorldProbe(World& world, const config::Settings& settings, const ProbeCrowd& crowd)
    : world_(world),
      settings_(settings),
      crowd_(crowd),
      walks_(crowd.bots) {
    for (unsigned i = 1; i <= crowd.viewers + crowd.bots; ++i) {
        mailbox::Join join;
        join.client = ClientId(i);
        join.name = "viewer" + std::to_string(i);
        items_.emplace_back(std::move(join));
    }
    for_each_prop(world_, settings_, [this](EntityId id, const Vec3d& at, const Quat& turn) {
        placed_.emplace(id, std::pair(at, turn));
    });
    clear();
}

void WorldProbe::clear() {
    zones_.assign(settings_.zones.size(), {});
    views_.assign(settings_.replication.lods.size(), {});
    speed_sum_ = 0.0;
    speed_samples_ = 0.0;
}

double WorldProbe::speed() const {
    return speed_samples_ > 0.0 ? speed_sum_ / speed_samples_ : 1.0;
}

void WorldProbe::make_inputs() {
    const Tick next = world_.now() + 1;
    const auto second = static_cast<Tick>(std::lround(settings_.tick_rate_hz));
    for (std::size_t b = 0; b < walks_.size(); ++b) {
        motion::InputCommand& walk = walks_[b];
        if ((next + static_cast<Tick>(b)) % second == 0 || walk.tick == 0) {
            const float heading = rng_.range(0.0F, 6.2831853F);
            walk.move_x = static_cast<std::int8_t>(std::lround(127.0F * elementary::sin(heading)));
            walk.move_z = static_cast<std::int8_t>(std::lround(127.0F * elementary::cos(heading)));
            walk.yaw = static_cast<std::uint16_t>(std::lround(heading * 65535.0F / 6.2831853F));
        }
        walk.tick = next;
        items_.emplace_back(
            mailbox::Input{ClientId(static_cast<std::uint32_t>(crowd_.viewers + b + 1)), {walk}});
    }
}

void WorldProbe::take_output() {
    items_.clear();
    std::map<ClientId, std::uint64_t> newest;
    for (const mailbox::OutboxItem& item : out_) {
        if (const auto* packet = std::get_if<mailbox::StatePacket>(&item)) {
            newest[packet->client] = std::max(newest[packet->client], packet->sequence);
        }
    }
    const auto tick_us = static_cast<std::uint32_t>(std::lround(1e6 / settings_.tick_rate_hz));
    for (const auto& [client, sequence] : newest) {
        mailbox::Acks acks;
        acks.client = client;
        acks.newest = sequence;
        acks.bits = ~0U;
        acks.rtt_us = tick_us;
        items_.emplace_back(acks);
    }
    out_.clear();
}

void WorldProbe::sample_views() {
    for (const auto& zone : world_.zones()) {
        const zone::ZoneState& state = zone->state();
        const std::size_t players = std::min(state.clients.size(), kSampledPlayers);
        for (std::size_t c = 0; c < players; ++c) {
            state.replicator.shown_to(state.clients[c].client, state.now, shown_);
            for (const auto& shown : shown_) {
                const world::Row row = state.entities.find(shown.entity);
                if (row == world::kNoRow || state.entities.has(row, world::kHidden)) {
                    continue;
                }
                ViewErrors& errors = views_[shown.lod];
                const auto off =
                    static_cast<double>((shown.position - state.entities.position[row]).norm());
                const float turned =
                    motion::angle_between(shown.orientation, state.entities.orientation[row]);
                errors.most_m = std::max(errors.most_m, off);
                errors.most_rad = std::max(errors.most_rad, static_cast<double>(turned));
                ++errors.samples;
                errors.moving += state.entities.has(row, world::kAtRest) ? 0 : 1;
            }
        }
    }
}

void WorldProbe::run(unsigned ticks) {
    for (unsigned t = 0; t < ticks; ++t) {
        make_inputs();
        world_.tick(items_, out_);
        take_output();
        for (std::size_t z = 0; z < zones_.size(); ++z) {
            const zone::StepReport& report = world_.zones()[z]->report();
            ZoneSums& sums = zones_[z];
            sums.ticks += 1.0;
            sums.bytes += static_cast<double>(report.replication.bytes);
            sums.packets += report.replication.packets;
            sums.viewer_ticks += report.census.viewers;
            for (std::size_t p = 0; p < zone::kPasses; ++p) {
                PassSums& pass = sums.passes[p];
                pass.ran += report.passes[p].ran ? 1.0 : 0.0;
                pass.ns += static_cast<double>(report.passes[p].ns);
                pass.count += report.passes[p].count;
                const config::PassUnits units =
                    config::units_of(static_cast<zone::Pass>(p), report);
                for (std::size_t k = 0; k < config::kUnitKinds; ++k) {
                    pass.units[k] += units[k];
                }
            }
        }
        sample_views();
        if (world_.now() % kSpeedEvery == 0) {
            speed_sum_ += meter_.sample();
            speed_samples_ += 1.0;
        }
    }
}

double WorldProbe::give_m() const {
    double most = -1.0;
    for (const auto& zone : world_.zones()) {
        const world::Entities& e = zone->state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const world::EntityType& type = settings_.types[e.type[row]];
            const float lowest = lowest_of(type, e.orientation[row]);
            if (type.kind != world::EntityKind::kProp || lowest == 0.0F ||
                e.has(row, world::kGhost)) {
                continue;
            }
            const float gap = e.position[row].y() + lowest - settings_.ground_height_m;
            if (std::abs(gap) < kOnGround_m && e.velocity[row].norm() < kOnGround_m &&
                static_cast<double>(-gap) > kRounding_m) {
                most = std::max(most, static_cast<double>(-gap));
            }
        }
    }
    return most;
}

double WorldProbe::sag_m() const {
    double most = -1.0;
    const double fallen = kFallen * static_cast<double>(settings_.physics.error_budget_m);
    for_each_prop(world_, settings_, [&](EntityId id, const Vec3d& at, const Quat& turn) {
        const auto before = placed_.find(id);
        if (before == placed_.end()) {
            return;
        }
        const Vec3d moved = at - before->second.first;
        const double sank = std::abs(moved.y());
        if (elementary::hypot(moved.x(), moved.z()) < kSlid_m && sank < fallen &&
            motion::angle_between(turn, before->second.second) < kTurned_rad) {
            most = std::max(most, sank);
        }
    });
    return most;
}

}  // namespace zoned::app
