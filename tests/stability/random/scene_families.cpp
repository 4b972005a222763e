#include "tests/stability/random/scene_families.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace zoned::stability {

namespace {

using physics::BodyKind;
using physics::JointKind;
using physics::ShapeKind;

constexpr float kPi = std::numbers::pi_v<float>;

RandomPart sphere(float radius) {
    RandomPart part;
    part.kind = ShapeKind::kSphere;
    part.radius = radius;
    return part;
}

RandomPart box(const Vec3& half) {
    RandomPart part;
    part.half = half;
    return part;
}

RandomPart capsule(float radius, float half_segment) {
    RandomPart part;
    part.kind = ShapeKind::kCapsule;
    part.radius = radius;
    part.half_segment = half_segment;
    return part;
}

float volume(const RandomPart& part) {
    const float r = part.radius;
    switch (part.kind) {
        case ShapeKind::kSphere:
            return 4.0F / 3.0F * kPi * r * r * r;
        case ShapeKind::kCapsule:
            return kPi * r * r * (4.0F / 3.0F * r + 2.0F * part.half_segment);
        case ShapeKind::kHull: {
            Vec3 lower = part.points.front();
            Vec3 upper = lower;
            for (const Vec3& p : part.points) {
                lower = lower.cwiseMin(p);
                upper = upper.cwiseMax(p);
            }
            return 0.5F * (upper - lower).prod();  // a hull fills about half of its box
        }
        default:
            return 8.0F * part.half.prod();
    }
}

int add(Assembly& out, RandomBody body, const Vec3& at) {
    body.at = at;
    out.bodies.push_back(std::move(body));
    return static_cast<int>(out.bodies.size()) - 1;
}

RandomJoint& join(Assembly& out, JointKind kind, int a, int b, const Vec3& anchor) {
    RandomJoint joint;
    joint.a = a;
    joint.b = b;
    joint.def.kind = kind;
    joint.def.anchor = joint.def.anchor_b = anchor;
    out.joints.push_back(joint);
    return out.joints.back();
}

/// A joint of any kind between two bodies at a point between them; `reach` is about their size.
void join_somehow(SceneDraw& draw, Assembly& out, int a, int b, const Vec3& anchor, float reach) {
    constexpr std::array kKinds{JointKind::kBall,
                                JointKind::kHinge,
                                JointKind::kSlider,
                                JointKind::kFixed,
                                JointKind::kDistance,
                                JointKind::kSpring};
    RandomJoint& joint =
        join(out, kKinds[static_cast<std::size_t>(draw.count(0, 5))], a, b, anchor);
    physics::JointDef& def = joint.def;
    def.axis = draw.direction();
    const RandomBody& body_b = out.bodies[static_cast<std::size_t>(b)];
    const float mass =
        a < 0 ? body_b.mass : std::min(body_b.mass, out.bodies[static_cast<std::size_t>(a)].mass);
    if (def.kind == JointKind::kDistance || def.kind == JointKind::kSpring) {
        def.anchor_b = body_b.at;
        def.anchor = a < 0 ? Vec3(anchor + (anchor - body_b.at))
                           : out.bodies[static_cast<std::size_t>(a)].at;
        def.spring_hz = draw.range(0.5F, 8.0F);
        def.spring_damping_ratio = draw.range(0.1F, 1.5F);
        if (def.kind == JointKind::kSpring && draw.chance(0.5F)) {
            def.length_m = draw.range(0.8F, 1.2F) * (def.anchor_b - def.anchor).norm();
        }
    }
    const bool free_axis = def.kind == JointKind::kHinge || def.kind == JointKind::kSlider;
    if (def.kind == JointKind::kSlider || (free_axis && draw.chance(0.5F))) {
        const float most = def.kind == JointKind::kHinge ? 1.5F : reach;
        def.limited = true;
        def.lower = -draw.range(0.0F, most);
        def.upper = draw.range(0.0F, most);
    }
    if (free_axis && draw.chance(0.3F)) {
        def.motor = true;
        def.motor_speed = draw.range(-8.0F, 8.0F) * (def.kind == JointKind::kHinge ? 1.0F : reach);
        def.motor_max = draw.decades(1.0F, 100.0F) * mass * kGravity *
                        (def.kind == JointKind::kHinge ? reach : 1.0F);
    }
    // A part that breaks off collides: held within its partner, it would be thrown out.
    def.collide = draw.chance(0.15F);
    if (def.collide && draw.chance(0.5F)) {
        def.break_force_n = draw.decades(5.0F, 500.0F) * mass * kGravity;
    }
}

void make_stack(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(2, 8);
    float top = 0.0F;
    float wide = draw.range(0.2F, 0.8F);
    for (int i = 0; i < count; ++i) {
        const float high = draw.range(0.1F, 0.4F);
        RandomBody body = draw.solid(box(Vec3(wide, high, wide * draw.range(0.7F, 1.0F))));
        draw.spread_mass(body);
        body.turn = Quat(Eigen::AngleAxisf(draw.range(0.0F, 0.3F), Vec3::UnitY()));
        add(out, body, Vec3(0.0F, top + high, 0.0F));
        top += 2.0F * high;
        wide *= draw.range(0.8F, 1.0F);
    }
}

void make_pile(SceneDraw& draw, Assembly& out) {
    const int side = draw.count(2, 3);
    const int layers = draw.count(1, 4);
    const float step = 1.2F;
    const float half = 0.5F * step * static_cast<float>(side) + 0.3F;
    if (draw.chance(0.5F)) {  // a pit around it
        const float wall = draw.range(0.05F, 0.5F);
        for (const float sign : {-1.0F, 1.0F}) {
            for (const bool x : {false, true}) {
                const float out_by = sign * (half + wall);
                RandomBody body = draw.solid(
                    box(x ? Vec3(wall, 2.0F, half + 2.0F * wall) : Vec3(half, 2.0F, wall)));
                body.kind = BodyKind::kStatic;
                add(out, body, x ? Vec3(out_by, 2.0F, 0.0F) : Vec3(0.0F, 2.0F, out_by));
            }
        }
    }
    for (int i = 0; i < side * side * layers; ++i) {
        RandomBody body = draw.body(draw.range(0.3F, 0.8F));
        draw.spread_mass(body);
        body.turn = draw.turn();
        const Vec3 cell(static_cast<float>(i % side),
                        static_cast<float>(i / (side * side)),
                        static_cast<float>(i / side % side));
        const Vec3 from(
            0.5F * static_cast<float>(side - 1), -0.6F, 0.5F * static_cast<float>(side - 1));
        add(out, body, step * (cell - from) + 0.1F * draw.direction());
    }
}

/// Balls or boxes in a row with gaps, hit by the first.
void make_row(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(2, 7);
    const bool balls = draw.chance(0.7F);
    const float size = draw.range(0.2F, 0.5F);
    const float gap = draw.chance(0.3F) ? 0.0F : draw.range(0.0F, 0.1F);
    for (int i = 0; i < count; ++i) {
        RandomBody body = draw.solid(balls ? sphere(size) : box(Vec3::Constant(size)));
        if (draw.chance(0.3F)) {
            draw.spread_mass(body);
        }
        body.velocity.x() = i == 0 ? draw.range(1.0F, 8.0F) : 0.0F;
        const float first = i == 0 ? -draw.range(0.0F, 0.5F) : 0.0F;
        add(out, body, Vec3(static_cast<float>(i) * (2.0F * size + gap) + first, size, 0.0F));
    }
}

void make_break(SceneDraw& draw, Assembly& out) {
    const float r = draw.range(0.1F, 0.4F);
    const float step = 2.0F * r + (draw.chance(0.5F) ? 0.0F : draw.range(0.0F, 0.01F));
    const int rows = draw.count(2, 5);
    for (int row = 0; row < rows; ++row) {
        for (int i = 0; i <= row; ++i) {
            add(out,
                draw.solid(sphere(r)),
                Vec3(0.5F * std::sqrt(3.0F) * step * static_cast<float>(row),
                     r,
                     step * (static_cast<float>(i) - 0.5F * static_cast<float>(row))));
        }
    }
    RandomBody cue = draw.solid(sphere(r));
    cue.velocity.x() = draw.range(2.0F, 10.0F);
    add(out, cue, Vec3(-3.0F * r, r, draw.range(-0.5F, 0.5F) * r));
}

/// A link of a chain, about `length` metres long along x.
RandomBody link_of(SceneDraw& draw, float length) {
    const float thin = draw.range(0.1F, 0.4F) * length;
    switch (draw.count(0, 2)) {
        case 0: {
            RandomPart part = capsule(0.5F * thin, std::max(0.5F * (length - thin), 0.01F));
            RandomBody body = draw.solid(part);
            body.turn = Quat(Eigen::AngleAxisf(-0.5F * kPi, Vec3::UnitZ()));
            return body;
        }
        case 1:
            return draw.solid(sphere(0.45F * length));
        default:
            return draw.solid(box(Vec3(0.48F * length, 0.5F * thin, 0.5F * thin)));
    }
}

void make_chain(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(2, 16);
    const float length = draw.range(0.2F, 0.8F);
    const bool one_kind = draw.chance(0.6F);
    const float high = draw.range(0.5F, 4.0F);
    const RandomBody link = link_of(draw, length);
    int last = -1;
    if (draw.setting == SceneSetting::kGround && draw.chance(0.25F)) {
        RandomBody mover = draw.solid(sphere(0.1F));
        mover.kind = BodyKind::kKinematic;
        mover.velocity = 0.5F * draw.direction();
        mover.velocity.y() = std::abs(mover.velocity.y());
        last = add(out, mover, Vec3(-0.5F * length, high, 0.0F));
    }
    const bool held = last >= 0 || (draw.setting == SceneSetting::kGround && draw.chance(0.5F));
    for (int i = 0; i < count; ++i) {
        RandomBody body = link;
        if (draw.chance(0.2F) || i + 1 == count) {
            draw.spread_mass(body);
        }
        body.velocity =
            draw.setting == SceneSetting::kAdrift ? Vec3(draw.direction()) : Vec3::Zero();
        const int now = add(out, body, Vec3(length * static_cast<float>(i), high, 0.0F));
        const Vec3 anchor(length * (static_cast<float>(i) - 0.5F), high, 0.0F);
        if (i > 0 || held) {
            if (one_kind || (i == 0 && last >= 0)) {
                join(out, JointKind::kBall, last, now, anchor);
            } else {
                join_somehow(draw, out, last, now, anchor, length);
            }
        }
        last = now;
    }
    out.clearance = held ? 1000.0F : draw.range(0.0F, 0.5F);  // of a held one: as it is
}

void make_tree(SceneDraw& draw, Assembly& out) {
    const float length = draw.range(0.3F, 0.8F);
    const int count = draw.count(3, 14);
    RandomBody first = draw.solid(sphere(0.3F * length));
    first.velocity = draw.setting == SceneSetting::kAdrift ? Vec3(draw.direction()) : Vec3::Zero();
    add(out, first, Vec3::Zero());
    for (int i = 1; i < count; ++i) {
        const int parent = draw.count(std::max(0, i - 4), i - 1);
        const Vec3 way = length * draw.direction();
        const Vec3 from = out.bodies[static_cast<std::size_t>(parent)].at;
        RandomBody body = draw.body(0.6F * length);
        body.turn = draw.turn();
        if (draw.chance(0.3F)) {
            draw.spread_mass(body);
        }
        const int now = add(out, body, from + way);
        join_somehow(draw, out, parent, now, from + 0.5F * way, length);
    }
    out.clearance = draw.range(0.01F, 2.0F);
}

void make_sheet(SceneDraw& draw, Assembly& out) {
    const int n = draw.count(2, draw.chance(0.2F) ? 12 : 5);
    const int m = draw.count(2, draw.chance(0.2F) ? 12 : 5);
    const float step = draw.range(0.25F, 0.5F);
    const bool distance = draw.chance(0.3F);
    for (int i = 0; i < n * m; ++i) {
        RandomBody body = draw.solid(sphere(0.3F * step));
        body.velocity =
            draw.setting == SceneSetting::kAdrift ? Vec3(0.3F * draw.direction()) : Vec3::Zero();
        const int now =
            add(out, body, step * Vec3(static_cast<float>(i % n), 0.0F, static_cast<float>(i / n)));
        for (const int back : {i % n > 0 ? 1 : 0, i >= n ? n : 0}) {
            if (back > 0) {
                const Vec3 other = out.bodies[static_cast<std::size_t>(now - back)].at;
                const Vec3 here = out.bodies.back().at;
                RandomJoint& joint = join(out,
                                          distance ? JointKind::kDistance : JointKind::kBall,
                                          now - back,
                                          now,
                                          0.5F * (here + other));
                if (distance) {
                    joint.def.anchor = other;
                    joint.def.anchor_b = here;
                }
            }
        }
    }
    out.clearance = draw.range(0.2F, 2.0F);
}

void make_loop(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(3, 12);
    const float length = draw.range(0.3F, 0.6F);
    const float radius = 0.5F * length / std::sin(kPi / static_cast<float>(count));
    const bool hinges = draw.chance(0.5F);
    const Quat lie = draw.chance(0.5F) ? Quat(Quat::Identity()) : draw.turn();
    const auto at = [&](float i) {
        const float angle = 2.0F * kPi * i / static_cast<float>(count);
        return Vec3(lie * Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.0F));
    };
    for (int i = 0; i < count; ++i) {
        RandomBody body = draw.solid(sphere(0.4F * length));
        if (draw.chance(0.3F)) {
            draw.spread_mass(body);
        }
        body.velocity =
            draw.setting == SceneSetting::kAdrift ? Vec3(draw.direction()) : Vec3::Zero();
        add(out, body, at(static_cast<float>(i)));
    }
    for (int i = 0; i < count; ++i) {
        const int next = (i + 1) % count;
        if (count == 2 && i == 1) {
            break;
        }
        const Vec3 middle = 0.5F * (out.bodies[static_cast<std::size_t>(i)].at +
                                    out.bodies[static_cast<std::size_t>(next)].at);
        join(out, hinges ? JointKind::kHinge : JointKind::kBall, i, next, middle).def.axis =
            lie * Vec3::UnitZ();
    }
    out.clearance = draw.range(0.01F, 1.0F);
}

