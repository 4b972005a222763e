// Machine text: a cart, a ragdoll, a rope bridge and a crane as text of a config, for tests.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

namespace zoned::scenario {

/// World, zones side by side along x, and a player. Two zones share 120 m; one has its origin where
/// the left one of the two has it, so that coordinates round alike in both worlds.
inline std::string machine_world(int zones) {
    return "world { name: \"machines\" seed: 3 min_z_m: -30 max_z_m: 30 tick_rate_hz: 60 "
           "min_x_m: " +
           std::string(zones == 1 ? "-90 max_x_m: 30" : "-60 max_x_m: 60") + R"( }
zones { zone_grid { columns: )" +
           std::to_string(zones) + R"( rows: 1 } ghost_margin_m: 55 handoff_hysteresis_m: 1 }
session { dev_mode_loopback: true }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: 80
  aura_m { normal: 40 } nimbus_m { normal: 40 } character { } }
type { name: "crate" box { x_m: 0.6 y_m: 0.6 z_m: 0.6 } mass_kg: 20 aura_m { normal: 40 } }
spawn { x_m: -50 z_m: 20 }
lod { position_bound_m: 0.05 }
)";
}

/// Drives along +x where it is placed with a yaw of 90 degrees.
inline const std::string kCartText = R"(type {
  name: "cart" friction: 1 aura_m { normal: 40 }
  assembly {
    part { name: "chassis" box { x_m: 1.4 y_m: 0.4 z_m: 2.4 } y_m: 0.6 mass_kg: 120 }
    part { name: "fl" sphere { radius_m: 0.35 } x_m: 0.95 y_m: 0.35 z_m: 0.9 mass_kg: 12 }
    part { name: "fr" sphere { radius_m: 0.35 } x_m: -0.95 y_m: 0.35 z_m: 0.9 mass_kg: 12 }
    part { name: "rl" sphere { radius_m: 0.35 } x_m: 0.95 y_m: 0.35 z_m: -0.9 mass_kg: 12 }
    part { name: "rr" sphere { radius_m: 0.35 } x_m: -0.95 y_m: 0.35 z_m: -0.9 mass_kg: 12 }
    joint { name: "axle_fl" a: "chassis" b: "fl" hinge { axis { x: 1 } } }
    joint { name: "axle_fr" a: "chassis" b: "fr" hinge { axis { x: 1 } } }
    joint { name: "axle_rl" a: "chassis" b: "rl" hinge { axis { x: 1 } motor { speed_rps { constant: 9 } max_torque_nm: 150 } } }
    joint { name: "axle_rr" a: "chassis" b: "rr" hinge { axis { x: 1 } motor { speed_rps { constant: 9 } max_torque_nm: 150 } } }
    seat { place { y_m: 1.1 } }
    seat { place { y_m: 1.1 z_m: -0.9 } }
    control { joint: "axle_rl" value: 14 }
    control { joint: "axle_rr" value: 14 }
  }
}
)";

