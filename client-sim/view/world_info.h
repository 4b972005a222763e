// WorldInfo: the constants of the world as a client learns them at login, shared by all bots of a
// process.
#pragma once

#include "shared/clock/shared_environment.h"
#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/math/types.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/burst.h"
#include "shared/motion/static_geometry.h"
#include "shared/wire/declared/declared_fields.h"
#include "shared/wire/declared/deformation_lattice.h"
#include "shared/wire/quantize.h"
#include "shared/wire/session/world_messages.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::view {

struct TypeInfo {
    std::string name;
    bool upright = false;
    bool character = false;
    float max_acceleration_mps2 = 0.0F;  ///< a_max of the promised bound
    float max_velocity_jump_mps = 0.0F;  ///< dv_max of the promised bound
    float max_spin_jump_rps = 0.0F;      ///< the same for its rate of turn
    motion::CharacterLimits limits;
    std::uint32_t seats = 0;  ///< characters may ride on it
    /// Soft bodies: the lattice whose control points are the fields from that one on.
    std::optional<wire::DeformationLattice> deformation;
    std::size_t first_control_point = 0;
};

struct Lod {
    float radius_m = 0.0F;  ///< 0: beyond all radii
    float position_bound_m = 0.0F;
    float orientation_bound_rad = 0.0F;
};

struct ZoneInfo {
    ZoneId id;
    Vec3d origin = Vec3d::Zero();  ///< of local (0, 0, 0), world coordinates
    double lower_x = 0.0;
    double lower_z = 0.0;
    double upper_x = 0.0;
    double upper_z = 0.0;
    motion::StaticGeometry geometry;  ///< zone-local coordinates
};

/// Smoke, rain: drawn from motion::replay() for any tick. The server sends nothing more about it
/// except an event for each burst.
struct CosmeticInfo {
    std::string name;
    std::vector<motion::CosmeticEmitter> emitters;  ///< world coordinates
    motion::CosmeticEmitter air;  ///< gravity, drag and wind of bursts; its emitter is idle
    std::optional<motion::BurstKind> burst;  ///< none: events of it are malformed
};

/// A door's timetable gives its open times in ticks; its position is in ZoneInfo::geometry.
struct DoorInfo {
    std::string name;
    motion::Timetable times;
    bool by_rules = false;  ///< as the timetable says until DoorCourses say otherwise
};

/// A platform's box is in ZoneInfo::geometry.
struct PlatformInfo {
    std::string name;
    motion::PlatformPath path;
};

/// Immutable once made.
struct WorldInfo {
    double tick_s = 1.0 / 30.0;
    wire::Quantization quantization;
    std::vector<TypeInfo> types;
    wire::FieldSchemas fields;  ///< declared ones by type; empty: no type has any
    std::vector<Lod> lods;
    std::vector<ZoneInfo> zones;
    std::vector<DoorInfo> doors;          ///< in the order of StaticGeometry::doors()
    std::vector<PlatformInfo> platforms;  ///< in the order of StaticGeometry::platforms()
    float interest_hysteresis = 0.0F;
    std::vector<CosmeticInfo> cosmetics;
    clock::EnvironmentDefs environment;  ///< clocks and variables that the client runs for itself

    /// Whether rules move any of the doors and platforms.
    [[nodiscard]] bool has_moved_parts() const;

    /// The same world for one client, whose doors and platforms are as courses say. Shares the
    /// geometry.
    [[nodiscard]] WorldInfo with_courses(
        const std::shared_ptr<const motion::DoorCourses>& door_courses,
        const std::shared_ptr<const motion::PlatformCourses>& platform_courses) const;

    /// nullptr for a zone that the world does not have.
    [[nodiscard]] const ZoneInfo* zone(ZoneId id) const;
    /// The zone whose region holds a point, or nullptr.
    [[nodiscard]] const ZoneInfo* zone_at(double x, double z) const;
};

/// Checks and converts a description; fails with the reason when a client could not use it.
core::Result<WorldInfo> read_world(const wire::WorldDescriptionMessage& description);

/// One World per config digest: five hundred bots share one copy of the static geometry.
class WorldCache {
  public:
    /// nullptr when the description makes no sense; `error` says why.
    std::shared_ptr<const WorldInfo> get(const std::string& digest,
                                         const wire::WorldDescriptionMessage& description,
                                         std::string& error);

  private:
    std::map<std::string, std::shared_ptr<const WorldInfo>> worlds_;
};

}  // namespace zoned::view