void make_vehicle(SceneDraw& draw, Assembly& out) {
    const Vec3 half{draw.range(0.5F, 1.0F), draw.range(0.15F, 0.3F), draw.range(0.8F, 2.0F)};
    const float ratio = draw.decades(1.0F, 200.0F);
    const float r = draw.range(0.25F, 0.5F);
    RandomBody chassis = draw.solid(box(half));
    chassis.mass = draw.decades(10.0F, 2000.0F);
    const int body = add(out, chassis, Vec3::Zero());
    const bool driven = draw.chance(0.6F);
    const float speed = draw.range(3.0F, 20.0F);
    const float torque = draw.range(0.1F, 0.5F) * chassis.mass;
    const bool boxes = draw.chance(0.1F);
    for (int i = 0; i < 4; ++i) {
        const float side = (i & 1) != 0 ? 1.0F : -1.0F;
        const Vec3 at(side * (half.x() + 0.6F * r),
                      -half.y() - 0.1F,
                      ((i & 2) != 0 ? 1.0F : -1.0F) * (half.z() - 0.5F * r));
        RandomBody wheel = draw.solid(boxes ? box(Vec3::Constant(0.5F * r)) : sphere(r));
        wheel.mass = chassis.mass / ratio;
        RandomJoint& hinge = join(out, JointKind::kHinge, body, add(out, wheel, at), at);
        hinge.def.axis = Vec3::UnitX();
        hinge.def.motor = driven;
        hinge.def.motor_speed = driven ? speed : 0.0F;
        hinge.def.motor_max = driven ? torque : 0.0F;
    }
    out.clearance = draw.range(0.005F, 1.0F);
}

