// Pictures of crowds, of paths that avoid them and of scents, for reports.
#include "server/ai/crowd/orca_avoidance.h"
#include "server/ai/pathfinding/flow_fields/crowd_flow_field.h"
#include "server/ai/pathfinding/flow_fields/density.h"
#include "tests/bench/picture.h"
#include "tests/bench/suite_crowd.h"
#include "tests/scenario/ant_colony.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::CrowdFlowField;
using ai::pathfinding::Density;
using ai::pathfinding::GridMap;
using ai::pathfinding::Place;
using ai::steering::CrowdAgents;
using ai::steering::OrcaAvoidance;
using ai::steering::Wall;
using ai::steering::Walls;

void draw_agents(Picture& picture, const CrowdAgents& a) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto x = static_cast<double>(a.x[i]);
        const auto z = static_cast<double>(a.z[i]);
        const auto vx = static_cast<double>(a.vx[i]);
        const auto vz = static_cast<double>(a.vz[i]);
        const std::string colour = std::hypot(vx, vz) > 0.05 ? colour_of_direction(vx, vz) : "gray";
        picture.disc(x, z, static_cast<double>(a.radius[i]), colour);
        picture.line(x, z, x + 0.4 * vx, z + 0.4 * vz, 0.06, "black");
    }
}

void draw_walls(Picture& picture, std::span<const Wall> walls) {
    for (const Wall& w : walls) {
        picture.line(static_cast<double>(w.ax),
                     static_cast<double>(w.az),
                     static_cast<double>(w.bx),
                     static_cast<double>(w.bz),
                     0.15,
                     "black");
    }
}

/// Two crowds through each other in a corridor of 6 m.
std::string corridor_picture() {
    const Wall sides[] = {{-5.0F, 0.0F, 45.0F, 0.0F}, {-5.0F, 6.0F, 45.0F, 6.0F}};
    const Walls walls = Walls::make(sides, 3.0F).value();
    CrowdAgents agents;
    for (std::uint32_t i = 0; i < 120; ++i) {
        const bool rightwards = i % 2 == 0;
        const float x = 0.9F * static_cast<float>(i / 12);
        const float z = 0.5F + static_cast<float>(i / 2 % 6);
        agents.add(i, rightwards ? x + 4.0F : 36.0F - x, z, 0.25F, 2.0F);
        agents.want_x.back() = rightwards ? 1.3F : -1.3F;
    }
    OrcaAvoidance avoidance({});
    compute::Team alone;
    for (std::uint64_t tick = 0; tick < 220; ++tick) {
        avoidance.step(agents, walls, tick, alone);
    }
    Picture picture(0.0, -0.5, 40.0, 7.0);
    draw_agents(picture, agents);
    draw_walls(picture, sides);
    return picture.svg();
}

/// A crowd at one of two doors, the density, and the paths that avoid it.
class DoorsScene {
  public:
    DoorsScene() : map_(25, 20) {
        for (std::uint16_t y = 0; y < 20; ++y) {
            for (std::uint16_t x = 0; x < 25; ++x) {
                map_.set_passable({x, y}, x != 12 || y == 4 || y == 16);
            }
        }
        for (const float x : {12.0F, 13.0F}) {
            sides_.push_back({x, 0, x, 4});
            sides_.push_back({x, 5, x, 16});
            sides_.push_back({x, 17, x, 20});
        }
        for (const float z : {4.0F, 5.0F, 16.0F, 17.0F}) {
            sides_.push_back({12, z, 13, z});
        }
        for (std::uint32_t i = 0; i < 120; ++i) {
            agents_.add(i,
                        2.0F + 0.75F * static_cast<float>(i % 12),
                        1.0F + 0.75F * static_cast<float>(i / 12),
                        0.2F,
                        2.0F);
        }
    }

    std::string picture() {
        const Walls walls = Walls::make(sides_, 3.0F).value();
        Density density(map_, {});
        CrowdFlowField field;
        field.build(map_, density.crowding(), {24, 4});
        OrcaAvoidance avoidance({});
        compute::Team alone;
        for (int step = 0; step < 350; ++step) {
            if (step % 10 == 0) {
                density.look(agents_);
                field.update(map_, density.crowding(), density.changed());
            }
            for (std::size_t i = agents_.size(); i-- > 0;) {
                aim(density, field, i);
            }
            avoidance.step(agents_, walls, static_cast<std::uint64_t>(step), alone);
        }
        Picture picture(0.0, 0.0, 25.0, 20.0);
        draw_field(picture, density, field);
        draw_agents(picture, agents_);
        draw_walls(picture, sides_);
        return picture.svg();
    }

