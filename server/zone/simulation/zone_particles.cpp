#include "server/zone/simulation/zone_particles.h"

#include "server/physics/shapes/heightfield.h"
#include "shared/core/assert.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

/// Where balls wait that stand for nobody.
const Vec3 kNowhere(0.0F, -1e6F, 0.0F);
constexpr float kNobody_m = 0.01F;
/// Keeps seeds of cosmetic bursts apart from those of simulated ones.
constexpr std::uint64_t kCosmetic = 0x636F736D65746963;

ParticlesOfZone::System* find_system(ZoneState& state, std::string_view name) {
    auto& systems = state.particles.systems;
    const auto it =
        std::find_if(systems.begin(), systems.end(), [&](const auto& s) { return s.name == name; });
    return it == systems.end() ? nullptr : &*it;
}

void meet_the_ground(const ZoneState& state, physics::ParticleSystemDef& def) {
    def.walls.push_back({Vec3::UnitY(), state.settings.statics->ground_height()});
    for (const SurfaceBody& surface : state.settings.surfaces) {
        if (surface.shape.kind == physics::ShapeKind::kHeightfield &&
            surface.orientation.coeffs() == Quat::Identity().coeffs()) {
            def.field =
                std::static_pointer_cast<const physics::Heightfield>(surface.shape.geometry);
            def.field_origin = surface.position;
            return;
        }
    }
}

/// The characters nearest to the particles; equal distances go by id.
void move_characters_met(ZoneState& state, ParticlesOfZone::System& system) {
    const world::Entities& e = state.entities;
    auto& near = state.particles.near;
    near.clear();
    world::for_each_row(e.characters(), [&](world::Row row) {
        if (!e.has(row, world::kHidden)) {
            near.push_back({(e.position[row] - system.focus).squaredNorm(), e.id[row], row});
        }
    });
    const std::size_t met = std::min<std::size_t>(near.size(), system.characters_met);
    std::partial_sort(near.begin(),
                      near.begin() + static_cast<std::ptrdiff_t>(met),
                      near.end(),
                      [](const auto& a, const auto& b) {
                          return std::pair(a.distance2, a.id) < std::pair(b.distance2, b.id);
                      });
    auto& balls = state.particles.balls;
    balls.assign(system.characters_met, {kNowhere, kNobody_m});
    for (std::size_t i = 0; i < met; ++i) {
        const world::Row row = near[i].row;
        balls[i] = {e.position[row], (*state.settings.types)[e.type[row]].extent()};
    }
    state.particles.simulated.find(system.id)->move_balls(balls);
}

/// The world's coordinates become the zone's.
void bring_home(const ZoneState& state, physics::FlockDef& flock) {
    const Vec3d origin = state.settings.region().origin();
    flock.low -= origin;
    flock.high -= origin;
    for (Vec2d& point : flock.path) {
        point -= Vec2d(origin.x(), origin.z());
    }
}

/// The system's emitters that lie in the zone's region, in its coordinates.
std::vector<motion::Emitter> emitters_here(const ZoneState& state, const ParticleSource& source) {
    std::vector<motion::Emitter> here;
    for (std::size_t i = 0; i < source.emitters.size(); ++i) {
        const Vec3d& at = source.positions[i];
        if (state.settings.owner_of(at.x(), at.z()) == state.settings.id) {
            motion::Emitter emitter = source.emitters[i];
            emitter.position = (at - state.settings.region().origin()).cast<float>();
            here.push_back(emitter);
        }
    }
    return here;
}

std::uint64_t burst_seed(const ZoneState& state, std::uint64_t number) {
    return core::mix(state.settings.seed ^ core::mix(state.settings.id.value ^ core::mix(number)));
}

/// A burst that is simulated here.
bool let_out(ZoneState& state,
             ParticlesOfZone::System& system,
             const Vec3& position,
             const Vec3& velocity,
             std::uint32_t count) {
    ParticlesOfZone& particles = state.particles;
    // The pass of this tick may be over, or not have been planned.
    const motion::Emitter emitter = emitter_of(
        *system.burst,
        motion::Burst{
            burst_seed(state, particles.bursts + 1), state.now + 1, position, velocity, count});
    // Bursts of the past would make all later steps dearer.
    particles.simulated.find(system.id)->forget_over(state.now, state.settings.dt);
    if (!particles.simulated.add_emitter(system.id, emitter).ok()) {
        return false;
    }
    ++particles.bursts;
    system.focus = position;
    return true;
}