void make_ragdoll(SceneDraw& draw, Assembly& out) {
    const auto limb = [&](float mass, float radius, float half_segment, const Vec3& at) {
        RandomBody body = draw.solid(capsule(radius, half_segment));
        body.mass = mass;
        return add(out, body, at);
    };
    const int pelvis = limb(10.0F, 0.12F, 0.06F, Vec3(0.0F, 0.0F, 0.0F));
    const int chest = limb(20.0F, 0.14F, 0.12F, Vec3(0.0F, 0.42F, 0.0F));
    const int head = limb(5.0F, 0.1F, 0.04F, Vec3(0.0F, 0.85F, 0.0F));
    join(out, JointKind::kBall, pelvis, chest, Vec3(0.0F, 0.17F, 0.0F));
    join(out, JointKind::kBall, chest, head, Vec3(0.0F, 0.7F, 0.0F));
    const auto bend = [&](int a, int b, const Vec3& at) {
        RandomJoint& joint = join(out, JointKind::kHinge, a, b, at);
        joint.def.axis = Vec3::UnitX();
        joint.def.limited = true;
        joint.def.upper = 2.2F;
    };
    for (const float s : {-1.0F, 1.0F}) {
        const int arm = limb(2.5F, 0.05F, 0.12F, Vec3(0.22F * s, 0.42F, 0.0F));
        const int fore = limb(1.5F, 0.04F, 0.12F, Vec3(0.22F * s, 0.08F, 0.0F));
        const int thigh = limb(7.0F, 0.07F, 0.16F, Vec3(0.1F * s, -0.4F, 0.0F));
        const int shin = limb(4.0F, 0.05F, 0.18F, Vec3(0.1F * s, -0.87F, 0.0F));
        join(out, JointKind::kBall, chest, arm, Vec3(0.22F * s, 0.58F, 0.0F));
        bend(arm, fore, Vec3(0.22F * s, 0.25F, 0.0F));
        join(out, JointKind::kBall, pelvis, thigh, Vec3(0.1F * s, -0.18F, 0.0F));
        bend(thigh, shin, Vec3(0.1F * s, -0.64F, 0.0F));
    }
    const Quat lie = draw.turn();
    for (RandomBody& body : out.bodies) {
        body.at = lie * body.at;
        body.turn = lie;
    }
    for (RandomJoint& joint : out.joints) {
        joint.def.anchor = lie * joint.def.anchor;
        joint.def.axis = lie * joint.def.axis;
    }
    out.clearance = draw.range(0.01F, 2.0F);
}

