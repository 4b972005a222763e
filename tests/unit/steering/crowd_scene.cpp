#include "tests/unit/steering/crowd_scene.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::steering {

namespace {

constexpr float kWalk = 1.3F;  ///< m/s

double distance_to(const Wall& w, double x, double z) {
    const double ex = static_cast<double>(w.bx) - static_cast<double>(w.ax);
    const double ez = static_cast<double>(w.bz) - static_cast<double>(w.az);
    const double px = x - static_cast<double>(w.ax);
    const double pz = z - static_cast<double>(w.az);
    const double l2 = ex * ex + ez * ez;
    const double t = l2 > 0.0 ? std::clamp((px * ex + pz * ez) / l2, 0.0, 1.0) : 0.0;
    return std::hypot(px - t * ex, pz - t * ez);
}

double side_of(const Wall& w, double x, double z) {
    return (static_cast<double>(w.bx) - static_cast<double>(w.ax)) *
               (z - static_cast<double>(w.az)) -
           (static_cast<double>(w.bz) - static_cast<double>(w.az)) *
               (x - static_cast<double>(w.ax));
}

bool free_place(const CrowdScene& scene, float x, float z, float radius) {
    for (std::size_t i = 0; i < scene.agents.size(); ++i) {
        if (std::hypot(scene.agents.x[i] - x, scene.agents.z[i] - z) <
            scene.agents.radius[i] + radius + 1e-4F) {
            return false;
        }
    }
    return std::none_of(scene.walls.begin(), scene.walls.end(), [&](const Wall& w) {
        return distance_to(w, static_cast<double>(x), static_cast<double>(z)) <
               static_cast<double>(radius) + 1e-4;
    });
}

/// Puts agents into a rectangle where they find room, `count` at most.
void fill(CrowdScene& scene,
          core::Rng& rng,
          std::size_t count,
          const Wall& box,
          float least_radius,
          float most_radius) {
    const std::size_t before = scene.agents.size();
    for (std::size_t tries = 0; tries < 40 * count && scene.agents.size() < before + count;
         ++tries) {
        const float x = rng.range(box.ax, box.bx);
        const float z = rng.range(box.az, box.bz);
        const float radius = rng.range(least_radius, most_radius);
        if (free_place(scene, x, z, radius)) {
            scene.agents.add(
                static_cast<std::uint32_t>(scene.agents.size()), x, z, radius, 1.5F * kWalk);
        }
    }
}

}  // namespace

CrowdScene random_scene(core::Rng& rng, std::size_t count, float side) {
    CrowdScene scene;
    scene.walls = {{0, 0, side, 0}, {side, 0, side, side}, {side, side, 0, side}, {0, side, 0, 0}};
    for (std::size_t i = 0; i < count / 10; ++i) {
        const float x = rng.range(0.0F, side);
        const float z = rng.range(0.0F, side);
        const float bx = x + rng.range(-3.0F, 3.0F);
        const float bz = z + rng.range(-3.0F, 3.0F);
        scene.walls.push_back({x, z, bx, bz});
        if (i % 3 == 0) {
            const float cx = x + rng.range(-2.0F, 2.0F);
            const float cz = z + rng.range(-2.0F, 2.0F);
            scene.walls.push_back({bx, bz, cx, cz});
            scene.walls.push_back({cx, cz, x, z});
        }
    }
    fill(scene, rng, count, {0, 0, side, side}, 0.15F, 0.4F);
    return scene;
}

float largest_overlap_share(const CrowdAgents& agents) {
    double worst = 0.0;
    for (std::size_t i = 0; i < agents.size(); ++i) {
        for (std::size_t j = i + 1; j < agents.size(); ++j) {
            const double dx = static_cast<double>(agents.x[i]) - static_cast<double>(agents.x[j]);
            const double dz = static_cast<double>(agents.z[i]) - static_cast<double>(agents.z[j]);
            const double both =
                static_cast<double>(agents.radius[i]) + static_cast<double>(agents.radius[j]);
            if (dx * dx + dz * dz < both * both) {
                const double least =
                    static_cast<double>(std::min(agents.radius[i], agents.radius[j]));
                worst = std::max(worst, (both - std::hypot(dx, dz)) / least);
            }
        }
    }
    return static_cast<float>(worst);
}

