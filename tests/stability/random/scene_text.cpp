#include "tests/stability/random/scene_text.h"

#include "server/physics/shapes/convex/hull_view.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

namespace zoned::stability {

namespace {

using physics::BodyKind;
using physics::JointKind;
using physics::ShapeKind;

template <class Kind, std::size_t kCount>
using Kinds = std::array<std::pair<std::string_view, Kind>, kCount>;

constexpr Kinds<BodyKind, 3> kBodyKinds{{{"static", BodyKind::kStatic},
                                         {"kinematic", BodyKind::kKinematic},
                                         {"dynamic", BodyKind::kDynamic}}};
constexpr Kinds<ShapeKind, 4> kPartKinds{{{"sphere", ShapeKind::kSphere},
                                          {"box", ShapeKind::kBox},
                                          {"capsule", ShapeKind::kCapsule},
                                          {"hull", ShapeKind::kHull}}};
constexpr Kinds<JointKind, 6> kJointKinds{{{"ball", JointKind::kBall},
                                           {"hinge", JointKind::kHinge},
                                           {"slider", JointKind::kSlider},
                                           {"fixed", JointKind::kFixed},
                                           {"distance", JointKind::kDistance},
                                           {"spring", JointKind::kSpring}}};
constexpr Kinds<GroundKind, 4> kGroundKinds{{{"none", GroundKind::kNone},
                                             {"box", GroundKind::kBox},
                                             {"mesh", GroundKind::kMesh},
                                             {"heightfield", GroundKind::kHeightfield}}};

template <class Kind, std::size_t kCount>
std::string name_of(const Kinds<Kind, kCount>& kinds, Kind kind) {
    for (const auto& [name, value] : kinds) {
        if (value == kind) {
            return std::string(name);
        }
    }
    throw std::invalid_argument("a kind that scene files do not hold");
}

// The settings of each record: one list for the writer and the reader.

template <class Visit>
void visit_settings(RandomScene& s, Visit&& visit) {
    visit("seed", s.seed);
    visit("index", s.index);
    visit("gravity", s.gravity);
    visit("dt", s.dt);
    visit("seconds", s.seconds);
    visit("offset", s.offset);
}

template <class Visit>
void visit_settings(RandomGround& g, Visit&& visit) {
    visit("half", g.half);
    visit("cell", g.cell);
    visit("amplitude", g.amplitude);
    visit("wave", g.wave);
    visit("friction", g.friction);
    visit("restitution", g.restitution);
}

template <class Visit>
void visit_settings(RandomBody& b, Visit&& visit) {
    visit("mass", b.mass);
    visit("friction", b.friction);
    visit("restitution", b.restitution);
    visit("at", b.at);
    visit("turn", b.turn);
    visit("velocity", b.velocity);
    visit("spin", b.spin);
}

template <class Visit>
void visit_settings(RandomPart& p, Visit&& visit) {
    visit("half", p.half);
    visit("radius", p.radius);
    visit("half_segment", p.half_segment);
    visit("points", p.points);
    visit("at", p.at);
    visit("turn", p.turn);
}

template <class Visit>
void visit_settings(RandomJoint& j, Visit&& visit) {
    visit("a", j.a);
    visit("b", j.b);
    visit("anchor", j.def.anchor);
    visit("anchor_b", j.def.anchor_b);
    visit("axis", j.def.axis);
    visit("length", j.def.length_m);
    visit("spring_hz", j.def.spring_hz);
    visit("damping_ratio", j.def.spring_damping_ratio);
    visit("limited", j.def.limited);
    visit("lower", j.def.lower);
    visit("upper", j.def.upper);
    visit("motor", j.def.motor);
    visit("motor_speed", j.def.motor_speed);
    visit("motor_max", j.def.motor_max);
    visit("break_force", j.def.break_force_n);
    visit("collide", j.def.collide);
}

template <class Number>
std::string number_text(Number value) {
    std::array<char, 48> digits{};
    char* end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    return " " + std::string(digits.data(), end);
}

std::string value_text(float value) {
    return number_text(value);
}

std::string value_text(int value) {
    return number_text(value);
}

std::string value_text(std::uint64_t value) {
    return number_text(value);
}

std::string value_text(bool value) {
    return value ? " yes" : " no";
}

std::string value_text(const Vec3& v) {
    return value_text(v.x()) + value_text(v.y()) + value_text(v.z());
}

/// The real part comes first.
std::string value_text(const Quat& q) {
    return value_text(q.w()) + value_text(q.x()) + value_text(q.y()) + value_text(q.z());
}

std::string value_text(const std::vector<Vec3>& points) {
    std::string text = value_text(static_cast<int>(points.size()));
    for (const Vec3& p : points) {
        text += value_text(p);
    }
    return text;
}

/// The settings of a record that differ from a fresh one's.
template <class Record>
std::string settings_text(Record record) {
    std::vector<std::string> fresh_values;
    Record fresh;
    visit_settings(
        fresh, [&](std::string_view, auto& value) { fresh_values.push_back(value_text(value)); });
    std::string text;
    std::size_t i = 0;
    visit_settings(record, [&](std::string_view name, auto& value) {
        const std::string mine = value_text(value);
        text += mine == fresh_values[i++] ? "" : " " + std::string(name) + mine;
    });
    return text;
}

/// The words of one line, taken one after the other. The first error stays.
class WordReader {
  public:
    explicit WordReader(std::string_view line) : rest_(line.substr(0, line.find('#'))) {}

