#include "client-sim/view/world_info.h"

#include "client-sim/view/cosmetics.h"
#include "shared/core/utf8.h"
#include "shared/wire/publication.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace zoned::view {

namespace {

using Failure = core::Result<WorldInfo>;

wire::Quantization read_quantization(const wire::QuantizationMessage& q) {
    wire::Quantization out;
    out.position_step_m = q.position_step_m;
    out.velocity_step_mps = q.velocity_step_mps;
    out.acceleration_step_mps2 = q.acceleration_step_mps2;
    out.angular_velocity_step_rps = q.angular_velocity_step_rps;
    out.orientation_bits = static_cast<int>(q.orientation_bits);
    out.yaw_bits = static_cast<int>(q.yaw_bits);
    out.horizontal_extent_m = q.horizontal_extent_m;
    out.vertical_extent_m = q.vertical_extent_m;
    out.max_speed_mps = q.max_speed_mps;
    out.gravity_mps2 = q.gravity_mps2;
    for (std::size_t lod = 0; lod < std::min(q.lod_shift.size(), out.lod_shift.size()); ++lod) {
        out.lod_shift[lod] = {static_cast<std::uint8_t>(std::min(q.lod_shift[lod].place, 10U)),
                              static_cast<std::uint8_t>(std::min(q.lod_shift[lod].turn, 5U))};
    }
    return out;
}

bool sensible(const wire::Quantization& q) {
    return q.position_step_m > 0.0F && q.position_step_m <= 1.0F && q.velocity_step_mps > 0.0F &&
           q.velocity_step_mps <= 1.0F && q.acceleration_step_mps2 > 0.0F &&
           q.acceleration_step_mps2 <= 10.0F && q.angular_velocity_step_rps > 0.0F &&
           q.angular_velocity_step_rps <= 10.0F && q.orientation_bits >= 5 &&
           q.orientation_bits <= 15 && q.yaw_bits >= 5 && q.yaw_bits <= 16 &&
           q.horizontal_extent_m > 0.0F && q.horizontal_extent_m < 1e6F &&
           q.vertical_extent_m > 0.0F && q.vertical_extent_m < 1e6F && q.max_speed_mps > 0.0F &&
           q.max_speed_mps < 1e6F && q.gravity_mps2 >= 0.0F && q.gravity_mps2 < 1e3F;
}

/// Servers that do not tell max_spin_jump_rps go by this.
constexpr float kUndeclared_rps = 40.0F;

TypeInfo read_type(const wire::EntityTypeMessage& t) {
    TypeInfo type;
    type.name = core::is_clean_utf8(t.name) ? t.name : "?";
    type.upright = t.upright;
    type.character = t.character;
    type.seats = t.seats;
    type.max_acceleration_mps2 = t.max_acceleration_mps2;
    type.max_velocity_jump_mps = t.max_velocity_jump_mps;
    type.max_spin_jump_rps = t.max_spin_jump_rps > 0.0F ? t.max_spin_jump_rps : kUndeclared_rps;
    if (t.limits) {
        const wire::CharacterLimitsMessage& l = *t.limits;
        type.limits.radius = l.radius;
        type.limits.half_segment = l.half_segment;
        type.limits.speed = l.speed;
        type.limits.sprint_factor = l.sprint_factor;
        type.limits.acceleration = l.acceleration;
        type.limits.air_acceleration = l.air_acceleration;
        type.limits.jump_speed = l.jump_speed;
        type.limits.max_slope_cos = l.max_slope_cos;
        type.limits.step_down = l.step_down;
        type.limits.step_up = l.step_up;
        type.limits.gravity = l.gravity;
    }
    return type;
}

/// Boxes are sent in world coordinates; each zone's geometry lies around that zone's origin.
motion::StaticBox box_around(const wire::StaticBoxMessage& b, const Vec3d& origin) {
    motion::StaticBox box;
    const Vec3d centre(b.centre[0], b.centre[1], b.centre[2]);
    box.centre = (centre - origin).cast<float>();
    box.half_extents = Vec3(b.half_extents[0], b.half_extents[1], b.half_extents[2]);
    if (b.orientation.size() == 4) {
        box.orientation =
            Quat(b.orientation[0], b.orientation[1], b.orientation[2], b.orientation[3]);
    }
    return box;
}

std::vector<motion::StaticBox> boxes_around(const wire::WorldDescriptionMessage& description,
                                            const Vec3d& origin) {
    std::vector<motion::StaticBox> boxes;
    boxes.reserve(description.boxes.size());
    for (const wire::StaticBoxMessage& b : description.boxes) {
        boxes.push_back(box_around(b, origin));
    }
    return boxes;
}

/// Needs a description that passed sensible().
motion::Timetable read_times(const wire::DoorMessage& d) {
    motion::Timetable times;
    times.period = d.period;
    times.shift = d.shift;
    for (std::size_t i = 0; i + 1 < d.open.size(); i += 2) {
        times.open.push_back({d.open[i], d.open[i + 1]});
    }
    return times;
}

std::vector<motion::Door> doors_around(const wire::WorldDescriptionMessage& description,
                                       const Vec3d& origin) {
    std::vector<motion::Door> doors;
    for (std::uint32_t number = 0; number < description.doors.size(); ++number) {
        const wire::DoorMessage& d = description.doors[number];
        doors.push_back({box_around(*d.box, origin),
                         read_times(d),
                         d.by_rules ? std::optional(number) : std::nullopt});
    }
    return doors;
}

/// Needs a description that passed sensible().
motion::PlatformPath read_path(const wire::PlatformMessage& p, std::uint32_t number) {
    motion::PlatformPath path;
    for (std::size_t i = 0; i < p.ticks.size(); ++i) {
        path.stops.push_back(
            {Vec3(p.offsets[3 * i], p.offsets[3 * i + 1], p.offsets[3 * i + 2]), p.ticks[i]});
    }
    path.back = p.back;
    path.wait = p.wait;
    path.shift = p.shift;
    path.by_rules = p.by_rules ? std::optional(number) : std::nullopt;
    path.start = p.start;
    return path;
}

std::vector<motion::Platform> platforms_around(const wire::WorldDescriptionMessage& description,
                                               const Vec3d& origin) {
    std::vector<motion::Platform> platforms;
    for (std::uint32_t number = 0; number < description.platforms.size(); ++number) {
        const wire::PlatformMessage& p = description.platforms[number];
        platforms.push_back({box_around(*p.box, origin), read_path(p, number)});
    }
    return platforms;
}

/// Largest geometry of one surface that a client accepts, in floats: far above the size that
/// servers send.
constexpr std::size_t kMaxSurfaceNumbers = 1 << 26;

/// Tables to which a surface refers.
struct SurfaceTables {
    std::vector<float> heights;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> corners;
};

/// Null where the server keeps the geometry to itself. Needs a surface that passed wrong_with().
std::shared_ptr<const motion::Surface> read_surface(const wire::StaticSurfaceMessage& s) {
    const auto tables = std::make_shared<SurfaceTables>();
    if (s.heights) {
        const wire::HeightsMessage& h = *s.heights;
        tables->heights.assign(h.height.begin(), h.height.end());
        return std::make_shared<const motion::Surface>(
            motion::HeightGrid{
                h.columns, h.rows, h.spacing_x, h.spacing_z, h.thickness, tables->heights},
            tables);
    }
    if (!s.triangles) {
        return nullptr;
    }
    const wire::TrianglesMessage& t = *s.triangles;
    for (std::size_t v = 0; v + 2 < t.vertex.size(); v += 3) {
        tables->vertices.emplace_back(t.vertex[v], t.vertex[v + 1], t.vertex[v + 2]);
    }
    for (std::size_t c = 0; c + 2 < t.corner.size(); c += 3) {
        tables->corners.push_back({t.corner[c], t.corner[c + 1], t.corner[c + 2]});
    }
    return std::make_shared<const motion::Surface>(
        motion::TriangleList{tables->vertices, tables->corners}, tables);
}

/// Surfaces around each zone's origin, as `boxes_around`; the geometry is shared.
std::vector<motion::StaticSurface> surfaces_around(
    const wire::WorldDescriptionMessage& description,
    const std::vector<std::shared_ptr<const motion::Surface>>& surfaces,
    const Vec3d& origin) {
    std::vector<motion::StaticSurface> out;
    for (std::size_t i = 0; i < description.surfaces.size(); ++i) {
        const wire::StaticSurfaceMessage& s = description.surfaces[i];
        const auto& surface = surfaces[i];
        if (surface == nullptr) {
            continue;
        }
        const Vec3d position(s.position[0], s.position[1], s.position[2]);
        motion::StaticSurface placed;
        placed.surface = surface;
        placed.position = (position - origin).cast<float>();
        if (s.orientation.size() == 4) {
            placed.orientation =
                Quat(s.orientation[0], s.orientation[1], s.orientation[2], s.orientation[3]);
        }
        out.push_back(placed);
    }
    return out;
}

/// Within a million; false for NaN.
template <class Number>
bool sensible_numbers(const std::vector<Number>& numbers) {
    return numbers.size() <= kMaxSurfaceNumbers &&
           std::ranges::all_of(numbers, [](Number n) { return std::abs(n) <= Number{1e6}; });
}

bool sensible(const wire::StaticSurfaceMessage& s) {
    if (s.position.size() != 3 || (s.orientation.size() != 0 && s.orientation.size() != 4) ||
        !sensible_numbers(s.position) || !sensible_numbers(s.orientation) ||
        (s.heights && s.triangles)) {
        return false;
    }
    if (s.heights) {
        const wire::HeightsMessage& h = *s.heights;
        return h.columns >= 2 && h.rows >= 2 &&
               static_cast<std::uint64_t>(h.columns) * h.rows == h.height.size() &&
               h.spacing_x > 1e-4F && h.spacing_x < 1e6F && h.spacing_z > 1e-4F &&
               h.spacing_z < 1e6F && h.thickness >= 0.0F && sensible_numbers(h.height);
    }
    if (!s.triangles) {
        return true;
    }
    const wire::TrianglesMessage& t = *s.triangles;
    const std::size_t vertices = t.vertex.size() / 3;
    return (t.vertex.size() % 3 == 0 && t.corner.size() % 3 == 0 && t.corner.size() > 0 &&
            sensible_numbers(t.vertex) &&
            std::ranges::all_of(t.corner, [&](std::uint32_t c) { return c < vertices; }));
}

bool sensible(const wire::StaticBoxMessage& b) {
    return b.centre.size() == 3 && b.half_extents.size() == 3 &&
           (b.orientation.size() == 0 || b.orientation.size() == 4);
}

/// Longer periods than a thousand years of the fastest ticks are an attack.
constexpr std::int64_t kMaxPeriod = INT64_C(1) << 43;

bool sensible(const wire::DoorMessage& d) {
    if (!d.box || !sensible(*d.box) || d.period < 1 || d.period > kMaxPeriod || d.shift < 0 ||
        d.shift >= d.period || d.open.size() % 2 != 0) {
        return false;
    }
    std::int64_t before = 0;
    for (std::size_t i = 0; i < d.open.size(); ++i) {
        // Spans have ticks in them and do not overlap.
        if (d.open[i] < before || d.open[i] > d.period || (i % 2 == 1 && d.open[i] == before)) {
            return false;
        }
        before = d.open[i];
    }
    return true;
}

/// More stops than servers have are an attack.
constexpr std::size_t kMostStops = 64;

bool sensible(const wire::PlatformMessage& p) {
    const auto in_period = [](std::int64_t ticks) {
        return ticks >= 0 && ticks <= kMaxPeriod;
    };
    const std::size_t stops = p.ticks.size();
    return p.box && sensible(*p.box) && stops >= 2 && stops <= kMostStops &&
           p.offsets.size() == 3 * stops && sensible_numbers(p.offsets) && p.ticks[0] == 0 &&
           p.ticks.back() <= kMaxPeriod &&
           std::adjacent_find(p.ticks.begin(), p.ticks.end(), std::greater_equal<>()) ==
               p.ticks.end() &&
           in_period(p.back) && in_period(p.wait) && in_period(p.shift) && p.start >= 0 &&
           p.start <= p.ticks.back() && !(p.by_rules && p.back > 0);
}

/// More clocks, variables or phases than servers have are an attack.
constexpr std::size_t kMaxSharedVariables = 64;

bool sensible(const wire::SharedVariableMessage& v) {
    const auto finite = [](double x) {
        return std::isfinite(x) && std::abs(x) < 1e12;
    };
    return !v.phases.empty() && v.phases.size() <= kMaxSharedVariables && v.blend_s >= 0.0 &&
           v.blend_s < 1e6 && std::ranges::all_of(v.phases, [&](const auto& p) {
               return finite(p.value) && p.weight > 0.0 && p.weight < 1e9 && p.min_s >= 0.0 &&
                      p.max_s >= p.min_s && p.max_s < 1e9;
           });
}

std::string wrong_with_environment(const wire::WorldDescriptionMessage& d) {
    if (d.shared_clocks.size() > kMaxSharedVariables ||
        d.shared_variables.size() > kMaxSharedVariables) {
        return "too many shared clocks or shared variables";
    }
    for (const wire::SharedClockMessage& clock : d.shared_clocks) {
        if (!(clock.period >= 0.0 && clock.period < 1e12)) {
            return "malformed shared clock";
        }
    }
    const auto& variables = d.shared_variables;
    return std::ranges::all_of(variables, [](const auto& v) { return sensible(v); })
               ? ""
               : "malformed shared variable";
}

std::string clean_name(const std::string& name) {
    return core::is_clean_utf8(name) ? name : "?";
}

/// Needs a description that passed wrong_with_environment().
clock::EnvironmentDefs read_environment(const wire::WorldDescriptionMessage& d) {
    clock::EnvironmentDefs out;
    for (const wire::SharedClockMessage& clock : d.shared_clocks) {
        out.clocks.push_back({clean_name(clock.name), clock.period, {}});
    }
    for (const wire::SharedVariableMessage& v : d.shared_variables) {
        clock::SharedVariableDef& def = out.variables.emplace_back();
        def.name = clean_name(v.name);
        def.seed = v.seed;
        def.blend_s = v.blend_s;
        for (const auto& p : v.phases) {
            def.phases.push_back({clean_name(p.name), p.value, p.weight, p.min_s, p.max_s});
        }
    }
    return out;
}

/// Empty: all types can be read. `out` stays empty where no type declares a field.
std::string read_declared_fields(const wire::WorldDescriptionMessage& d, wire::FieldSchemas& out) {
    for (std::size_t t = 0; t < d.types.size(); ++t) {
        if (d.types[t].declared.empty()) {
            continue;
        }
        std::vector<wire::DeclaredField> fields;
        for (const wire::DeclaredFieldMessage& from : d.types[t].declared) {
            wire::DeclaredField& field = fields.emplace_back();
            if (from.kind < 0 || from.kind >= static_cast<int>(wire::kDeclaredKinds) ||
                from.initial.size() > wire::kTextWords) {
                return "a declared field of an unknown kind";
            }
            field.name = from.name;
            field.kind = static_cast<wire::DeclaredKind>(from.kind);
            field.minimum = from.minimum;
            field.quantum = from.quantum;
            field.most = from.steps;
            field.values = from.values;
            field.interval = from.interval_ticks;
            std::copy(from.initial.begin(), from.initial.end(), field.initial.begin());
        }
        auto schema = wire::FieldSchema::make(std::move(fields));
        if (!schema) {
            return schema.error();
        }
        out.resize(d.types.size());
        out[t] = std::move(*schema);
    }
    return {};
}

/// False: not such a lattice, or the type has no fields for it.
bool read_deformation(const wire::DeformationMessage& d,
                      const wire::FieldSchema* schema,
                      TypeInfo& out) {
    if (schema == nullptr || d.points.size() != 3 || d.lower.size() != 3 || d.upper.size() != 3) {
        return false;
    }
    wire::DeformationLattice lattice;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (d.points[axis] < 1 || d.points[axis] > wire::kMostDeclared ||
            !(d.lower[axis] <= d.upper[axis]) || !(std::abs(d.lower[axis]) < 1e6F) ||
            !(std::abs(d.upper[axis]) < 1e6F)) {
            return false;
        }
        lattice.points[axis] = d.points[axis];
        lattice.lower[static_cast<Eigen::Index>(axis)] = d.lower[axis];
        lattice.upper[static_cast<Eigen::Index>(axis)] = d.upper[axis];
    }
    lattice.quantum_m = d.quantum_m;
    lattice.bound_m = d.bound_m;
    const std::span<const wire::DeclaredField> fields = schema->fields();
    if (!(d.quantum_m > 0.0F && d.quantum_m < 1e6F) || !(d.bound_m > 0.0F && d.bound_m < 1e6F) ||
        d.first_field > fields.size() || lattice.size() > fields.size() - d.first_field) {
        return false;
    }
    out.deformation = lattice;
    out.first_control_point = d.first_field;
    return std::ranges::all_of(
        fields.subspan(d.first_field, lattice.size()), [](const wire::DeclaredField& field) {
            return field.kind == wire::DeclaredKind::kNumber && field.most == wire::kMostFieldSteps;
        });
}

