#include "tests/stability/random/scene_shrink.h"

#include "tests/scenario/minimise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::stability {

namespace {

using physics::BodyKind;
using physics::JointKind;
using physics::ShapeKind;

/// The scene with only these bodies, and the joints between them.
RandomScene with_bodies(const RandomScene& scene, const std::vector<std::size_t>& keep) {
    RandomScene out = scene;
    out.bodies.clear();
    out.joints.clear();
    std::vector<int> place(scene.bodies.size(), -1);
    for (const std::size_t i : keep) {
        place[i] = static_cast<int>(out.bodies.size());
        out.bodies.push_back(scene.bodies[i]);
    }
    for (RandomJoint joint : scene.joints) {
        const int a = joint.a < 0 ? -1 : place[static_cast<std::size_t>(joint.a)];
        const int b = place[static_cast<std::size_t>(joint.b)];
        if (b >= 0 && (joint.a < 0 || a >= 0)) {
            joint.a = a;
            joint.b = b;
            out.joints.push_back(joint);
        }
    }
    return out;
}

RandomScene with_joints(const RandomScene& scene, const std::vector<std::size_t>& keep) {
    RandomScene out = scene;
    out.joints.clear();
    for (const std::size_t i : keep) {
        out.joints.push_back(scene.joints[i]);
    }
    return out;
}

float rounded(float x, float unit) {
    const float r = std::round(x / unit) * unit;
    return r == 0.0F ? 0.0F : r;  // no negative zero
}

/// A size, where that changes it by at most a third: a scene of dust is no plainer.
float rounded_size(float x, float unit) {
    const float r = rounded(x, unit);
    return r > 0.67F * x && r < 1.5F * x ? r : x;
}

Vec3 rounded(const Vec3& v, float unit) {
    return {rounded(v.x(), unit), rounded(v.y(), unit), rounded(v.z(), unit)};
}

/// Tries one change after the other and keeps those with which the scene still fails.
class Shrinker {
  public:
    Shrinker(RandomScene scene, const std::function<bool(const RandomScene&)>& fails, int budget)
        : best_(std::move(scene)),
          fails_(fails),
          budget_(budget) {}

    RandomScene run() {
        for (bool better = true; better && budget_ > 0;) {
            const RandomScene before = best_;
            drop_parts();
            shorten();
            plain_scene();
            for (std::size_t i = 0; i < best_.bodies.size(); ++i) {
                plain_body(i);
            }
            for (std::size_t i = 0; i < best_.joints.size(); ++i) {
                plain_joint(i);
            }
            round_numbers();
            better = !(best_ == before);
        }
        return best_;
    }

  private:
    bool holds(const RandomScene& scene) {
        if (budget_ <= 0 || scene == best_ || !why_unsound(scene).empty()) {
            return false;
        }
        --budget_;
        return fails_(scene);
    }

    /// True when the change was kept.
    template <class Change>
    bool change(Change&& make) {
        RandomScene next = best_;
        make(next);
        if (!holds(next)) {
            return false;
        }
        best_ = std::move(next);
        return true;
    }

    void drop_parts() {
        for (const bool bodies : {true, false}) {
            const std::size_t count = bodies ? best_.bodies.size() : best_.joints.size();
            const auto part = [&](const std::vector<std::size_t>& keep) {
                return bodies ? with_bodies(best_, keep) : with_joints(best_, keep);
            };
            const auto still = [&](const std::vector<std::size_t>& keep) {
                return keep.size() < count && why_unsound(part(keep)).empty() && fails_(part(keep));
            };
            best_ = part(scenario::minimise(count, still, budget_));
        }
    }

    void shorten() {
        for (const float share : {0.25F, 0.5F, 0.75F, 0.9F}) {
            if (change([&](RandomScene& s) { s.seconds *= share; })) {
                break;
            }
        }
        change([](RandomScene& s) { s.seconds = std::ceil(s.seconds * 10.0F) / 10.0F; });
    }

