#include "server/zone/snapshot/zone_snapshot.h"

#include "server/ai/serialization/serialize_agents.h"
#include "server/ai/serialization/serialize_paths.h"
#include "server/physics/shapes/shape_archive.h"
#include "server/zone/groups/first_state.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace zoned::zone {

template <class Archive>
void serialize(Archive& archive, JointPlan& plan) {
    archive(plan.name, plan.def, plan.motor);
}

template <class Archive>
void serialize(Archive& archive, EntityJoint& joint) {
    archive(joint.id, joint.a, joint.b, joint.root, joint.number, joint.made_at, joint.joint);
    archive(joint.motor, joint.by_hand, joint.holds_position, joint.target, joint.most);
    archive(joint.max_speed, joint.speed);
    // A plan never changes, so a copy serves as well as the one in the settings.
    if constexpr (Archive::kReads) {
        auto plan = std::make_shared<JointPlan>();
        archive(*plan);
        joint.plan = std::move(plan);
    } else {
        archive(*joint.plan);
    }
}

namespace {

/// Sets of viewers. The matcher takes them for sets that others have written, and looks at all
/// pairs anew.
template <class Archive>
void serialize_sets(Archive& archive, world::Visibility& sets) {
    std::uint64_t count = sets.size();
    archive(count);
    if constexpr (Archive::kReads) {
        sets.clear();
    }
    for (std::uint64_t i = 0; i < count && archive.good(); ++i) {
        if constexpr (Archive::kReads) {
            sets.emplace_back();
        }
        world::VisibleSet& set = sets[static_cast<std::size_t>(i)];
        archive(set.client, set.visible, set.entered, set.left, set.lod_changed);
        if constexpr (Archive::kReads) {
            // `changed` and `stamp` hold within a tick.
            set.stamp = 0;
        }
    }
}

template <class Archive>
void serialize_particles(Archive& archive, ParticlesOfZone& particles) {
    archive(particles.bursts, particles.cosmetic_bursts, particles.cosmetic_due);
    for (ParticlesOfZone::System& system : particles.systems) {
        archive(system.focus);
    }
    if constexpr (Archive::kReads) {
        particles.simulated.load(archive);
    } else {
        particles.simulated.save(archive);
    }
}

template <class Archive>
void serialize_soft(Archive& archive, ZoneState& state) {
    bool any = state.soft != nullptr;
    archive(any);
    if (!any) {
        if constexpr (Archive::kReads) {
            state.soft.reset();
        }
        return;
    }
    SoftMatter& matter = soft_matter(state);
    archive(matter.links);
    if constexpr (Archive::kReads) {
        matter.bodies.load(archive);
        for (const SoftLink& link : matter.links) {
            if (archive.good() && !matter.bodies.contains(link.body)) {
                archive.fail("an entity is a soft body that there is not");
            }
        }
    } else {
        matter.bodies.save(archive);
    }
}

void save_agents_of(const ZoneState& state, core::FieldWriter& archive) {
    if (state.brains_replaced) {
        archive.fail("agents live by other brains than the config's, which has no saved form");
        return;
    }
    std::vector<std::uint8_t> bytes;
    ai::save_agents(state.agents, state.ai_update, state.points_of_interest, bytes);
    archive.bytes(bytes);
    bytes.clear();
    bool mapped = !state.paths.empty();
    archive(mapped);
    if (!ai::serialize_paths(state.paths, bytes)) {
        archive.fail("the map of paths is being brought up to date, which has no saved form");
    }
    archive.bytes(bytes);
}

void load_agents_of(ZoneState& state, core::FieldReader& archive) {
    const auto agents = archive.bytes();
    bool mapped = false;
    archive(mapped);
    const auto paths = archive.bytes();
    if (!archive.good()) {
        return;
    }
    if (state.settings.first_state != nullptr) {
        state.paths = ai::PathService();
        if (mapped) {
            load_maps(state);
        }
    }
    std::string wrong = ai::load_agents(
        agents, state.settings.ai, state.agents, state.ai_update, state.points_of_interest);
    if (wrong.empty()) {
        wrong = ai::deserialize_paths(paths, state.agents, state.paths, state.ai_update);
    }
    if (!wrong.empty()) {
        archive.fail(std::move(wrong));
    }
}

void save_rules(const ZoneState& state, core::FieldWriter& archive) {
    Bytes bytes;
    if (!state.rules->save(bytes)) {
        archive.fail("the rules of this game have no saved state (zone::Rules::save)");
    }
    archive.bytes(bytes);
}

void load_rules(ZoneState& state, core::FieldReader& archive) {
    const auto bytes = archive.bytes();
    std::string wrong = archive.good() ? state.rules->load(bytes) : std::string();
    if (!wrong.empty()) {
        archive.fail(std::move(wrong));
    }
}

physics::GeometryTable geometries_of(const ZoneSettings& settings) {
    physics::GeometryTable table;
    for (const auto* shapes : {&settings.solids, &settings.outers}) {
        for (const physics::Shape& shape : *shapes) {
            table.add(shape);
        }
    }
    for (const SurfaceBody& surface : settings.surfaces) {
        table.add(surface.shape);
    }
    return table;
}

template <class Archive>
void serialize_hash(Archive& archive, core::StateHash& hash) {
    auto word = std::bit_cast<std::uint64_t>(hash);
    archive(word);
    hash = std::bit_cast<core::StateHash>(word);
}

template <class Archive>
void serialize_border(Archive& archive, ZoneState& s) {
    archive(s.near_border, s.ghosts_out, s.ghosts_out_changed, s.ghost_ids, s.ghost_owners);
    archive(s.ghost_contacts, s.accepted, s.ghosts_moved, s.messages_in);
    if constexpr (Archive::kReads) {
        if (s.ghost_ids.size() != s.ghost_owners.size()) {
            archive.fail("ghosts and their owners differ in number");
        }
    }
}

template <class Archive>
void serialize_zone(Archive& archive, ZoneState& s) {
    physics::GeometryTable geometries = geometries_of(s.settings);
    archive.lend(geometries);
    archive.section("zone", [&] {
        archive(s.now, s.frozen, s.next_entity, s.next_event, s.next_store_request);
        archive(s.rng.state, s.rng.stream, s.hashed);
        serialize_hash(archive, s.hash);
    });
    archive.section("entities", [&] { archive(s.entities, s.grid, s.grid_valid); });
    archive.section("physics", [&] {
        if constexpr (Archive::kReads) {
            s.scene.load(archive);
        } else {
            s.scene.save(archive);
        }
    });
    archive.section("assemblies", [&] { archive(s.assemblies); });
    archive.section("soft bodies", [&] { serialize_soft(archive, s); });
    archive.section("particles", [&] { serialize_particles(archive, s.particles); });
    archive.section("doors", [&] {
        archive(s.doors);
        if (!s.settings.statics->platforms().empty()) {
            archive(s.platforms);
        }
    });
    archive.section("agents", [&] {
        if constexpr (Archive::kReads) {
            load_agents_of(s, archive);
        } else {
            save_agents_of(s, archive);
        }
    });
    archive.section("rules", [&] {
        archive(s.rules_started, s.timers, s.entity_names, s.triggers.inside);
        if constexpr (Archive::kReads) {
            load_rules(s, archive);
        } else {
            save_rules(s, archive);
        }
    });
    archive.section("clients", [&] { archive(s.clients, s.audited_radii); });
    archive.section("interest", [&] {
        archive(s.viewers);
        serialize_sets(archive, s.visibility);
        serialize_sets(archive, s.filtered.heard);
        archive(s.filtered.viewers);
    });
    archive.section("replication", [&] {
        if constexpr (Archive::kReads) {
            s.replicator.load(archive);
        } else {
            s.replicator.save(archive);
        }
    });
    archive.section("history", [&] { archive(s.history); });
    archive.section("border", [&] { serialize_border(archive, s); });
}

/// Whether the parts name each other rightly; else the first one that does not.
std::string unsound(const ZoneState& s) {
    const world::Entities& e = s.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        if (e.type[row] >= s.settings.types->size()) {
            return "entities: one is of a type that there is not";
        }
        if (e.body[row] && !s.scene.contains(e.body[row])) {
            return "entities: one has a body that there is not";
        }
        if (e.stance[row] >= world::kStances) {
            return "entities: one is in a stance that there is not";
        }
    }
    for (const EntityJoint& joint : s.assemblies.joints) {
        if (!s.scene.contains(joint.joint)) {
            return "assemblies: a joint is not in the scene";
        }
    }
    if (s.doors.body.size() != s.settings.statics->doors().size()) {
        return "doors: more or fewer than there are";
    }
    for (const BodyId body : s.doors.body) {
        if (body && !s.scene.contains(body)) {
            return "doors: one has a body that there is not";
        }
    }
    if (s.platforms.size() != s.settings.statics->platforms().size()) {
        return "platforms: more or fewer than there are";
    }
    for (const BodyId body : s.platforms) {
        if (!s.scene.contains(body)) {
            return "platforms: one has a body that there is not";
        }
    }
    if (!s.triggers.inside.empty() && s.triggers.inside.size() != s.settings.triggers.size()) {
        return "triggers: more or fewer than there are";
    }
    const bool ascend = std::is_sorted(
        s.clients.begin(), s.clients.end(), [](const ZoneClient& a, const ZoneClient& b) {
            return a.client < b.client;
        });
    if (!ascend) {
        return "clients: in no order";
    }
    return {};
}

}  // namespace

void save_zone(const ZoneState& state, core::FieldWriter& archive) {
    serialize_zone(archive, const_cast<ZoneState&>(state));  // writing leaves it as it is
}

void load_zone(ZoneState& state, core::FieldReader& archive) {
    serialize_zone(archive, state);
    if (archive.good()) {
        std::string wrong = unsound(state);
        if (!wrong.empty()) {
            archive.fail(std::move(wrong));
        }
    }
}

}  // namespace zoned::zone