std::string wrong_with(const wire::WorldDescriptionMessage& d) {
    if (!(d.tick_rate_hz >= 1.0 && d.tick_rate_hz <= 1000.0)) {
        return "tick rate outside 1..1000 Hz";
    }
    if (d.lods.empty() || d.lods.size() > std::size_t{wire::kLods}) {
        return "not 1..4 levels of detail";
    }
    if (d.zones.empty() || d.types.empty() || d.types.size() > 65535) {
        return "no zones or no entity types";
    }
    for (const wire::ZoneMessage& z : d.zones) {
        if (z.origin.size() != 3 || z.lower.size() != 2 || z.upper.size() != 2 || z.id == 0 ||
            z.id > 65535) {
            return "malformed zone";
        }
    }
    for (const wire::StaticBoxMessage& b : d.boxes) {
        if (!sensible(b)) {
            return "malformed static box";
        }
    }
    for (const wire::DoorMessage& door : d.doors) {
        if (!sensible(door)) {
            return "malformed door";
        }
    }
    for (const wire::PlatformMessage& platform : d.platforms) {
        if (!sensible(platform)) {
            return "malformed platform";
        }
    }
    for (const wire::StaticSurfaceMessage& s : d.surfaces) {
        if (!sensible(s)) {
            return "malformed static surface";
        }
    }
    if (std::string wrong = wrong_with_environment(d); !wrong.empty()) {
        return wrong;
    }
    return wrong_with_cosmetics(d);
}

}  // namespace

