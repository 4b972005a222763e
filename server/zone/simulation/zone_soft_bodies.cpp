#include "server/zone/simulation/zone_soft_bodies.h"

#include "shared/core/assert.h"
#include "shared/math/turn_rate.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

namespace soft = physics::soft;

template <class Links>
auto link_at(Links& links, EntityId entity) {
    return std::lower_bound(
        links.begin(), links.end(), entity, [](const SoftLink& link, EntityId wanted) {
            return link.entity < wanted;
        });
}

const soft::SoftDef& rest_of(const ZoneState& state, world::Row row) {
    return *state.settings.softs[(*state.settings.types)[state.entities.type[row]].solid];
}

void link(ZoneState& state, world::Row row, soft::SoftId body) {
    std::vector<SoftLink>& links = state.soft->links;
    const EntityId entity = state.entities.id[row];
    links.insert(link_at(links, entity), {entity, body});
}

/// Brings the declared fields of an entity's shape up to date with its nodes and its pose. Nothing
/// happens where its type sends no shape.
void follow_deformation(ZoneState& state, world::Row row, soft::SoftId body) {
    world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    if (type.deformation == nullptr) {
        return;
    }
    SoftMatter& matter = *state.soft;
    const soft::SoftDef& rest = rest_of(state, row);
    matter.fits.resize(state.settings.softs.size());
    std::unique_ptr<DeformationFit>& fit = matter.fits[type.solid];
    if (fit == nullptr) {
        fit = std::make_unique<DeformationFit>(*type.deformation, rest);
    }
    const Quat back = e.orientation[row].conjugate();
    matter.moved.resize(rest.nodes.size());
    for (std::size_t node = 0; node < rest.nodes.size(); ++node) {
        matter.moved[node] = back * (matter.bodies.position(body, node) - e.position[row]) -
                             rest.nodes[node].position;
    }
    const std::span<const wire::DeclaredField> fields =
        e.fields().schema(e.type[row])->fields().subspan(type.first_control_point);
    const std::span<const std::uint32_t> told = e.field_values(row).subspan(fields[0].word);
    matter.codes.assign(told.begin(),
                        told.begin() + static_cast<std::ptrdiff_t>(type.deformation->size()));
    // A body that comes to rest is shown as well as it can be from then on.
    const float left = fit->follow(matter.moved, matter.bodies.asleep(body), matter.codes);
    for (std::size_t point = 0; point < matter.codes.size(); ++point) {
        e.put_field(row, fields[point], {&matter.codes[point], 1}, state.now);
    }
    state.report.deformations_beyond += left > type.deformation->bound_m ? 1U : 0U;
}

/// The declared fields of a body that is as it was defined.
void undeform(ZoneState& state, world::Row row) {
    world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    const std::size_t points = type.deformation != nullptr ? type.deformation->size() : 0;
    const auto reset = [&](std::size_t number) {
        const wire::DeclaredField& field = e.fields().schema(e.type[row])->fields()[number];
        e.put_field(row, field, std::span(field.initial).first(1), state.now);
    };
    for (std::size_t point = 0; point < points; ++point) {
        reset(type.first_control_point + point);
    }
    if (type.torn_field != 0) {
        reset(type.torn_field - 1U);
    }
}

/// Clients hear how many of its springs have broken, where its type can tear.
void count_torn(ZoneState& state, world::Row row, soft::SoftId body) {
    world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    if (type.torn_field != 0) {
        const wire::DeclaredField& field =
            e.fields().schema(e.type[row])->fields()[type.torn_field - 1U];
        const std::uint32_t torn = std::min(state.soft->bodies.torn(body), field.most);
        e.put_field(row, field, {&torn, 1}, state.now);
    }
}

/// The columns of one entity after a step.
void copy_state(ZoneState& state, world::Row row, soft::SoftId body) {
    world::Entities& e = state.entities;
    const soft::SoftBodies& bodies = state.soft->bodies;
    const float dt = state.settings.dt;
    const soft::RigidHull hull = bodies.rigid_hull(body);
    const Quat turn =
        bodies.best_fit_turn(body, rest_of(state, row), e.orientation[row]).normalized();
    const bool asleep = bodies.asleep(body);
    e.acceleration[row] =
        asleep ? Vec3(Vec3::Zero()) : Vec3((hull.velocity - e.velocity[row]) / dt);
    e.velocity[row] = asleep ? Vec3(Vec3::Zero()) : hull.velocity;
    e.angular_velocity[row] = asleep ? Vec3(Vec3::Zero()) : turn_rate(e.orientation[row], turn, dt);
    e.position[row] = hull.position;
    e.orientation[row] = turn;
    if (asleep && e.has(row, world::kAtRest)) {
        e.touch_passing(row);
    }
    e.set(row, world::kAtRest, asleep);
    follow_deformation(state, row, body);
    count_torn(state, row, body);
}

}  // namespace