  private:
    void aim(const Density& density, const CrowdFlowField& field, std::size_t i) {
        const Place p = density.place_of(agents_.x[i], agents_.z[i]);
        if (p == ai::pathfinding::kNoPlace || agents_.x[i] > 22.0F) {
            agents_.remove(i);
            return;
        }
        const Cell next = ai::pathfinding::hopped(map_.cell(p), field.hop(p));
        const float dx = static_cast<float>(next.x) + 0.5F - agents_.x[i];
        const float dz = static_cast<float>(next.y) + 0.5F - agents_.z[i];
        const float d = std::max(1e-3F, std::hypot(dx, dz));
        agents_.want_x[i] = 1.3F * dx / d;
        agents_.want_z[i] = 1.3F * dz / d;
        agents_.path_left[i] = static_cast<float>(field.cost(p)) / 31520.0F;
    }

    void draw_field(Picture& picture, const Density& density, const CrowdFlowField& field) const {
        for (Place p = 0; p < map_.places(); ++p) {
            if (!map_.passable(p)) {
                continue;
            }
            const Cell c = map_.cell(p);
            const Cell to = ai::pathfinding::hopped(c, field.hop(p));
            const double x = c.x;
            const double z = c.y;
            picture.box(x, z, 1.0, 1.0, shade(static_cast<double>(density.of(p)) / 4.5, 30));
            picture.arrow(x + 0.5 - 0.3 * (to.x - x),
                          z + 0.5 - 0.3 * (to.y - z),
                          x + 0.5 + 0.3 * (to.x - x),
                          z + 0.5 + 0.3 * (to.y - z),
                          0.04,
                          "silver");
        }
    }

    GridMap map_;
    std::vector<Wall> sides_;
    CrowdAgents agents_;
};

/// Walkers that forage around obstacles, and the scents that they have left.
std::string scent_picture() {
    constexpr std::uint16_t kSide = 60;
    GridMap map(kSide, kSide);
    for (std::uint16_t y = 0; y < kSide; ++y) {
        for (std::uint16_t x = 0; x < kSide; ++x) {
            const bool wall = (x == 20 && y < 44) || (x == 40 && y > 12);
            map.set_passable({x, y}, !wall);
        }
    }
    scenario::AntColony colony(map, {6, 30}, {});
    colony.set_food({54, 30}, true);
    colony.add_walkers(300);
    for (int tick = 0; tick < 6000; ++tick) {
        colony.step();
    }
    Picture picture(0.0, 0.0, kSide, kSide);
    for (Place p = 0; p < map.places(); ++p) {
        const Cell c = map.cell(p);
        if (!map.contains(c)) {
            continue;
        }
        using scenario::AntColony;
        const double food = static_cast<double>(colony.scent(AntColony::kFood, p));
        const double home = static_cast<double>(colony.scent(AntColony::kHome, p));
        const std::string colour = !map.passable(p) ? "black"
                                   : food > home    ? shade(food, 120)
                                                    : shade(home, 210);
        picture.box(c.x, c.y, 1.0, 1.0, colour);
    }
    for (std::size_t i = 0; i < colony.walkers(); ++i) {
        const Cell c = map.cell(colony.walker_at(i));
        picture.disc(c.x + 0.5, c.y + 0.5, 0.3, colony.carries(i) ? "darkgreen" : "black");
    }
    picture.disc(6.5, 30.5, 1.0, "blue");
    picture.disc(54.5, 30.5, 1.0, "red");
    return picture.svg();
}

}  // namespace

void draw_crowds(Session& session) {
    session.progress("crowd pictures");
    auto& pictures = session.results.pictures;
    pictures.push_back({"crowd_corridor",
                        "Two crowds through each other after 11 s: colours are directions",
                        corridor_picture()});
    pictures.push_back({"crowd_doors",
                        "A crowd that spreads over two doors after 17.5 s: density, and the paths "
                        "that avoid it",
                        DoorsScene().picture()});
    pictures.push_back({"ants_scents",
                        "Walkers from home (blue) to food (red) after 6,000 ticks: the scents of "
                        "home (blue) and food (green)",
                        scent_picture()});
}

}  // namespace zoned::bench