/// Two or three bodies of any shape and mass ratio, joined and dropped.
void make_pair(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(2, 3);
    const Quat lie = draw.chance(0.5F) ? Quat(Quat::Identity()) : draw.turn();
    for (int i = 0; i < count; ++i) {
        RandomBody body = draw.body(draw.range(0.3F, 1.0F));
        body.turn = draw.chance(0.5F) ? Quat(Quat::Identity()) : draw.turn();
        draw.spread_mass(body);
        body.velocity =
            draw.setting == SceneSetting::kAdrift ? Vec3(2.0F * draw.direction()) : Vec3::Zero();
        body.spin =
            draw.setting == SceneSetting::kAdrift ? Vec3(3.0F * draw.direction()) : Vec3::Zero();
        const Vec3 at = lie * Vec3(0.0F, static_cast<float>(i), 0.0F);
        const int now = add(out, body, at);
        if (i > 0) {
            join_somehow(draw,
                         out,
                         now - 1,
                         now,
                         lie * Vec3(0.0F, static_cast<float>(i) - 0.5F, 0.0F),
                         0.5F);
        }
    }
    out.clearance = draw.range(0.0F, 1.0F);
}

/// Plates that lean against each other in pairs, up to two storeys.
void make_cards(SceneDraw& draw, Assembly& out) {
    const float t = draw.decades(0.002F, 0.02F);
    const Vec3 half{t, 0.5F * draw.range(0.6F, 1.2F), 0.5F * draw.range(0.5F, 1.0F)};
    const float lean = draw.range(0.15F, 0.4F);
    const int pairs = draw.count(1, 3);
    const int storeys = draw.count(1, 2);
    const float high = half.y() * std::cos(lean) + t * std::sin(lean);
    const float foot = half.y() * std::sin(lean) + t * std::cos(lean);
    const float mass = draw.range(0.05F, 0.5F);
    for (int storey = 0; storey < storeys && storey < pairs; ++storey) {
        const float base = static_cast<float>(storey) * (2.0F * high + 2.0F * t);
        for (int p = 0; p < pairs - storey; ++p) {
            const float middle =
                (static_cast<float>(p) + 0.5F * static_cast<float>(storey)) * 4.0F * foot;
            for (const float side : {-1.0F, 1.0F}) {
                RandomBody card = draw.solid(box(half));
                card.mass = mass;
                card.turn = Quat(Eigen::AngleAxisf(side * lean, Vec3::UnitZ()));
                add(out, card, Vec3(middle + side * foot, base + high, 0.0F));
            }
            if (p > 0) {
                RandomBody across = draw.solid(box(Vec3(2.0F * foot, t, half.z())));
                across.mass = mass;
                add(out, across, Vec3(middle - 2.0F * foot, base + 2.0F * high + t, 0.0F));
            }
        }
    }
}

