#include "server/config/world/scatter.h"

#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/zone/simulation/type_body.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <unordered_map>
#include <utility>

namespace zoned::config {

namespace {

/// Entities begin this far above their ground, so that none begins in contact, m.
constexpr float kClearance_m = 0.002F;
constexpr float kApart_m = 0.05F;       // between two entities
constexpr float kSpawnRadius_m = 1.0F;  // kept free around spawn points
constexpr float kSpawnDisc_m = 0.5F;    // has to be level
constexpr float kSpawnRise_m = 0.25F;   // over that disc on surfaces: 27 degrees
constexpr float kInner = 0.7F;          // half a square's edge within a disc, of its radius
constexpr int kAttempts = 400;          // per entity, before it is a mistake
constexpr std::size_t kMaxEntities = 1000000;

/// How an entity of a type lies on level ground: a capsule prop lies on its side.
struct Pose {
    float radius = 0.0F;  ///< of the disc that it covers, m
    float height = 0.0F;  ///< m
    float centre = 0.0F;  ///< of its centre above its lowest point, m
    bool lying = false;
};

Pose pose_in(const Aabb& standing) {
    const Vec3 reach = standing.lower.cwiseAbs().cwiseMax(standing.upper.cwiseAbs());
    return {elementary::hypot(reach.x(), reach.z()),
            standing.upper.y() - standing.lower.y(),
            -standing.lower.y(),
            false};
}

Pose pose_of(const world::EntityType& type) {
    if (type.kind == world::EntityKind::kCharacter) {
        const float height = 2.0F * (type.radius + type.half_segment);
        return {type.radius, height, 0.5F * height, false};
    }
    if (type.is_root()) {
        return pose_in(type.standing);
    }
    switch (type.shape) {
        case world::TypeShape::kSphere:
            return {type.radius, 2.0F * type.radius, type.radius, false};
        case world::TypeShape::kCapsule:
            return {type.radius + type.half_segment, 2.0F * type.radius, type.radius, true};
        case world::TypeShape::kSolid:
        case world::TypeShape::kSoft:
            return pose_in(type.standing);
        case world::TypeShape::kBox:
            break;
    }
    return {elementary::hypot(type.half_extents.x(), type.half_extents.z()),
            2.0F * type.half_extents.y(),
            type.half_extents.y(),
            false};
}

InitialEntity make_entity(TypeIndex index,
                          const world::EntityType& type,
                          const Pose& pose,
                          const Vec3d& position,
                          std::uint16_t yaw) {
    InitialEntity entity;
    entity.type = index;
    entity.position = position;
    const double angle = yaw * (2.0 * std::numbers::pi / 65536.0);
    Eigen::Quaterniond turned = turn_rad(angle, Vec3d::UnitY());
    if (type.shape == world::TypeShape::kSolid || type.is_root()) {
        turned = turned * type.stands.cast<double>();
    }
    if (pose.lying) {
        turned = turned * turn_rad(0.5 * std::numbers::pi, Vec3d::UnitZ());
    }
    entity.orientation = Quat(turned.cast<float>()).normalized();
    entity.yaw = type.upright() ? yaw : std::uint16_t{0};
    return entity;
}

/// Discs that are taken, in buckets of a grid. Buckets are looked up, never walked in order.
class Occupied {
  public:
    void add(float x, float z, float radius) {
        largest_ = std::max(largest_, radius);
        buckets_[key(cell(x), cell(z))].push_back({x, z, radius});
    }

    /// True when a disc keeps `apart` metres from all others.
    [[nodiscard]] bool fits(float x, float z, float radius, float apart) const {
        const float reach = radius + largest_ + apart;
        for (int cz = cell(z - reach); cz <= cell(z + reach); ++cz) {
            for (int cx = cell(x - reach); cx <= cell(x + reach); ++cx) {
                const auto it = buckets_.find(key(cx, cz));
                if (it == buckets_.end()) {
                    continue;
                }
                for (const Disc& disc : it->second) {
                    const float wish = radius + disc.radius + apart;
                    const float dx = disc.x - x;
                    const float dz = disc.z - z;
                    if (dx * dx + dz * dz < wish * wish) {
                        return false;
                    }
                }
            }
        }
        return true;
    }

  private:
    struct Disc {
        float x = 0.0F;
        float z = 0.0F;
        float radius = 0.0F;
    };

    static constexpr float kCell_m = 8.0F;

    static int cell(float at) { return static_cast<int>(std::floor(at / kCell_m)); }

    static std::uint64_t key(int x, int z) {
        return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
               static_cast<std::uint32_t>(z);
    }

