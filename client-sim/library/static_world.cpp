#include "client-sim/library/static_world.h"

namespace zoned::library {

namespace {

zoned_client_box box_info(const motion::StaticBox& box, const Vec3d& origin) {
    zoned_client_box out{};
    give_vector(out.centre, Vec3d(origin + box.centre.cast<double>()));
    give_vector(out.half_extents, box.half_extents);
    give_quaternion(out.orientation, box.orientation);
    out.shut = 1;
    return out;
}

/// Calls visit(corners in world coordinates) for each triangle of the zone's surfaces.
template <class Visit>
void for_each_triangle(const view::ZoneInfo& zone, Visit&& visit) {
    for (const motion::PlacedSurface& placed : zone.geometry.surfaces()) {
        placed.surface().for_each_near(placed.surface().box(), [&](const FacedTriangle& triangle) {
            std::array<Vec3d, 3> corners;
            for (std::size_t i = 0; i < 3; ++i) {
                corners[i] =
                    zone.origin + placed.to_world(triangle.corner[i]).template cast<double>();
            }
            visit(corners);
        });
    }
}

}  // namespace

zoned_client_zone_info zone_info(const view::ZoneInfo& zone) {
    zoned_client_zone_info out{};
    out.id = zone.id.value;
    out.lower[0] = zone.lower_x;
    out.lower[1] = zone.lower_z;
    out.upper[0] = zone.upper_x;
    out.upper[1] = zone.upper_z;
    out.ground_height = zone.origin.y() + static_cast<double>(zone.geometry.ground_height());
    out.boxes =
        static_cast<std::uint32_t>(zone.geometry.boxes().size() + zone.geometry.doors().size() +
                                   zone.geometry.platforms().size());
    out.triangles = static_cast<std::uint32_t>(copy_triangles(zone, nullptr, 0));
    return out;
}

void add_boxes(const view::ZoneInfo& zone,
               Tick tick,
               Tick own_tick,
               SizedArray<zoned_client_box>& out) {
    for (const motion::StaticBox& box : zone.geometry.boxes()) {
        out.add(box_info(box, zone.origin));
    }
    for (std::uint32_t door = 0; door < zone.geometry.doors().size(); ++door) {
        zoned_client_box info = box_info(zone.geometry.doors()[door].box, zone.origin);
        info.door = 1;
        info.shut = zone.geometry.shut_at(door, tick) ? 1 : 0;
        out.add(info);
    }
    for (std::uint32_t platform = 0; platform < zone.geometry.platforms().size(); ++platform) {
        zoned_client_box info =
            box_info(zone.geometry.platform_box(platform, own_tick), zone.origin);
        info.platform = 1;
        out.add(info);
    }
}

std::size_t copy_triangles(const view::ZoneInfo& zone, double* out, std::size_t capacity) {
    std::size_t count = 0;
    for_each_triangle(zone, [&](const std::array<Vec3d, 3>& corners) {
        if (count < capacity) {
            for (std::size_t i = 0; i < 9; ++i) {
                out[9 * count + i] = corners[i / 3][static_cast<int>(i % 3)];
            }
        }
        ++count;
    });
    return count;
}

}  // namespace zoned::library
