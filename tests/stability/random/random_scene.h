// RandomScene: a rigid-body scene as plain data, which the lab generates, shrinks, writes, reads.
#pragma once

#include "server/physics/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::stability {

/// A convex solid in the coordinates of its body.
struct RandomPart {
    physics::ShapeKind kind = physics::ShapeKind::kBox;  ///< sphere, box, capsule or hull
    Vec3 half = Vec3::Constant(0.5F);                    ///< box: half extents, m
    float radius = 0.5F;                                 ///< sphere, capsule, m
    float half_segment = 0.5F;                           ///< capsule along y, m
    std::vector<Vec3> points;                            ///< hull: 4..64, m
    Vec3 at = Vec3::Zero();                              ///< m
    Quat turn = Quat::Identity();

    bool operator==(const RandomPart& o) const;
};

struct RandomBody {
    physics::BodyKind kind = physics::BodyKind::kDynamic;  ///< or static, kinematic
    std::vector<RandomPart> parts;                         ///< one, or several of a compound
    float mass = 1.0F;                                     ///< kg
    float friction = 0.5F;
    float restitution = 0.0F;
    Vec3 at = Vec3::Zero();  ///< of the origin of the parts, from RandomScene::offset, m
    Quat turn = Quat::Identity();
    Vec3 velocity = Vec3::Zero();  ///< of the centre of mass, m/s
    Vec3 spin = Vec3::Zero();      ///< rad/s

    bool operator==(const RandomBody& o) const;
};

struct RandomJoint {
    int a = -1;  ///< index of a body; -1: the world
    int b = 0;
    physics::JointDef def;  ///< anchors from RandomScene::offset; its `a` and `b` are not used

    bool operator==(const RandomJoint& o) const;
};

enum class GroundKind : std::uint8_t {
    kNone,
    kBox,  ///< its top is at height 0
    kMesh,
    kHeightfield,
};

/// Static ground about the origin; surfaces have height amplitude sin(wave x) sin(wave z) at the
/// corners of square cells.
struct RandomGround {
    GroundKind kind = GroundKind::kNone;
    float half = 20.0F;      ///< of its width, m
    float cell = 1.0F;       ///< m
    float amplitude = 0.0F;  ///< m
    float wave = 0.5F;       ///< rad/m
    float friction = 0.5F;
    float restitution = 0.0F;

    bool operator==(const RandomGround&) const = default;
};

struct RandomScene {
    std::uint64_t seed = 0;  ///< that it was generated from, with `index`
    std::uint64_t index = 0;
    std::string families;  ///< names of what was put into it, separated by blanks
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);  ///< m/s2
    float dt = 1.0F / 60.0F;                     ///< s
    float seconds = 4.0F;
    Vec3 offset = Vec3::Zero();  ///< of everything from the origin of the zone, m
    RandomGround ground;
    std::vector<RandomBody> bodies;
    std::vector<RandomJoint> joints;

    bool operator==(const RandomScene& o) const;
};

inline constexpr std::size_t kMostSceneBodies = 4096;
inline constexpr std::size_t kMostSceneJoints = 4096;
inline constexpr std::size_t kMostSceneParts = 64;  ///< of one body
inline constexpr float kMostSceneSteps = 1.0e5F;
inline constexpr float kMostGroundCells = 256.0F;  ///< along a side
/// Overlap, gap of a joint and violated limit that a sound scene may start with, m and rad.
inline constexpr double kSoundAtStart = 1.0e-3;

/// Height of the ground's surface at a place, m; -infinity beside it and where there is none.
double ground_height(const RandomGround& ground, double x, double z);
/// Lowest height of its surface, m; +infinity where there is none.
double lowest_ground(const RandomGround& ground);

/// Empty for a scene that is fit to blame an engine with: numbers are in range, no two bodies that
/// collide overlap by more than kSoundAtStart, joints are closed and limits hold. Otherwise the
/// reason.
std::string why_unsound(const RandomScene& scene);

/// A scene in the engine.
struct LiveScene {
    physics::Scene scene;
    std::vector<BodyId> bodies;               ///< in the order of RandomScene::bodies
    std::vector<Vec3d> moments;               ///< principal ones in the engine's axes, kg m2
    std::vector<std::vector<Vec3d>> centres;  ///< of each part, in the engine's axes of its body
    std::vector<double> radii;                ///< of bounding spheres about the centres of mass, m
    std::vector<JointId> joints;
    std::vector<std::vector<std::string>> warnings;  ///< of the engine about each joint
};

/// With the engine's default settings and the scene's gravity. Fails with the engine's reason.
core::Result<LiveScene> build_live(const RandomScene& scene);

}  // namespace zoned::stability