inline const std::string kRagdollText = R"(type {
  name: "ragdoll" friction: 0.8 aura_m { normal: 40 } angular_drag_ps: 0.5
  assembly {
    part { name: "pelvis" box { x_m: 0.36 y_m: 0.24 z_m: 0.22 } y_m: 1 mass_kg: 14 }
    part { name: "chest" box { x_m: 0.4 y_m: 0.44 z_m: 0.24 } y_m: 1.36 mass_kg: 24 }
    part { name: "head" sphere { radius_m: 0.12 } y_m: 1.74 mass_kg: 5 }
    part { name: "arm_l" capsule { radius_m: 0.06 length_m: 0.44 } x_m: 0.27 y_m: 1.3 mass_kg: 4 }
    part { name: "arm_r" capsule { radius_m: 0.06 length_m: 0.44 } x_m: -0.27 y_m: 1.3 mass_kg: 4 }
    part { name: "leg_l" capsule { radius_m: 0.08 length_m: 0.7 } x_m: 0.11 y_m: 0.45 mass_kg: 10 }
    part { name: "leg_r" capsule { radius_m: 0.08 length_m: 0.7 } x_m: -0.11 y_m: 0.45 mass_kg: 10 }
    joint { name: "waist" a: "pelvis" b: "chest" anchor { y_m: -0.23 } hinge { axis { x: 1 } min_deg: -30 max_deg: 50 friction_nm: 4 } }
    joint { name: "neck" a: "chest" b: "head" anchor { y_m: -0.14 } hinge { axis { x: 1 } min_deg: -40 max_deg: 40 friction_nm: 1 } }
    joint { name: "shoulder_l" a: "chest" b: "arm_l" anchor { y_m: 0.24 } ball { friction_nm: 1.5 } }
    joint { name: "shoulder_r" a: "chest" b: "arm_r" anchor { y_m: 0.24 } ball { friction_nm: 1.5 } }
    joint { name: "hip_l" a: "pelvis" b: "leg_l" anchor { y_m: 0.4 } ball { friction_nm: 3 } }
    joint { name: "hip_r" a: "pelvis" b: "leg_r" anchor { y_m: 0.4 } ball { friction_nm: 3 } }
  }
}
)";

/// `planks` of 0.5 m along x, hung at both ends: an arc that begins and ends 20 degrees steep.
inline std::string bridge_text(int planks) {
    constexpr double kSteep = 20.0;
    std::string text =
        "type {\n  name: \"bridge\" friction: 0.8 aura_m { normal: 40 }\n  assembly {\n";
    double x = 0.0;
    double y = 0.0;
    for (int p = 0; p < planks; ++p) {
        const double slope = kSteep * (2.0 * p / (planks - 1) - 1.0);
        const double turn = slope * std::numbers::pi / 180.0;
        text += "    part { name: \"p" + std::to_string(p) +
                "\" box { x_m: 0.46 y_m: 0.06 z_m: 1.4 } x_m: " +
                std::to_string(x + 0.25 * std::cos(turn)) +
                " y_m: " + std::to_string(y + 0.25 * std::sin(turn)) +
                " roll_deg: " + std::to_string(slope) + " mass_kg: 12 }\n";
        x += 0.5 * std::cos(turn);
        y += 0.5 * std::sin(turn);
    }
    text +=
        "    joint { name: \"near\" b: \"p0\" anchor { x_m: -0.25 } hinge { axis { z: 1 } } }\n";
    for (int p = 1; p < planks; ++p) {
        text += "    joint { a: \"p" + std::to_string(p - 1) + "\" b: \"p" + std::to_string(p) +
                "\" anchor { x_m: -0.25 } hinge { axis { z: 1 } friction_nm: 4 } }\n";
    }
    text += "    joint { name: \"far\" b: \"p" + std::to_string(planks - 1) +
            "\" anchor { x_m: 0.25 } hinge { axis { z: 1 } } }\n  }\n}\n";
    return text;
}

/// A mast on the ground, a boom that swings with time, and a load on a rope of `length_m`.
inline const std::string kCraneText = R"(type {
  name: "crane" aura_m { normal: 40 }
  assembly {
    part { name: "mast" box { x_m: 0.6 y_m: 6 z_m: 0.6 } y_m: 3.05 mass_kg: 900 }
    part { name: "boom" box { x_m: 0.4 y_m: 0.4 z_m: 6 } y_m: 6.3 z_m: 2 mass_kg: 200 }
    part { name: "load" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } y_m: 3 z_m: 4.6 mass_kg: 60 }
    joint { name: "foot" b: "mast" anchor { y_m: -3 } fixed { } }
    joint { name: "swing" a: "mast" b: "boom" anchor { z_m: -2 } hinge { axis { y: 1 }
      motor { angle_deg { ramps { point { at_s: 1 value: 0 } point { at_s: 5 value: 60 } } } max_torque_nm: 20000 max_speed_rps: 0.6 } } }
    joint { name: "cable" a: "boom" b: "load" anchor { y_m: 0.4 } anchor_a { y_m: -0.2 z_m: 2.6 } distance { } }
  }
}
)";

}  // namespace zoned::scenario