/// A burst that is sent to clients; it changes nothing that is simulated or hashed.
bool emit_cosmetic(ZoneState& state,
                   std::size_t index,
                   const Vec3& position,
                   const Vec3& velocity,
                   std::uint32_t count) {
    const CosmeticBurst& cosmetic = state.settings.cosmetic_bursts[index];
    ParticlesOfZone& particles = state.particles;
    motion::Burst burst{burst_seed(state, kCosmetic + particles.cosmetic_bursts + 1),
                        state.now,
                        (state.settings.region().origin() + position.cast<double>()).cast<float>(),
                        velocity,
                        count};
    if (count > motion::kMostInCosmeticBurst || !unfit(emitter_of(cosmetic.kind, burst)).empty()) {
        return false;
    }
    // Each event pays for its share of a second. The debt may reach a second's worth, or one event
    // (and a thousandth of a tick, for rounding).
    const double now = static_cast<double>(state.now);
    const double second = 1.0 / static_cast<double>(state.settings.dt);
    const double share = second / static_cast<double>(cosmetic.events_per_s);
    const double due = std::max(particles.cosmetic_due[index], now) + share;
    if (due - now > std::max(share, second) + 1e-3) {
        return false;
    }
    particles.cosmetic_due[index] = due;
    ++particles.cosmetic_bursts;
    state.out.bursts.push_back({cosmetic.system, burst, cosmetic.aura_m, cosmetic.line_of_sight});
    return true;
}

}  // namespace

void add_particle_systems(ZoneState& state) {
    state.particles.cosmetic_due.assign(state.settings.cosmetic_bursts.size(), 0.0);
    for (const ParticleSource& source : state.settings.particles) {
        const std::vector<motion::Emitter> here = emitters_here(state, source);
        if (here.empty() && !source.burst) {
            continue;
        }
        physics::ParticleSystemDef def = source.def;
        if (def.flock) {
            bring_home(state, *def.flock);
        } else {
            meet_the_ground(state, def);
        }
        def.balls.assign(source.characters_met, {kNowhere, kNobody_m});
        const auto id = state.particles.simulated.add(std::move(def));
        ZONED_ASSERT(id.ok(), "particle systems were checked when the config was read");
        for (const motion::Emitter& emitter : here) {
            const auto added = state.particles.simulated.add_emitter(*id, emitter);
            ZONED_ASSERT(added.ok(), "emitters were checked when the config was read");
        }
        const Vec3 focus = here.empty() ? Vec3(0.0F, 0.0F, 0.0F) : here.front().position;
        state.particles.systems.push_back(
            {source.def.name, *id, source.burst, source.characters_met, focus});
    }
}

bool particles_go_on(const ZoneState& state) {
    return std::any_of(state.particles.systems.begin(),
                       state.particles.systems.end(),
                       [&](const ParticlesOfZone::System& system) {
                           return !state.particles.simulated.find(system.id)->is_over(
                               state.now, state.settings.dt);
                       });
}

std::uint32_t step_particles(ZoneState& state) {
    for (ParticlesOfZone::System& system : state.particles.systems) {
        if (system.characters_met > 0) {
            move_characters_met(state, system);
        }
    }
    compute::Team alone;
    compute::Team& team = state.team != nullptr ? *state.team : alone;
    state.report.particles = state.particles.simulated.step(state.now, state.settings.dt, team);
    return static_cast<std::uint32_t>(state.report.particles.particles);
}

bool emit_particles(ZoneState& state,
                    std::string_view system,
                    const Vec3& position,
                    const Vec3& velocity,
                    std::uint32_t count) {
    if (count == 0) {
        return false;
    }
    ParticlesOfZone::System* const found = find_system(state, system);
    if (found != nullptr) {
        return found->burst && let_out(state, *found, position, velocity, count);
    }
    const auto& cosmetic = state.settings.cosmetic_bursts;
    const auto it = std::find_if(
        cosmetic.begin(), cosmetic.end(), [&](const auto& t) { return t.name == system; });
    return it != cosmetic.end() &&
           emit_cosmetic(
               state, static_cast<std::size_t>(it - cosmetic.begin()), position, velocity, count);
}

std::uint32_t particles_near(const ZoneState& state,
                             std::string_view system,
                             const Vec3& point,
                             float radius) {
    const auto& systems = state.particles.systems;
    const auto it = std::find_if(
        systems.begin(), systems.end(), [&](const auto& s) { return s.name == system; });
    if (it == systems.end()) {
        return 0;
    }
    const physics::ParticleSystem& found = *state.particles.simulated.find(it->id);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        count += (found.position(i) - point).squaredNorm() <= radius * radius ? 1U : 0U;
    }
    return count;
}

}  // namespace zoned::zone