void make_bullet(SceneDraw& draw, Assembly& out) {
    RandomBody wall = draw.solid(box(Vec3(draw.decades(0.01F, 0.2F), 1.0F, 1.0F)));
    wall.kind = BodyKind::kStatic;
    if (draw.setting == SceneSetting::kAdrift || draw.chance(0.7F)) {
        add(out, wall, Vec3(0.0F, 1.0F, 0.0F));
    } else {  // a mass between the bullet and what follows
        wall.kind = BodyKind::kDynamic;
        add(out, wall, Vec3(0.0F, 1.0F, 0.0F));
    }
    for (int i = draw.count(1, 4); i > 0; --i) {
        RandomBody body = draw.body(draw.range(0.05F, 0.3F));
        body.turn = draw.turn();
        body.velocity =
            Vec3{draw.decades(10.0F, 300.0F), draw.range(-1.0F, 1.0F), draw.range(-1.0F, 1.0F)};
        body.spin = draw.vector(0.0F, 10.0F);
        add(out,
            body,
            Vec3{-draw.range(1.0F, 6.0F), draw.range(0.4F, 1.6F), draw.range(-0.6F, 0.6F)});
    }
}

/// A lift, a paddle or a turntable, with bodies on it or before it.
void make_mover(SceneDraw& draw, Assembly& out) {
    RandomBody mover = draw.solid(box(Vec3(1.5F, 0.2F, 1.5F)));
    mover.kind = BodyKind::kKinematic;
    float top = 0.4F;
    switch (draw.count(0, 2)) {
        case 0:
            mover.velocity.y() = draw.range(0.1F, 2.0F);
            add(out, mover, Vec3(0.0F, 0.2F, 0.0F));
            break;
        case 1:
            mover.spin.y() = draw.range(-2.0F, 2.0F);
            add(out, mover, Vec3(0.0F, 0.2F, 0.0F));
            break;
        default:
            // It goes down into the ground: nothing gets below it.
            mover.parts.front().half = Vec3(0.1F, 1.0F, 1.5F);
            mover.velocity.x() = draw.range(0.2F, 3.0F);
            add(out, mover, Vec3(-1.5F, 0.8F, 0.0F));
            top = 0.0F;
            break;
    }
    for (int i = 0; i < draw.count(1, 6); ++i) {
        RandomBody body = draw.body(draw.range(0.2F, 0.5F));
        body.turn = draw.turn();
        draw.spread_mass(body);
        add(out,
            body,
            Vec3{draw.range(-0.8F, 0.8F),
                 top + 0.5F + 0.6F * static_cast<float>(i),
                 draw.range(-0.8F, 0.8F)});
    }
    out.at_origin = true;
}