    /// Empty at the end.
    std::string_view next() {
        const auto blank = [](char c) {
            return c == ' ' || c == '\t' || c == '\r';
        };
        while (!rest_.empty() && blank(rest_.front())) {
            rest_.remove_prefix(1);
        }
        std::size_t size = 0;
        while (size < rest_.size() && !blank(rest_[size])) {
            ++size;
        }
        const std::string_view word = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return word;
    }

    void fail(std::string reason) {
        if (error.empty()) {
            error = std::move(reason);
        }
    }

    template <class Number>
    void number(std::string_view name, Number& out) {
        const std::string_view word = next();
        Number value{};
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (word.empty() || code != std::errc() || end != word.data() + word.size()) {
            fail(quoted(name) + " needs a number, not " + quoted(word));
            return;
        }
        out = value;
    }

    void take(std::string_view name, float& out) {
        number(name, out);
        if (!std::isfinite(out) && name != "break_force") {
            fail(quoted(name) + " is not finite");
        }
    }

    void take(std::string_view name, int& out) { number(name, out); }

    void take(std::string_view name, std::uint64_t& out) { number(name, out); }

    void take(std::string_view name, bool& out) {
        const std::string_view word = next();
        if (word != "yes" && word != "no") {
            fail(quoted(name) + " is yes or no, not " + quoted(word));
        }
        out = word == "yes";
    }

    void take(std::string_view name, Vec3& out) {
        for (int i = 0; i < 3; ++i) {
            take(name, out[i]);
        }
    }

    void take(std::string_view name, Quat& out) {
        for (float* part : {&out.w(), &out.x(), &out.y(), &out.z()}) {
            take(name, *part);
        }
    }

    void take(std::string_view name, std::vector<Vec3>& out) {
        int count = 0;
        take(name, count);
        if (count < 0 || count > physics::kMaxHullVertices) {
            fail("a hull has 4 to 64 points");
            return;
        }
        out.assign(static_cast<std::size_t>(count), Vec3::Zero());
        for (Vec3& p : out) {
            take(name, p);
        }
    }

    template <class Kind, std::size_t kCount>
    void kind(const Kinds<Kind, kCount>& kinds, Kind& out) {
        const std::string_view word = next();
        for (const auto& [name, value] : kinds) {
            if (name == word) {
                out = value;
                return;
            }
        }
        fail("unknown kind " + quoted(word));
    }

    /// All settings up to the end of the line.
    template <class Record>
    void settings(Record& record) {
        std::set<std::string_view> seen;
        for (std::string_view word = next(); !word.empty() && error.empty(); word = next()) {
            if (!seen.insert(word).second) {
                fail(quoted(word) + " is given twice");
                return;
            }
            bool known = false;
            visit_settings(record, [&](std::string_view name, auto& value) {
                if (name == word) {
                    known = true;
                    take(name, value);
                }
            });
            if (!known) {
                fail("unknown word " + quoted(word));
            }
        }
    }