    std::unordered_map<std::uint64_t, std::vector<Disc>> buckets_;
    float largest_ = 0.0F;
};

struct Rectangle {
    float min_x = 0.0F;
    float min_z = 0.0F;
    float max_x = 0.0F;
    float max_z = 0.0F;
};

std::uint16_t yaw_from(double degrees) {
    const double turns = degrees / 360.0;
    return static_cast<std::uint16_t>(
        static_cast<std::int64_t>(std::llround((turns - std::floor(turns)) * 65536.0)) & 0xFFFF);
}

class Placer {
  public:
    Placer(const proto::config::Config& config,
           const Terrain& terrain,
           Settings& settings,
           Diagnostics& diagnostics)
        : config_(config),
          terrain_(terrain),
          settings_(settings),
          diagnostics_(diagnostics) {
        for (const zone::SpawnPoint& spawn : settings.spawn_points) {
            const Vec3d& point = spawn.position;
            occupied_.add(
                static_cast<float>(point.x()), static_cast<float>(point.z()), kSpawnRadius_m);
        }
    }

    void place_one(const proto::config::Placement& placement, const std::string& path) {
        if (!placement.has_x_m() || !placement.has_z_m()) {
            diagnostics_.add(path, "an entity needs x_m and z_m");
            return;
        }
        const int type = type_named(placement.type(), path + ".type");
        const auto& world = config_.world();
        if (placement.x_m() < world.min_x_m() || placement.x_m() > world.max_x_m() ||
            placement.z_m() < world.min_z_m() || placement.z_m() > world.max_z_m()) {
            diagnostics_.add(path, "stands outside the world");
            return;
        }
        if (type < 0) {
            return;
        }
        const world::EntityType& kind = settings_.types[static_cast<std::size_t>(type)];
        const Pose pose = pose_of(kind);
        const auto x = static_cast<float>(placement.x_m());
        const auto z = static_cast<float>(placement.z_m());
        const float bottom = placement.has_y_m() ? static_cast<float>(placement.y_m()) - pose.centre
                                                 : stand_on(x, z, pose.radius) + kClearance_m;
        InitialEntity entity =
            make_entity(static_cast<TypeIndex>(type),
                        kind,
                        pose,
                        Vec3d(placement.x_m(), bottom + pose.centre, placement.z_m()),
                        yaw_from(placement.yaw_deg()));
        if (!(kind.is_root() ? parts_clear(kind, entity) : disc_clear(x, z, bottom, pose))) {
            diagnostics_.add(path, "stands inside a static box or below the ground");
            return;
        }
        if (placement.has_name() && check_name(placement.name(), "entity", path, diagnostics_) &&
            !names_.insert(placement.name()).second) {
            diagnostics_.add(path + ".name",
                             "'" + placement.name() + "' is the name of another entity");
        }
        occupied_.add(x, z, pose.radius);
        entity.name = placement.name();
        add(std::move(entity),
            kind,
            path,
            placement.asleep() && (placement.has_y_m() || !slopes(x, z, pose.radius)));
    }

    void scatter(const proto::config::Scatter& entry, int number, const std::string& path) {
        const int type = type_named(entry.type(), path + ".type");
        Rectangle region;
        if (!region_of(entry, path, region) || type < 0) {
            return;
        }
        if (settings_.initial.size() + entry.count() > kMaxEntities) {
            diagnostics_.add(path + ".count", "more than 1000000 entities in all");
            return;
        }
        const world::EntityType& kind = settings_.types[static_cast<std::size_t>(type)];
        const Pose pose = pose_of(kind);
        const auto apart =
            std::max(kApart_m, static_cast<float>(entry.min_distance_m()) - 2.0F * pose.radius);
        core::Rng rng(settings_.seed ^ core::mix(entry.seed()), static_cast<std::uint64_t>(number));
        Occupied own;
        for (std::uint32_t i = 0; i < entry.count(); ++i) {
            if (!scatter_one(entry, type, pose, region, apart, path, rng, own)) {
                diagnostics_.add(path,
                                 "only " + std::to_string(i) + " of " +
                                     std::to_string(entry.count()) + " '" + entry.type() +
                                     "' find a free and level place; lower count or "
                                     "min_distance_m, or widen the region");
                return;
            }
        }
    }

  private:
    [[nodiscard]] int type_named(const std::string& name, const std::string& path) {
        const int type = find_type(settings_, name);
        if (type < 0) {
            diagnostics_.add(
                path, name.empty() ? "type is missing" : "there is no type named '" + name + "'");
        }
        return type;
    }