    void plain_scene() {
        change([](RandomScene& s) { s.offset = Vec3::Zero(); });
        change([](RandomScene& s) { s.offset = rounded(s.offset, 100.0F); });
        change([](RandomScene& s) { s.dt = 1.0F / 60.0F; });
        change([](RandomScene& s) { s.ground = RandomGround(); });
        change([](RandomScene& s) {
            if (s.ground.kind != GroundKind::kNone) {
                s.ground.kind = GroundKind::kBox;
                s.ground.amplitude = 0.0F;
                s.ground.cell = RandomGround().cell;
                s.ground.wave = RandomGround().wave;
            }
        });
        change([](RandomScene& s) { s.ground.half = RandomGround().half; });
        change([](RandomScene& s) { s.ground.amplitude = rounded(s.ground.amplitude, 0.1F); });
        change([](RandomScene& s) { s.ground.wave = rounded(s.ground.wave, 0.1F); });
        change([](RandomScene& s) { s.ground.friction = 0.5F; });
        change([](RandomScene& s) { s.ground.restitution = 0.0F; });
        change([](RandomScene& s) { s.gravity = Vec3::Zero(); });
        change([](RandomScene& s) {
            for (RandomBody& b : s.bodies) {
                b.friction = 0.5F;
            }
        });
        change([](RandomScene& s) {
            for (RandomBody& b : s.bodies) {
                b.restitution = 0.0F;
            }
        });
    }

    void plain_body(std::size_t i) {
        const auto body = [&](auto&& make) {
            return change([&](RandomScene& s) { make(s.bodies[i]); });
        };
        if (best_.bodies[i].parts.size() > 1) {
            for (std::size_t part = 0; part < best_.bodies[i].parts.size(); ++part) {
                body([part](RandomBody& b) {
                    if (b.parts.size() > 1) {
                        b.parts.erase(b.parts.begin() + static_cast<std::ptrdiff_t>(part));
                    }
                });
            }
        }
        body([](RandomBody& b) {
            for (RandomPart& p : b.parts) {
                simple_part(p, ShapeKind::kBox);
            }
        });
        body([](RandomBody& b) {
            for (RandomPart& p : b.parts) {
                simple_part(p, ShapeKind::kSphere);
            }
        });
        body([](RandomBody& b) {
            if (b.parts.size() == 1) {
                b.parts[0].at = Vec3::Zero();
                b.parts[0].turn = Quat::Identity();
            }
        });
        body([](RandomBody& b) { b.velocity = Vec3::Zero(); });
        body([](RandomBody& b) { b.spin = Vec3::Zero(); });
        body([](RandomBody& b) { b.turn = Quat::Identity(); });
        body([](RandomBody& b) { b.mass = 1.0F; });
        body([](RandomBody& b) { b.mass = std::pow(10.0F, std::round(std::log10(b.mass))); });
        body([](RandomBody& b) { b.friction = 0.5F; });
        body([](RandomBody& b) { b.restitution = 0.0F; });
    }

    /// A box or sphere about the size of the part.
    static void simple_part(RandomPart& p, ShapeKind kind) {
        if (p.kind == kind || (p.kind == ShapeKind::kSphere && kind == ShapeKind::kBox)) {
            return;
        }
        Vec3 lower = -p.half;
        Vec3 upper = p.half;
        if (p.kind == ShapeKind::kHull) {
            lower = upper = p.points.front();
            for (const Vec3& q : p.points) {
                lower = lower.cwiseMin(q);
                upper = upper.cwiseMax(q);
            }
        } else if (p.kind == ShapeKind::kCapsule) {
            upper = Vec3(p.radius, p.half_segment + p.radius, p.radius);
            lower = -upper;
        }
        const RandomPart old = p;
        p = RandomPart();
        p.kind = kind;
        p.at = old.at + old.turn * Vec3(0.5F * (lower + upper));
        p.turn = old.turn;
        if (kind == ShapeKind::kBox) {
            p.half = 0.5F * (upper - lower);
        } else {
            p.radius = 0.5F * std::cbrt((upper - lower).prod());
            p.half_segment = 0.5F;
        }
    }