bool WorldInfo::has_moved_parts() const {
    return std::ranges::any_of(doors, [](const auto& door) { return door.by_rules; }) ||
           std::ranges::any_of(platforms, [](const PlatformInfo& platform) {
               return platform.path.by_rules.has_value();
           });
}

WorldInfo WorldInfo::with_courses(
    const std::shared_ptr<const motion::DoorCourses>& door_courses,
    const std::shared_ptr<const motion::PlatformCourses>& platform_courses) const {
    WorldInfo out = *this;
    for (ZoneInfo& zone : out.zones) {
        zone.geometry = zone.geometry.with_courses(door_courses, platform_courses);
    }
    return out;
}

const ZoneInfo* WorldInfo::zone(ZoneId id) const {
    for (const ZoneInfo& zone : zones) {
        if (zone.id == id) {
            return &zone;
        }
    }
    return nullptr;
}

const ZoneInfo* WorldInfo::zone_at(double x, double z) const {
    for (const ZoneInfo& zone : zones) {
        if (x >= zone.lower_x && x < zone.upper_x && z >= zone.lower_z && z < zone.upper_z) {
            return &zone;
        }
    }
    return nullptr;
}

core::Result<WorldInfo> read_world(const wire::WorldDescriptionMessage& d) {
    if (std::string wrong = wrong_with(d); !wrong.empty()) {
        return Failure::failure(std::move(wrong));
    }
    WorldInfo world;
    world.tick_s = 1.0 / d.tick_rate_hz;
    world.interest_hysteresis = d.interest_hysteresis;
    world.quantization = read_quantization(d.quantization.value_or(wire::QuantizationMessage{}));
    if (!sensible(world.quantization)) {
        return Failure::failure("quantisation steps out of range");
    }
    for (const wire::EntityTypeMessage& t : d.types) {
        world.types.push_back(read_type(t));
    }
    if (std::string wrong = read_declared_fields(d, world.fields); !wrong.empty()) {
        return Failure::failure(std::move(wrong));
    }
    for (std::size_t t = 0; t < d.types.size(); ++t) {
        const wire::FieldSchema* schema = wire::schema_of(world.fields, static_cast<TypeIndex>(t));
        if (d.types[t].deformation &&
            !read_deformation(*d.types[t].deformation, schema, world.types[t])) {
            return Failure::failure("malformed deformation of an entity type");
        }
    }
    for (const wire::LodMessage& l : d.lods) {
        world.lods.push_back({l.radius_m, l.position_bound_m, l.orientation_bound_rad});
    }
    std::vector<std::shared_ptr<const motion::Surface>> surfaces;
    for (const wire::StaticSurfaceMessage& s : d.surfaces) {
        surfaces.push_back(read_surface(s));
    }
    for (const wire::ZoneMessage& z : d.zones) {
        ZoneInfo zone;
        zone.id = ZoneId(static_cast<std::uint16_t>(z.id));
        zone.origin = Vec3d(z.origin[0], z.origin[1], z.origin[2]);
        zone.lower_x = z.lower[0];
        zone.lower_z = z.lower[1];
        zone.upper_x = z.upper[0];
        zone.upper_z = z.upper[1];
        // The ground plane is given in world coordinates as well.
        zone.geometry = motion::StaticGeometry(
            boxes_around(d, zone.origin),
            static_cast<float>(static_cast<double>(d.ground_height_m) - zone.origin.y()),
            motion::kStaticCell_m,
            surfaces_around(d, surfaces, zone.origin),
            doors_around(d, zone.origin),
            platforms_around(d, zone.origin));
        world.zones.push_back(std::move(zone));
    }
    for (const wire::DoorMessage& door : d.doors) {
        world.doors.push_back({clean_name(door.name), read_times(door), door.by_rules});
    }
    for (std::uint32_t p = 0; p < d.platforms.size(); ++p) {
        world.platforms.push_back({clean_name(d.platforms[p].name), read_path(d.platforms[p], p)});
    }
    world.cosmetics = read_cosmetics(d);
    world.environment = read_environment(d);
    return world;
}

std::shared_ptr<const WorldInfo> WorldCache::get(const std::string& digest,
                                                 const wire::WorldDescriptionMessage& description,
                                                 std::string& error) {
    const auto found = worlds_.find(digest);
    if (found != worlds_.end()) {
        return found->second;
    }
    auto world = read_world(description);
    if (!world) {
        error = world.error();
        return nullptr;
    }
    auto shared = std::make_shared<const WorldInfo>(std::move(*world));
    worlds_[digest] = shared;
    return shared;
}

}  // namespace zoned::view