    bool region_of(const proto::config::Scatter& entry, const std::string& path, Rectangle& out) {
        const auto& world = config_.world();
        if (!entry.has_region()) {
            out = {static_cast<float>(world.min_x_m()),
                   static_cast<float>(world.min_z_m()),
                   static_cast<float>(world.max_x_m()),
                   static_cast<float>(world.max_z_m())};
            return true;
        }
        const auto& region = entry.region();
        if (!region.has_min_x_m() || !region.has_min_z_m() || !region.has_max_x_m() ||
            !region.has_max_z_m() || region.min_x_m() >= region.max_x_m() ||
            region.min_z_m() >= region.max_z_m()) {
            diagnostics_.add(path + ".region",
                             "a region needs min_x_m < max_x_m and min_z_m < max_z_m");
            return false;
        }
        if (region.min_x_m() < world.min_x_m() || region.max_x_m() > world.max_x_m() ||
            region.min_z_m() < world.min_z_m() || region.max_z_m() > world.max_z_m()) {
            diagnostics_.add(path + ".region", "reaches outside the world");
            return false;
        }
        out = {static_cast<float>(region.min_x_m()),
               static_cast<float>(region.min_z_m()),
               static_cast<float>(region.max_x_m()),
               static_cast<float>(region.max_z_m())};
        return true;
    }

    bool scatter_one(const proto::config::Scatter& entry,
                     int type,
                     const Pose& pose,
                     const Rectangle& region,
                     float apart,
                     const std::string& path,
                     core::Rng& rng,
                     Occupied& own) {
        const world::EntityType& kind = settings_.types[static_cast<std::size_t>(type)];
        const float r = pose.radius;
        const double slope = entry.max_slope_deg() * std::numbers::pi / 180.0;
        const float rise = slope > 0.0 ? r * static_cast<float>(elementary::tan(slope)) : 0.0F;
        if (region.max_x - region.min_x < 2.0F * r || region.max_z - region.min_z < 2.0F * r) {
            return false;
        }
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            const float x = rng.range(region.min_x + r, region.max_x - r);
            const float z = rng.range(region.min_z + r, region.max_z - r);
            const auto yaw = static_cast<std::uint16_t>(rng.next() >> 16);
            if (!occupied_.fits(x, z, r, kApart_m) || !own.fits(x, z, r, apart) ||
                !terrain_.level(x, z, r, rise)) {
                continue;
            }
            // On a slope the uphill corners of the square around the disc lie in the hill: the
            // square within the disc has to do.
            const bool level = rise == 0.0F || terrain_.level(x, z, r);
            const float surface = level ? terrain_.height(x, z) : terrain_.highest(x, z, r);
            const float inner = level ? r : kInner * r;
            const float bottom = surface + kClearance_m;
            const bool raised = surface > static_cast<float>(config_.world().ground_height_m());
            const Aabb area{Vec3(x - inner, bottom, z - inner),
                            Vec3(x + inner, bottom + pose.height, z + inner)};
            if ((raised && !entry.statics_allowed()) || !terrain_.clear(area)) {
                continue;
            }
            occupied_.add(x, z, r);
            own.add(x, z, r);
            add(make_entity(static_cast<TypeIndex>(type),
                            kind,
                            pose,
                            Vec3d(x, bottom + pose.centre, z),
                            yaw),
                kind,
                path,
                entry.asleep() && level);
            return true;
        }
        return false;
    }

    void add(InitialEntity entity,
             const world::EntityType& kind,
             const std::string& path,
             bool asleep) {
        if (asleep && kind.is_root()) {
            diagnostics_.add(path + ".asleep", "what joints hold together begins awake");
        }
        const double most = config_.replication().quantization().vertical_extent_m();
        if (std::abs(entity.position.y()) > most) {
            diagnostics_.add(path,
                             "stands at " + std::to_string(std::lround(entity.position.y())) +
                                 " m, farther up or down than states can tell: "
                                 "replication.quantization.vertical_extent_m is " +
                                 std::to_string(std::lround(most)));
        }
        entity.asleep = asleep && kind.kind == world::EntityKind::kProp;
        settings_.initial.push_back(std::move(entity));
    }

    /// Half of the covered disc: a box in a corner must not be refused for its rounded bounds.
    [[nodiscard]] bool disc_clear(float x, float z, float bottom, const Pose& pose) const {
        const float inner = kInner * pose.radius;
        return terrain_.clear(
            {Vec3(x - inner, bottom, z - inner), Vec3(x + inner, bottom + pose.height, z + inner)});
    }

