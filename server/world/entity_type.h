// EntityType: the common properties of all entities of one kind; the type table is fixed while a
// world lives.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/aabb.h"
#include "shared/motion/apply_input.h"
#include "shared/wire/declared/declared_fields.h"
#include "shared/wire/declared/deformation_lattice.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::world {

enum class EntityKind : std::uint8_t {
    kProp,       ///< a rigid or soft body under physics
    kCharacter,  ///< a capsule moved by apply_input (player or NPC), kinematic for the physics
};

enum class TypeShape : std::uint8_t {
    kSphere,
    kBox,
    kCapsule,
    kSolid,  ///< a convex hull, or several shapes as one body: the physics knows more of it
    kSoft    ///< a soft body: nodes and springs
};

inline constexpr int kStances =
    8;  ///< behavioural radii: which of them holds is a column of the entity

/// The stances that every world has, in the order of the columns; a config may name more of
/// them, from kFirstNamedStance on.
enum class Stance : std::uint8_t {
    kNormal = 0,
    kIdle = 1,
    kRunning = 2,
    kRiding = 3
};

inline constexpr int kFirstNamedStance = 4;

/// The rule that keeps an entity from viewers although its radii reach them.
enum class VisibilityFilter : std::uint8_t {
    kNothing,
    kLineOfSight,  ///< statics and bodies between
    kRules,        ///< Rules::may_hear
};

/// How far a viewer hears in the direction of its view, beside its nimbus (a spyglass).
struct Cone {
    float length_m = 0.0F;        ///< 0: none
    float half_angle_rad = 0.0F;  ///< (0, pi]
};

/// Players operate it: a button, pressed within reach, turns it on or off.
struct Lever {
    float reach_m = 1.5F;      ///< from its centre to the avatar's
    std::uint16_t button = 0;  ///< of InputCommand::buttons, a bit
    wire::FieldId field;       ///< declared, a bool: whether it is on
};

struct EntityType {
    std::string name;
    EntityKind kind = EntityKind::kProp;
    TypeShape shape = TypeShape::kBox;
    /// Box: half sizes, m. Soft: of its box as defined, about the centre of mass.
    Vec3 half_extents = Vec3::Constant(0.5F);
    float radius = 0.5F;        ///< sphere, capsule; solid, soft: of the sphere that holds it, m
    float half_segment = 0.5F;  ///< capsule: half of the segment along y, m
    std::uint16_t solid = 0;    ///< kSolid, kSoft: which of those that the world has
    Quat stands = Quat::Identity();  ///< kSolid: how it is turned as it was written down
    Aabb standing;                   ///< kSolid, kSoft: its box then, about the centre, m
    float mass = 1.0F;               ///< kg, > 0
    Mat3 inertia = Mat3::Zero();     ///< see physics::BodyDef; zero: that of the shape
    float friction = 0.5F;
    float restitution = 0.0F;
    float rolling_m = 0.0F;     ///< see physics::Material
    float spinning_m = 0.0F;    ///< likewise
    float drag = 0.0F;          ///< props: share of its speed that it loses per second, 1/s
    float angular_drag = 0.0F;  ///< rigid props: share of its spin that it loses per second, 1/s
    /// 1 + index of the assembly that it is a part of; 0: one body alone.
    std::uint16_t assembly = 0;
    /// Number of the part. The root, 0, stands for the whole: `stands` is how the root is turned,
    /// and `standing` holds all parts, about the root's centre.
    std::uint16_t part = 0;
    motion::CharacterLimits character;     ///< kCharacter only
    std::array<float, kStances> aura_m{};  ///< how far the entity is heard, by stance, m
    std::array<float, kStances>
        nimbus_m{};  ///< how far a viewer with this avatar listens, by stance, m
    std::array<Cone, kStances> nimbus_cone{};  ///< by stance; about its yaw
    VisibilityFilter visibility_filter = VisibilityFilter::kNothing;
    bool rewindable = false;  ///< rules may ask where a client saw it: its poses are remembered
    float max_acceleration_mps2 = 20.0F;  ///< declared limit a_max of the promised bound
    float max_velocity_jump_mps = 10.0F;  ///< declared limit dv_max of the promised bound
    float priority = 1.0F;                ///< relative weight under a byte budget
    float single_beyond_m = 0.0F;    ///< farther from all players a compound is one hull; 0: never
    float particle_beyond_m = 0.0F;  ///< farther from all players it is a point; 0: never
    std::uint16_t brain = 0;         ///< 1 + index of the brain; 0 = no brain
    std::shared_ptr<const wire::FieldSchema> fields;  ///< declared by the game; null: none
    /// kSoft: how clients hear of its shape; null: they do not.
    std::shared_ptr<const wire::DeformationLattice> deformation;
    std::uint16_t first_control_point = 0;  ///< among the fields: those of the lattice follow it
    std::uint16_t torn_field = 0;  ///< 1 + number of the field that counts broken springs; 0: none
    std::optional<Lever> lever;    ///< none: nobody operates it

    /// Radius of a sphere about the centre that holds the shape, m.
    [[nodiscard]] float extent() const {
        switch (shape) {
            case TypeShape::kBox:
                return half_extents.norm();
            case TypeShape::kCapsule:
                return radius + half_segment;
            case TypeShape::kSphere:
            case TypeShape::kSolid:
            case TypeShape::kSoft:
                break;
        }
        return radius;
    }

    /// Half of the box that holds the shape as it stands, m.
    [[nodiscard]] Vec3 half_size() const {
        switch (shape) {
            case TypeShape::kBox:
                return half_extents;
            case TypeShape::kCapsule:
                return {radius, radius + half_segment, radius};
            case TypeShape::kSphere:
                break;
            case TypeShape::kSolid:
            case TypeShape::kSoft:
                return 0.5F * (standing.upper - standing.lower);
        }
        return Vec3::Constant(radius);
    }

    /// Declared limit of the promised bound: the largest sudden change of its rate of turn. An
    /// impact changes the velocity of its surface by max_velocity_jump_mps at most, as seen from
    /// its centre; what is large may also be struck far out.
    [[nodiscard]] float max_spin_jump_rps() const {
        constexpr float kOfLarge_rps = 40.0F;
        return std::max(kOfLarge_rps, max_velocity_jump_mps / half_size().minCoeff());
    }

    /// Spawned, it comes with all parts of its assembly.
    [[nodiscard]] bool is_root() const { return assembly != 0 && part == 0; }

    /// Whether it may be simulated as less than it is.
    [[nodiscard]] bool reducible() const {
        return single_beyond_m > 0.0F || particle_beyond_m > 0.0F;
    }

    /// Upright entities turn about y only; their orientation travels as a yaw.
    [[nodiscard]] bool upright() const { return kind == EntityKind::kCharacter; }
};

using TypeTable = std::vector<EntityType>;

/// The declared fields of all types; empty where no type has any.
[[nodiscard]] inline wire::FieldSchemas field_schemas(const TypeTable& types) {
    wire::FieldSchemas schemas;
    for (const EntityType& type : types) {
        if (type.fields != nullptr) {
            schemas.resize(types.size());
            schemas[static_cast<std::size_t>(&type - types.data())] = type.fields;
        }
    }
    return schemas;
}

}  // namespace zoned::world