float deepest_in_wall_share(const CrowdScene& scene) {
    double worst = 0.0;
    for (std::size_t i = 0; i < scene.agents.size(); ++i) {
        const auto radius = static_cast<double>(scene.agents.radius[i]);
        for (const Wall& w : scene.walls) {
            const double d = distance_to(
                w, static_cast<double>(scene.agents.x[i]), static_cast<double>(scene.agents.z[i]));
            worst = std::max(worst, (radius - d) / radius);
        }
    }
    return static_cast<float>(worst);
}

std::size_t crossings(const CrowdAgents& before,
                      const CrowdAgents& after,
                      const std::vector<Wall>& walls) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        const Wall step{before.x[i], before.z[i], after.x[i], after.z[i]};
        for (const Wall& w : walls) {
            const bool parted =
                side_of(w, static_cast<double>(step.ax), static_cast<double>(step.az)) *
                    side_of(w, static_cast<double>(step.bx), static_cast<double>(step.bz)) <
                0.0;
            const bool met =
                side_of(step, static_cast<double>(w.ax), static_cast<double>(w.az)) *
                    side_of(step, static_cast<double>(w.bx), static_cast<double>(w.bz)) <
                0.0;
            count += parted && met ? 1U : 0U;
        }
    }
    return count;
}

int WalkingScene::run(int most) {
    OrcaAvoidance avoidance({});
    compute::Team alone;
    const Walls walls = Walls::make(scene.walls, 3.0F).value();
    for (int step = 0; step < most; ++step) {
        for (std::size_t i = scene.agents.size(); i-- > 0;) {
            if (!aim(i)) {
                scene.agents.remove(i);
            }
        }
        if (scene.agents.size() == 0) {
            return step;
        }
        const CrowdAgents before = scene.agents;
        avoidance.step(scene.agents, walls, static_cast<std::uint64_t>(step), alone);
        worst_overlap = std::max(worst_overlap, largest_overlap_share(scene.agents));
        crossed_walls += crossings(before, scene.agents, scene.walls);
    }
    return most;
}

CorridorScene::CorridorScene(std::size_t count, float length, float width, std::uint64_t seed)
    : length_(length) {
    core::Rng rng(seed);
    scene.walls = {{-20.0F, 0.0F, length + 20.0F, 0.0F}, {-20.0F, width, length + 20.0F, width}};
    fill(scene, rng, count / 2, {-15.0F, 0.0F, length / 4, width}, 0.25F, 0.25F);
    fill(scene, rng, count / 2, {length * 3 / 4, 0.0F, length + 15.0F, width}, 0.25F, 0.25F);
    for (std::size_t i = 0; i < scene.agents.size(); ++i) {
        // The goal's side is kept in the sign of the desired velocity.
        scene.agents.want_x[i] = scene.agents.x[i] < length / 2 ? kWalk : -kWalk;
    }
}

bool CorridorScene::aim(std::size_t i) {
    return scene.agents.want_x[i] > 0.0F ? scene.agents.x[i] < length_ : scene.agents.x[i] > 0.0F;
}

DoorScene::DoorScene(std::size_t count, float width, std::uint64_t seed) : width_(width) {
    core::Rng rng(seed);
    scene.walls = {{0.0F, -30.0F, 0.0F, -width / 2}, {0.0F, width / 2, 0.0F, 30.0F}};
    fill(scene, rng, count, {-12.0F, -6.0F, -1.0F, 6.0F}, 0.25F, 0.25F);
}

bool DoorScene::aim(std::size_t i) {
    CrowdAgents& a = scene.agents;
    if (a.x[i] > 3.0F) {
        return false;
    }
    // To the part of the door in which there is room for oneself, then on.
    const float room = width_ / 2 - a.radius[i];
    const float to_x = a.x[i] > -0.2F ? 5.0F : 0.2F;
    const float to_z = std::clamp(a.z[i], -room, room);
    const float dx = to_x - a.x[i];
    const float dz = to_z - a.z[i];
    const float d = std::hypot(dx, dz);
    a.want_x[i] = kWalk * dx / d;
    a.want_z[i] = kWalk * dz / d;
    a.path_left[i] = d + (a.x[i] > -0.2F ? 0.0F : 5.0F);
    return true;
}

}  // namespace zoned::ai::steering