    /// The middle of each part: its corners may be rounder than its bounds.
    [[nodiscard]] bool parts_clear(const world::EntityType& kind,
                                   const InitialEntity& entity) const {
        const Vec3 root = entity.position.cast<float>();
        for (const zone::AssemblyPart& part : (*settings_.assemblies)[kind.assembly - 1U].parts) {
            const Vec3 centre = root + entity.orientation * part.position;
            const Quat turned = entity.orientation * part.orientation;
            const physics::Shape shape =
                zone::body_of(settings_.types[part.type], settings_.solids).shape;
            const Aabb box = physics::shape_bounds(shape, Vec3::Zero(), turned.toRotationMatrix());
            if (!terrain_.clear({centre + kInner * box.lower, centre + kInner * box.upper})) {
                return false;
            }
        }
        return true;
    }

    /// On a surface that is not level there: an entity there has to come to rest first.
    [[nodiscard]] bool slopes(float x, float z, float radius) const {
        return terrain_.on_surface(x, z) && !terrain_.level(x, z, radius);
    }

    /// The height on which a placed entity stands: the highest place under its disc on slopes from
    /// a file, else under the middle of it, so that it may stand at the foot of a wall.
    [[nodiscard]] float stand_on(float x, float z, float radius) const {
        if (slopes(x, z, radius)) {
            return terrain_.highest(x, z, radius);
        }
        const float d = 0.5F * radius;
        return std::max({terrain_.height(x, z),
                         terrain_.height(x + d, z),
                         terrain_.height(x - d, z),
                         terrain_.height(x, z + d),
                         terrain_.height(x, z - d)});
    }

    const proto::config::Config& config_;
    const Terrain& terrain_;
    Settings& settings_;
    Diagnostics& diagnostics_;
    Occupied occupied_;
    std::set<std::string> names_;
};

/// Half the height of the tallest character without an agent, as players may be.
float avatar_half_height(const world::TypeTable& types) {
    float half = 0.0F;
    for (const world::EntityType& type : types) {
        if (type.kind == world::EntityKind::kCharacter && type.brain == 0) {
            half = std::max(half, type.radius + type.half_segment);
        }
    }
    return half;
}

}  // namespace

int find_type(const Settings& settings, const std::string& name) {
    for (std::size_t i = 0; i < settings.types.size(); ++i) {
        if (settings.types[i].name == name && !name.empty()) {
            return static_cast<int>(i);
        }
    }
    return -1;
}

void place_entities(const proto::config::Config& config,
                    const Terrain& terrain,
                    Settings& settings,
                    Diagnostics& diagnostics) {
    Placer placer(config, terrain, settings, diagnostics);
    for (int i = 0; i < config.entity_size(); ++i) {
        placer.place_one(config.entity(i), join_path("", "entity", i));
    }
    for (int i = 0; i < config.scatter_size(); ++i) {
        placer.scatter(config.scatter(i), i, join_path("", "scatter", i));
    }
}

void place_spawn_points(const proto::config::Config& config,
                        const Terrain& terrain,
                        Settings& settings,
                        Diagnostics& diagnostics) {
    const auto& world = config.world();
    const float stand = avatar_half_height(settings.types) + kClearance_m;
    std::set<std::string> names;
    for (int i = 0; i < config.spawn_size(); ++i) {
        const auto& point = config.spawn(i);
        const std::string path = join_path("", "spawn", i);
        if (point.has_name() && check_name(point.name(), "a spawn point", path, diagnostics) &&
            !names.insert(point.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + point.name() + "' is the name of another spawn point");
        }
        if (!point.has_x_m() || !point.has_z_m()) {
            diagnostics.add(path, "a spawn point needs x_m and z_m");
            continue;
        }
        if (point.x_m() <= world.min_x_m() || point.x_m() >= world.max_x_m() ||
            point.z_m() <= world.min_z_m() || point.z_m() >= world.max_z_m()) {
            diagnostics.add(path, "spawn point outside the world");
            continue;
        }
        const auto x = static_cast<float>(point.x_m());
        const auto z = static_cast<float>(point.z_m());
        // Surfaces from files are hardly ever level: a slope to stand on is enough there.
        const bool sloped = terrain.on_surface(x, z);
        if (!terrain.level(x, z, kSpawnDisc_m, sloped ? kSpawnRise_m : 0.0F)) {
            diagnostics.add(path,
                            "the ground is not level here: a wall, an edge or a ramp is "
                            "within 0.5 m");
            continue;
        }
        const float floor = sloped ? terrain.highest(x, z, kSpawnDisc_m) : terrain.height(x, z);
        settings.spawn_points.push_back(
            {Vec3d(point.x_m(), floor + stand, point.z_m()), point.name(), point.team()});
    }
}

}  // namespace zoned::config