/// Arms on motors with limits, held by the world, in reach of loose bodies.
void make_machine(SceneDraw& draw, Assembly& out) {
    const float high = draw.range(0.5F, 1.5F);
    RandomBody arm = draw.solid(box(Vec3(0.5F, 0.08F, 0.08F)));
    const int first = add(out, arm, Vec3(0.5F, high, 0.0F));
    RandomJoint& hinge = join(out, JointKind::kHinge, -1, first, Vec3(0.0F, high, 0.0F));
    hinge.def.axis = draw.chance(0.5F) ? Vec3::UnitY() : Vec3::UnitZ();
    hinge.def.motor = true;
    hinge.def.motor_speed = draw.range(-6.0F, 6.0F);
    hinge.def.motor_max = draw.range(0.5F, 10.0F) * arm.mass * kGravity;
    hinge.def.limited = draw.chance(0.7F);
    hinge.def.lower = hinge.def.limited ? -draw.range(0.1F, 1.0F) : 0.0F;
    hinge.def.upper = hinge.def.limited ? draw.range(0.1F, 1.0F) : 0.0F;
    if (draw.chance(0.6F)) {
        const int second = add(out, arm, Vec3(1.52F, high, 0.0F));
        join_somehow(draw, out, first, second, Vec3(1.01F, high, 0.0F), 0.5F);
    }
    for (int i = draw.count(0, 3); i > 0; --i) {
        RandomBody body = draw.body(draw.range(0.2F, 0.5F));
        draw.spread_mass(body);
        add(out, body, Vec3{draw.range(0.3F, 1.0F), 0.6F + high, draw.range(0.6F, 1.0F)});
    }
    out.clearance = 1000.0F;
}