SoftMatter& soft_matter(ZoneState& state) {
    if (state.soft == nullptr) {
        soft::SoftSettings settings;
        settings.gravity = state.settings.physics.gravity;
        settings.sleep_speed_mps = state.settings.physics.sleep_speed_mps;
        settings.sleep_after_s = state.settings.physics.sleep_after_s;
        settings.step_s = state.settings.dt;
        state.soft = std::make_unique<SoftMatter>();
        state.soft->bodies = soft::SoftBodies(settings);
        state.soft->bodies.work_with(state.team);
    }
    return *state.soft;
}

bool is_soft(const ZoneState& state, world::Row row) {
    return (*state.settings.types)[state.entities.type[row]].shape == world::TypeShape::kSoft;
}

SoftLink* soft_link(const ZoneState& state, EntityId entity) {
    if (state.soft == nullptr) {
        return nullptr;
    }
    const auto at = link_at(state.soft->links, entity);
    return at != state.soft->links.end() && at->entity == entity ? &*at : nullptr;
}

soft::SoftId soft_of(const ZoneState& state, EntityId entity) {
    const SoftLink* link = soft_link(state, entity);
    return link != nullptr ? link->body : soft::SoftId();
}

void add_soft(ZoneState& state, world::Row row, bool asleep) {
    SoftMatter& matter = soft_matter(state);
    const world::Entities& e = state.entities;
    soft::SoftDef def = rest_of(state, row);
    def.user = e.id[row].value;
    for (soft::SoftNode& node : def.nodes) {
        const Vec3 arm = e.orientation[row] * node.position;
        node.position = e.position[row] + arm;
        node.velocity = node.pinned ? Vec3(Vec3::Zero())
                                    : Vec3(e.velocity[row] + e.angular_velocity[row].cross(arm));
    }
    const auto body = matter.bodies.add(def);
    ZONED_ASSERT(body.ok(), "soft types were checked when the config was read");
    if (asleep) {
        matter.bodies.sleep(*body);
    }
    link(state, row, *body);
    undeform(state, row);
}

void remove_soft(ZoneState& state, EntityId entity) {
    if (const soft::SoftId body = soft_of(state, entity)) {
        state.soft->bodies.remove(body);
        state.soft->links.erase(link_at(state.soft->links, entity));
    }
}

void push_soft(ZoneState& state, world::Row row, const Vec3& change) {
    if (const soft::SoftId body = soft_of(state, state.entities.id[row])) {
        state.soft->bodies.push(body, change);
        state.entities.velocity[row] = state.soft->bodies.rigid_hull(body).velocity;
    }
}

void place_soft(ZoneState& state, world::Row row) {
    if (const soft::SoftId body = soft_of(state, state.entities.id[row])) {
        state.soft->bodies.place(body, state.entities.position[row], Quat::Identity());
    }
}

soft::SoftParcel take_soft(ZoneState& state, EntityId entity) {
    const soft::SoftId body = soft_of(state, entity);
    if (!body) {
        return {};
    }
    state.soft->links.erase(link_at(state.soft->links, entity));
    return state.soft->bodies.take(body);
}

void give_soft(ZoneState& state, world::Row row, soft::SoftParcel parcel, const Vec3& shift) {
    link(state, row, soft_matter(state).bodies.give(std::move(parcel), shift));
}

std::uint32_t step_soft(ZoneState& state) {
    SoftMatter& matter = *state.soft;
    state.report.soft = matter.bodies.step(state.settings.dt, &state.scene);
    std::uint32_t moved = 0;
    for (const SoftLink& link : matter.links) {
        if (matter.bodies.rigid(link.body)) {
            continue;
        }
        const world::Row row = state.entities.find(link.entity);
        ZONED_ASSERT(row != world::kNoRow, "a soft body belongs to an entity of this zone");
        if (!matter.bodies.asleep(link.body) || !state.entities.has(row, world::kAtRest)) {
            copy_state(state, row, link.body);
            ++moved;
        }
    }
    state.grid_valid = state.grid_valid && moved == 0;
    return moved;
}

SoftCount count_soft(const ZoneState& state) {
    SoftCount count;
    if (state.soft != nullptr) {
        for (const SoftLink& link : state.soft->links) {
            const bool rigid = state.soft->bodies.rigid(link.body);
            ++count.bodies;
            count.rigid += rigid ? 1U : 0U;
            count.awake += rigid || state.soft->bodies.asleep(link.body) ? 0U : 1U;
        }
    }
    return count;
}

void hash_soft(const ZoneState& state, core::StateHash& hash) {
    if (state.soft != nullptr) {
        state.soft->bodies.hash(hash);
    }
}

}  // namespace zoned::zone