    std::string error;

  private:
    /// Bytes from outside, short and printable.
    static std::string quoted(std::string_view word) {
        std::string text;
        for (const char c : word.substr(0, 32)) {
            text += c > ' ' && c <= '~' ? c : '?';
        }
        return "'" + text + "'";
    }

    std::string_view rest_;
};

/// Reads a line into the scene; the reason where it cannot.
std::string read_line(std::string_view line,
                      bool first,
                      std::set<std::string>& once,
                      RandomScene& scene) {
    WordReader words(line);
    const std::string_view name = words.next();
    if (first) {
        return name == "zoned-scene" && words.next() == "1" && words.next().empty()
                   ? ""
                   : "the first line is 'zoned-scene 1'";
    }
    if (name.empty()) {
        return {};
    }
    const bool single = name == "scene" || name == "ground" || name == "families";
    if (single && !once.insert(std::string(name)).second) {
        return "'" + std::string(name) + "' is given twice";
    }
    if (name == "scene") {
        words.settings(scene);
    } else if (name == "families") {
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            scene.families += (scene.families.empty() ? "" : " ") + std::string(word);
        }
    } else if (name == "ground") {
        words.kind(kGroundKinds, scene.ground.kind);
        words.settings(scene.ground);
    } else if (name == "body") {
        if (scene.bodies.size() >= kMostSceneBodies) {
            return "more than 4096 bodies";
        }
        scene.bodies.emplace_back();
        words.kind(kBodyKinds, scene.bodies.back().kind);
        words.settings(scene.bodies.back());
    } else if (name == "part") {
        if (scene.bodies.empty() || scene.bodies.back().parts.size() >= kMostSceneParts) {
            return scene.bodies.empty() ? "a part before the first body" : "more than 64 parts";
        }
        RandomPart part;
        words.kind(kPartKinds, part.kind);
        words.settings(part);
        scene.bodies.back().parts.push_back(std::move(part));
    } else if (name == "joint") {
        if (scene.joints.size() >= kMostSceneJoints) {
            return "more than 4096 joints";
        }
        scene.joints.emplace_back();
        words.kind(kJointKinds, scene.joints.back().def.kind);
        words.settings(scene.joints.back());
    } else {
        return "a line begins with scene, families, ground, body, part or joint";
    }
    return words.error;
}

}  // namespace

std::string scene_to_text(const RandomScene& scene) {
    std::string text = "zoned-scene 1\n";
    text += scene.families.empty() ? "" : "families " + scene.families + "\n";
    text += "scene" + settings_text(scene) + "\n";
    if (scene.ground != RandomGround()) {
        text += "ground " + name_of(kGroundKinds, scene.ground.kind) + settings_text(scene.ground) +
                "\n";
    }
    for (const RandomBody& body : scene.bodies) {
        text += "body " + name_of(kBodyKinds, body.kind) + settings_text(body) + "\n";
        for (const RandomPart& part : body.parts) {
            text += "part " + name_of(kPartKinds, part.kind) + settings_text(part) + "\n";
        }
    }
    for (const RandomJoint& joint : scene.joints) {
        text += "joint " + name_of(kJointKinds, joint.def.kind) + settings_text(joint) + "\n";
    }
    return text;
}

core::Result<RandomScene> scene_from_text(std::string_view text) {
    using Refused = core::Result<RandomScene>;
    if (text.size() > kMostSceneTextBytes) {
        return Refused::failure("a scene file has at most 4 MiB");
    }
    RandomScene scene;
    std::set<std::string> once;
    std::size_t line = 0;
    while (!text.empty() || line == 0) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string reason = read_line(text.substr(0, end), line == 0, once, scene);
        ++line;
        if (!reason.empty()) {
            return Refused::failure("line " + std::to_string(line) + ": " + reason);
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].parts.empty()) {
            return Refused::failure("body " + std::to_string(i) + " has no part");
        }
    }
    return scene;
}

}  // namespace zoned::stability