void make_loose(SceneDraw& draw, Assembly& out) {
    for (int i = 0; i < draw.count(1, 5); ++i) {
        RandomBody body = draw.body(draw.decades(0.1F, 1.5F));
        body.turn = draw.turn();
        body.velocity = draw.vector(0.0F, 6.0F);
        body.spin = draw.vector(0.0F, 8.0F);
        draw.spread_mass(body);
        add(out,
            body,
            Vec3{draw.range(-2.0F, 2.0F), draw.range(0.0F, 3.0F), draw.range(-2.0F, 2.0F)});
    }
    out.clearance = draw.range(0.0F, 3.0F);
}

void make_cradle(SceneDraw& draw, Assembly& out) {
    const int count = draw.count(2, 6);
    const float r = draw.range(0.1F, 0.4F);
    const float rod = draw.range(1.0F, 3.0F);
    const float angle = draw.range(0.3F, 0.9F);
    const float high = rod + r + 0.5F;
    const bool stiff = draw.chance(0.5F);
    for (int i = 0; i < count; ++i) {
        const float x = (2.0F * r + 0.0005F) * static_cast<float>(i);
        const Vec3 top(x, high, 0.0F);
        const float swing = i == 0 ? angle : 0.0F;
        const Vec3 at = top + rod * Vec3(-std::sin(swing), -std::cos(swing), 0.0F);
        const int ball = add(out, draw.solid(sphere(r)), at);
        RandomJoint& joint =
            join(out, stiff ? JointKind::kHinge : JointKind::kDistance, -1, ball, top);
        joint.def.axis = Vec3::UnitZ();
        joint.def.anchor_b = stiff ? top : at;
    }
    out.clearance = 1000.0F;
}

