#include "server/ai/pathfinding/grid/door_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

bool meet(const Aabb& a, const Aabb& b) {
    return a.lower.x() <= b.upper.x() && b.lower.x() <= a.upper.x() && a.lower.z() <= b.upper.z() &&
           b.lower.z() <= a.upper.z();
}

/// The cells that differ near a door.
DoorCells differences(const GroundMap& open, const GroundMap& shut, const Aabb& near) {
    DoorCells out;
    const GroundGrid& g = open.grid;
    const float right = g.min_x() + static_cast<float>(g.width()) * g.cell_m();
    const float below = g.min_z() + static_cast<float>(g.height()) * g.cell_m();
    if (near.lower.x() > right || near.lower.z() > below || near.upper.x() < g.min_x() ||
        near.upper.z() < g.min_z()) {
        return out;
    }
    const Cell first = g.cell({near.lower.x(), near.lower.z()});
    const Cell last = g.cell({near.upper.x(), near.upper.z()});
    for (std::uint16_t y = first.y; y <= last.y; ++y) {
        for (std::uint16_t x = first.x; x <= last.x; ++x) {
            const Cell c{x, y};
            if (open.cells.passable(c) && !shut.cells.passable(c)) {
                out.taken.push_back(c);
            } else if (!open.cells.passable(c) && shut.cells.passable(c)) {
                out.given.push_back(c);
            }
        }
    }
    return out;
}

}  // namespace

float door_reach(const motion::CharacterLimits& limits, float cell_m) {
    // A step from the next cell but one may touch it (as Bakery::mark_near has it). The higher of
    // two cells is blocked where that step cannot be made.
    return limits.radius + 2.5F * cell_m + limits.step_up + limits.step_down;
}

Aabb grown_door(const motion::StaticGeometry& world, std::uint32_t door, float reach) {
    const auto box = static_cast<std::uint32_t>(world.boxes().size()) + door;
    return world.box_bounds(box).grown(reach);
}

std::vector<std::vector<std::uint32_t>> doors_apart(const motion::StaticGeometry& world,
                                                    float reach) {
    std::vector<std::vector<std::uint32_t>> groups;
    for (std::uint32_t door = 0; door < world.doors().size(); ++door) {
        const Aabb mine = grown_door(world, door, reach);
        const auto room =
            std::find_if(groups.begin(), groups.end(), [&](const std::vector<std::uint32_t>& g) {
                return std::none_of(g.begin(), g.end(), [&](std::uint32_t other) {
                    return meet(mine, grown_door(world, other, reach));
                });
            });
        (room == groups.end() ? groups.emplace_back() : *room).push_back(door);
    }
    return groups;
}

std::vector<DoorCells> bake_doors(const motion::StaticGeometry& world,
                                  const motion::CharacterLimits& limits,
                                  const GroundRect& area,
                                  float cell_m,
                                  const GroundMap& open) {
    const float reach = door_reach(limits, cell_m);
    std::vector<DoorCells> out(world.doors().size());
    for (const std::vector<std::uint32_t>& group : doors_apart(world, reach)) {
        const GroundMap shut = bake_ground(world.with_shut(group), limits, area, cell_m);
        for (const std::uint32_t door : group) {
            out[door] = differences(open, shut, grown_door(world, door, reach));
        }
    }
    return out;
}

DoorMap::DoorMap(std::vector<DoorCells> doors, const GridMap& open)
    : doors_(doors.size()),
      shut_(doors.size(), false) {
    std::vector<std::pair<Place, std::uint32_t>> known;
    for (const DoorCells& door : doors) {
        for (const std::vector<Cell>* cells : {&door.taken, &door.given}) {
            for (const Cell c : *cells) {
                known.emplace_back(open.place(c), 0);
            }
        }
    }
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    for (auto& [place, number] : known) {
        number = static_cast<std::uint32_t>(ground_.size());
        ground_.push_back({open.cell(place), open.passable(place), 0, 0});
    }
    const auto number_of = [&](Cell c) {
        return std::lower_bound(known.begin(), known.end(), std::pair(open.place(c), 0U))->second;
    };
    for (std::size_t d = 0; d < doors.size(); ++d) {
        std::transform(doors[d].taken.begin(),
                       doors[d].taken.end(),
                       std::back_inserter(doors_[d].taken),
                       number_of);
        std::transform(doors[d].given.begin(),
                       doors[d].given.end(),
                       std::back_inserter(doors_[d].given),
                       number_of);
    }
}

void DoorMap::open_all(GridMap& map) const {
    for (const Ground& g : ground_) {
        map.set_passable(g.cell, true);
    }
}

void DoorMap::turn(std::uint32_t door, bool shut, std::vector<CellChange>& changes) {
    if (shut_[door] == shut) {
        return;
    }
    shut_[door] = shut;
    const auto change = [&](std::uint32_t number, std::uint16_t Ground::* doors) {
        Ground& g = ground_[number];
        const bool before = g.passable();
        g.*doors = static_cast<std::uint16_t>(g.*doors + (shut ? 1 : -1));
        if (g.passable() != before) {
            changes.push_back({g.cell, g.passable()});
        }
    };
    for (const std::uint32_t number : doors_[door].taken) {
        change(number, &Ground::takers);
    }
    for (const std::uint32_t number : doors_[door].given) {
        change(number, &Ground::givers);
    }
}

std::size_t DoorMap::bytes() const {
    std::size_t bytes = ground_.capacity() * sizeof(Ground) + doors_.capacity() * sizeof(Turned) +
                        shut_.capacity() / 8;
    for (const Turned& door : doors_) {
        bytes += (door.taken.capacity() + door.given.capacity()) * sizeof(std::uint32_t);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