    void plain_joint(std::size_t i) {
        const auto joint = [&](auto&& make) {
            return change([&](RandomScene& s) { make(s.joints[i].def); });
        };
        joint([](physics::JointDef& d) {
            d.motor = false;
            d.motor_speed = d.motor_max = 0.0F;
        });
        joint([](physics::JointDef& d) {
            d.limited = false;
            d.lower = d.upper = 0.0F;
        });
        joint(
            [](physics::JointDef& d) { d.break_force_n = std::numeric_limits<float>::infinity(); });
        joint([](physics::JointDef& d) { d.collide = false; });
        joint([](physics::JointDef& d) {
            if (d.kind != JointKind::kBall && d.kind != JointKind::kDistance &&
                d.kind != JointKind::kSpring) {
                d.kind = JointKind::kBall;
                d.axis = Vec3::UnitY();
            }
        });
        joint([](physics::JointDef& d) {
            int most = 0;
            d.axis.cwiseAbs().maxCoeff(&most);
            d.axis = Vec3::Unit(most);
        });
        joint([](physics::JointDef& d) { d.motor_speed = rounded(d.motor_speed, 1.0F); });
        joint([](physics::JointDef& d) { d.motor_max = rounded(d.motor_max, 10.0F); });
        joint([](physics::JointDef& d) {
            d.lower = rounded(d.lower, 0.1F);
            d.upper = rounded(d.upper, 0.1F);
        });
        joint([](physics::JointDef& d) { d.spring_hz = rounded(d.spring_hz, 1.0F); });
        joint([](physics::JointDef& d) {
            d.spring_damping_ratio = rounded(d.spring_damping_ratio, 0.1F);
        });
    }

    /// Numbers of one body or joint at a time, to fewer and fewer digits.
    void round_numbers() {
        for (const float unit : {0.001F, 0.01F, 0.05F, 0.1F, 0.5F}) {
            change([unit](RandomScene& s) {
                for (std::size_t i = 0; i < s.bodies.size(); ++i) {
                    round_body(s.bodies[i], unit);
                }
                for (std::size_t i = 0; i < s.joints.size(); ++i) {
                    round_joint(s.joints[i].def, unit);
                }
            });
            for (std::size_t i = 0; i < best_.bodies.size(); ++i) {
                change([&](RandomScene& s) { round_body(s.bodies[i], unit); });
            }
            for (std::size_t i = 0; i < best_.joints.size(); ++i) {
                change([&](RandomScene& s) { round_joint(s.joints[i].def, unit); });
            }
        }
    }

    static void round_body(RandomBody& b, float unit) {
        b.at = rounded(b.at, unit);
        b.velocity = rounded(b.velocity, unit);
        b.spin = rounded(b.spin, unit);
        b.friction = rounded(b.friction, std::min(unit, 0.1F));
        b.restitution = rounded(b.restitution, std::min(unit, 0.1F));
        for (RandomPart& p : b.parts) {
            p.half = p.half.unaryExpr([unit](float x) { return rounded_size(x, unit); });
            p.radius = rounded_size(p.radius, unit);
            p.half_segment = rounded_size(p.half_segment, unit);
            p.at = rounded(p.at, unit);
            for (Vec3& q : p.points) {
                q = rounded(q, unit);
            }
        }
    }

    static void round_joint(physics::JointDef& d, float unit) {
        d.anchor = rounded(d.anchor, unit);
        d.anchor_b = rounded(d.anchor_b, unit);
        if (d.length_m >= 0.0F) {
            d.length_m = rounded(d.length_m, unit);
        }
    }

    RandomScene best_;
    const std::function<bool(const RandomScene&)>& fails_;
    int budget_;
};

}  // namespace

RandomScene shrink_scene(const RandomScene& scene,
                         const std::function<bool(const RandomScene&)>& fails,
                         int budget) {
    return Shrinker(scene, fails, budget).run();
}

}  // namespace zoned::stability