constexpr std::array kFamilies{
    SceneFamily{"stack", false, true, make_stack},
    SceneFamily{"pile", false, true, make_pile},
    SceneFamily{"row", true, true, make_row},
    SceneFamily{"break", true, true, make_break},
    SceneFamily{"chain", true, false, make_chain},
    SceneFamily{"tree", true, false, make_tree},
    SceneFamily{"sheet", true, false, make_sheet},
    SceneFamily{"loop", true, false, make_loop},
    SceneFamily{"vehicle", false, false, make_vehicle},
    SceneFamily{"ragdoll", true, false, make_ragdoll},
    SceneFamily{"pair", true, false, make_pair},
    SceneFamily{"cards", false, true, make_cards},
    SceneFamily{"bullet", true, true, make_bullet},
    SceneFamily{"mover", false, true, make_mover},
    SceneFamily{"machine", false, false, make_machine},
    SceneFamily{"loose", true, false, make_loose},
    SceneFamily{"cradle", false, false, make_cradle},
};

}  // namespace

Vec3 SceneDraw::direction() {
    // Marsaglia, "Choosing a point from the surface of a sphere", Ann. Math. Statist. 43(2), 1972.
    for (;;) {
        const float u = range(-1.0F, 1.0F);
        const float v = range(-1.0F, 1.0F);
        const float s = u * u + v * v;
        if (s < 1.0F) {
            const float w = 2.0F * std::sqrt(1.0F - s);
            return {u * w, v * w, 1.0F - 2.0F * s};
        }
    }
}

Vec3 SceneDraw::vector(float shortest, float longest) {
    const float length = range(shortest, longest);
    return length * direction();
}

Quat SceneDraw::turn() {
    const Vec3 axis = direction();
    return Quat(Eigen::AngleAxisf(range(0.0F, kPi), axis));
}

RandomBody SceneDraw::solid(const RandomPart& part) {
    RandomBody body;
    body.parts = {part};
    body.mass = std::clamp(density * volume(part), 0.001F, 1.0e5F);
    body.friction = friction;
    body.restitution = restitution;
    return body;
}

void SceneDraw::spread_mass(RandomBody& body) {
    if (decades_of_mass > 0.0F) {
        const float most = std::pow(10.0F, decades_of_mass);
        body.mass = std::clamp(body.mass * decades(1.0F / most, most), 0.001F, 1.0e6F);
    }
}

RandomBody SceneDraw::body(float size) {
    const float half = 0.5F * size;
    switch (count(0, 6)) {
        case 0:
            return solid(sphere(half));
        case 1:
            return solid(capsule(0.4F * half, 0.6F * half));
        case 2: {
            RandomPart part;
            part.kind = ShapeKind::kHull;
            const Vec3 stretch{half, half * range(0.4F, 1.0F), half * range(0.4F, 1.0F)};
            for (int i = count(6, 24); i > 0; --i) {
                part.points.emplace_back(stretch.cwiseProduct(direction()));
            }
            return solid(part);
        }
        case 3: {
            RandomBody compound = solid(box(Vec3(half, 0.25F * half, 0.25F * half)));
            for (int i = count(1, 3); i > 0; --i) {
                RandomPart part =
                    chance(0.5F) ? box(Vec3(0.2F, 0.6F, 0.2F) * half) : sphere(0.3F * half);
                part.at = Vec3{range(-0.8F, 0.8F), range(-0.4F, 0.4F), 0.0F} * half;
                compound.parts.push_back(part);
                compound.mass += density * volume(part);
            }
            return compound;
        }
        case 4:
            return solid(box(Vec3{
                half, std::max(decades(0.005F, 0.1F) * size, 0.002F), half * range(0.5F, 1.0F)}));
        default:
            return solid(box(Vec3{half, half * range(0.3F, 1.0F), half * range(0.3F, 1.0F)}));
    }
}

std::span<const SceneFamily> scene_families() {
    return kFamilies;
}

}  // namespace zoned::stability
