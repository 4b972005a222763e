#include "server/zone/particles.h"

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
/// All particles of a burst are born in the same step, whatever the tick's length.
constexpr double kBurstRate_hz = 1e9;

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

/// The characters nearest to where the particles are; who is as near as another comes by id.
void move_characters_met(ZoneState& state, ParticlesOfZone::System& system) {
    const world::Entities& e = state.entities;
    auto& near = state.particles.near;
    near.clear();
    for (world::Row row = 0; row < e.size(); ++row) {
        const world::EntityType& type = (*state.settings.types)[e.type[row]];
        if (type.kind == world::EntityKind::kCharacter && !e.has(row, world::kHidden)) {
            near.push_back({(e.position[row] - system.focus).squaredNorm(), e.id[row], row});
        }
    }
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

}  // namespace

void add_particle_systems(ZoneState& state) {
    for (const ParticleSource& source : state.settings.particles) {
        const std::vector<motion::Emitter> here = emitters_here(state, source);
        if (here.empty() && !source.burst) {
            continue;
        }
        physics::ParticleSystemDef def = source.def;
        meet_the_ground(state, def);
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
    ParticlesOfZone::System* const found = find_system(state, system);
    if (found == nullptr || !found->burst || count == 0) {
        return false;
    }
    const float speed = velocity.norm();
    motion::Emitter emitter;
    emitter.seed = core::mix(state.settings.seed ^ core::mix(state.settings.id.value ^
                                                             core::mix(++state.particles.bursts)));
    // The pass of this tick may be over, or not have been planned.
    emitter.start = state.now + 1;
    emitter.rate_hz = kBurstRate_hz;
    emitter.most = count;
    emitter.position = position;
    emitter.spread = found->burst->spread_m;
    emitter.direction = speed > 1e-6F ? Vec3(velocity / speed) : Vec3(Vec3::UnitY());
    emitter.cone_cosine = found->burst->cone_cosine;
    emitter.speed_min = found->burst->slowest * speed;
    emitter.speed_max = speed;
    emitter.lifetime_min_s = found->burst->lifetime_min_s;
    emitter.lifetime_max_s = found->burst->lifetime_max_s;
    // Bursts of the past would make all later steps dearer.
    state.particles.simulated.find(found->id)->forget_over(state.now, state.settings.dt);
    if (!state.particles.simulated.add_emitter(found->id, emitter).ok()) {
        return false;
    }
    found->focus = position;
    return true;
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
