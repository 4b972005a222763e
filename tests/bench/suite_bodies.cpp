// Suite `bodies`: the cost of a body with diagonal or full inertia tensor, of particles beside
// rigid bodies, and of rays in given or sorted order.
#include "server/physics/scene/scene.h"
#include "server/spatial/morton.h"
#include "tests/bench/comparison.h"
#include "tests/bench/statistics.h"
#include "tests/scenario/ray.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

constexpr double kG = 9.81;

using physics::BodyDef;
using physics::BodyKind;
using physics::Shape;

BodyId add(physics::Scene& scene, const BodyDef& def) {
    const auto id = scene.add(def);
    if (!id) {
        throw std::runtime_error("our engine refused a body: " + id.error());
    }
    return *id;
}

physics::PhysicsSettings awake(float gravity) {
    physics::PhysicsSettings settings;
    settings.gravity = Vec3(0.0F, -gravity, 0.0F);
    settings.sleep_after_s = 0.0F;
    return settings;
}

Vec3 any_vector(core::Rng& rng, float most) {
    const float x = rng.range(-most, most);
    const float y = rng.range(-most, most);
    const float z = rng.range(-most, most);
    return {x, y, z};
}

/// The inertia of the spinning bodies.
enum class Inertia : std::uint8_t {
    kRound,     ///< all moments equal
    kDiagonal,  ///< those of a box, about its own axes
    kFull,      ///< the same with products of a hundredth: the principal axes lean a little
};

/// Boxes that spin, free of weight and of each other, or that lie on the ground, pushed about by
/// their spin at first. In free flight the error is the largest relative change of a body's angular
/// momentum, where only rounding is allowed. On the ground it is how deep the lowest centre lies
/// below its rest height, m.
class SpinTrial : public JudgedTrial {
  public:
    SpinTrial(Inertia inertia, bool on_ground, int count)
        : scene_(awake(on_ground ? static_cast<float>(kG) : 0.0F)),
          on_ground_(on_ground) {
        core::Rng rng(3);
        if (on_ground) {
            BodyDef ground;
            ground.kind = BodyKind::kStatic;
            ground.shape = Shape::plane();
            add(scene_, ground);
        }
        const Vec3 half =
            inertia == Inertia::kRound ? Vec3(Vec3::Constant(0.3F)) : Vec3(0.4F, 0.25F, 0.3F);
        moments_ = (Vec3(half.y() * half.y() + half.z() * half.z(),
                         half.x() * half.x() + half.z() * half.z(),
                         half.x() * half.x() + half.y() * half.y()) /
                    3.0F)
                       .asDiagonal();
        if (inertia == Inertia::kFull) {
            const float product = 0.01F * moments_.diagonal().minCoeff();
            moments_ += product * (Mat3::Ones() - Mat3::Identity());
        }
        const int side = static_cast<int>(std::ceil(std::sqrt(count)));
        for (int i = 0; i < count; ++i) {
            BodyDef def;
            def.shape = Shape::box(half);
            def.position = Vec3(2.0F * static_cast<float>(i % side),
                                on_ground ? half.y() : 0.0F,
                                2.0F * static_cast<float>(i / side));
            if (inertia == Inertia::kFull) {
                def.inertia = moments_;
            }
            def.angular_velocity =
                on_ground ? Vec3(0.0F, rng.range(-3.0F, 3.0F), 0.0F) : any_vector(rng, 3.0F);
            lowest_ = std::min(half.y(), lowest_);
            ids_.push_back(add(scene_, def));
            before_.push_back(momentum(ids_.back()));
        }
    }

    void frame() override { scene_.step(kStepTime); }

    void judge(Row& row) override {
        double worst = 0.0;
        for (std::size_t i = 0; i < ids_.size(); ++i) {
            const double change = (momentum(ids_[i]) - before_[i]).norm() / before_[i].norm();
            const auto y = static_cast<double>(scene_.state(ids_[i]).position.y());
            worst = std::max(worst, on_ground_ ? static_cast<double>(lowest_) - y : change);
        }
        row.error = worst;
        row.error_unit = std::string(on_ground_ ? "m" : "share");
    }

  private:
    [[nodiscard]] Vec3d momentum(BodyId id) const {
        const physics::BodyState s = scene_.state(id);
        const Eigen::Matrix3d turned = s.orientation.cast<double>().normalized().toRotationMatrix();
        return turned * moments_.cast<double>() * turned.transpose() *
               s.angular_velocity.cast<double>();
    }

    physics::Scene scene_;
    bool on_ground_;
    Mat3 moments_ = Mat3::Identity();
    float lowest_ = INFINITY;
    std::vector<BodyId> ids_;
    std::vector<Vec3d> before_;
};

/// Points or small balls that fall from 1 to 11 m onto a plane and stay there, awake. Error: the
/// largest difference of a height from max(h - g t^2 / 2, rest) in any frame, m.
class FallTrial : public JudgedTrial {
  public:
    FallTrial(BodyKind kind, int count)
        : scene_(awake(static_cast<float>(kG))),
          rest_(kind == BodyKind::kParticle ? 0.0 : static_cast<double>(kRadius)) {
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::plane();
        add(scene_, ground);
        core::Rng rng(4);
        const int side = static_cast<int>(std::ceil(std::sqrt(count)));
        for (int i = 0; i < count; ++i) {
            BodyDef def;
            def.kind = kind;
            def.shape = Shape::sphere(kRadius);
            def.position = Vec3(0.5F * static_cast<float>(i % side - side / 2),
                                rng.range(1.0F, 11.0F),
                                0.5F * static_cast<float>(i / side - side / 2));
            heights_.push_back(static_cast<double>(def.position.y()));
            ids_.push_back(add(scene_, def));
        }
    }

    void frame() override {
        scene_.step(kStepTime);
        ++frames_;
    }

    void observe() override {
        const double t = static_cast<double>(frames_) * static_cast<double>(kStepTime);
        for (std::size_t i = 0; i < ids_.size(); ++i) {
            const double exact = std::max(heights_[i] - 0.5 * kG * t * t, rest_);
            const auto y = static_cast<double>(scene_.state(ids_[i]).position.y());
            (exact > rest_ ? flying_ : landed_) =
                std::max(exact > rest_ ? flying_ : landed_, std::abs(y - exact));
        }
    }

    void judge(Row& row) override {
        row.error = std::max(flying_, landed_);
        row.error_unit = std::string("m");
        row.metric("error_flying_m_max", flying_);
        row.metric("error_landed_m_max", landed_);
    }

  private:
    static constexpr float kRadius = 0.1F;
    physics::Scene scene_;
    double rest_;
    std::vector<double> heights_;
    std::vector<BodyId> ids_;
    int frames_ = 0;
    double flying_ = 0.0;
    double landed_ = 0.0;
};

/// Boxes at random in a cube, 4 m apart in the mean, too many for any cache, and short rays from
/// everywhere. The exact distances are computed for the first rays only.
struct RayWorld {
    physics::Scene scene{physics::PhysicsSettings()};
    std::vector<physics::Ray> rays;
    std::vector<double> exact;
    Aabb box;

    RayWorld(int bodies, int count) {
        core::Rng rng(6);
        const float side = 4.0F * std::cbrt(static_cast<float>(bodies));
        box = {Vec3::Zero(), Vec3::Constant(side)};
        std::vector<scenario::Body> solids;
        const auto point = [&] {
            return Vec3(Vec3::Constant(0.5F * side) + any_vector(rng, 0.5F * side));
        };
        for (int i = 0; i < bodies; ++i) {
            BodyDef def;
            def.kind = BodyKind::kStatic;
            def.shape = Shape::box(Vec3::Constant(0.2F) + any_vector(rng, 0.8F).cwiseAbs());
            def.position = point();
            def.orientation =
                Quat(Eigen::AngleAxisf(rng.range(0.0F, 3.0F), any_vector(rng, 1.0F).normalized()));
            add(scene, def);
            scenario::Body solid;
            solid.solid = scenario::Solid::box(2.0 * def.shape.half_extents.cast<double>());
            solid.mass = 0.0;
            solid.pose = {def.position.cast<double>(), def.orientation.cast<double>().normalized()};
            solids.push_back(solid);
        }
        for (int i = 0; i < count; ++i) {
            rays.push_back({point(), any_vector(rng, 1.0F).normalized(), 30.0F});
        }
        for (std::size_t i = 0; i < 32; ++i) {
            const physics::Ray& ray = rays[i];
            exact.push_back(scenario::ray_distance({ray.origin.cast<double>(),
                                                    ray.direction.cast<double>().normalized(),
                                                    static_cast<double>(ray.max_distance)},
                                                   solids));
        }
    }
};

enum class Order : std::uint8_t {
    kBatch,   ///< Query::rays
    kGiven,   ///< one by one
    kSorted,  ///< by the Morton code of the origin; sorting and putting back are timed
};

class RayTrial : public JudgedTrial {
  public:
    RayTrial(const RayWorld& world, Order order, std::size_t chunk)
        : world_(world),
          order_(order),
          chunk_(chunk),
          hits_(world.rays.size()) {}

    void frame() override {
        const physics::Query query = world_.scene.query();
        if (order_ == Order::kBatch) {
            query.rays(world_.rays, {}, hits_);
            return;
        }
        for (std::size_t from = 0; from < hits_.size(); from += chunk_) {
            cast(query, from, std::min(from + chunk_, hits_.size()));
        }
    }

    void judge(Row& row) override {
        std::size_t other = 0;
        std::size_t found = 0;
        for (std::size_t i = 0; i < hits_.size(); ++i) {
            physics::QueryHit hit;
            const bool there = world_.scene.query().ray(world_.rays[i], {}, hit);
            found += there ? 1 : 0;
            other += hits_[i].body != (there ? hit.body : BodyId()) ? 1 : 0;
        }
        double worst = 0.0;
        for (std::size_t i = 0; i < world_.exact.size(); ++i) {
            const bool hit = static_cast<bool>(hits_[i].body);
            if (hit != std::isfinite(world_.exact[i])) {
                ++other;
            } else if (hit) {
                worst = std::max(
                    worst, std::abs(static_cast<double>(hits_[i].distance) - world_.exact[i]));
            }
        }
        row.error = worst;
        row.error_unit = std::string("m");
        row.metric("rays_of_other_answer", static_cast<double>(other));
        row.metric("hit_share", static_cast<double>(found) / static_cast<double>(hits_.size()));
    }

  private:
    void cast(const physics::Query& query, std::size_t from, std::size_t to) {
        order_of_.resize(to - from);
        for (std::size_t i = from; i < to; ++i) {
            const std::uint64_t code = order_ == Order::kSorted
                                           ? spatial::morton_code(world_.rays[i].origin, world_.box)
                                           : 0;
            order_of_[i - from] = (code << 32) | i;
        }
        if (order_ == Order::kSorted) {
            std::sort(order_of_.begin(), order_of_.end());
        }
        for (const std::uint64_t key : order_of_) {
            const std::size_t i = key & 0xFFFFFFFFU;
            if (!query.ray(world_.rays[i], {}, hits_[i])) {
                hits_[i] = physics::QueryHit();
            }
        }
    }

    const RayWorld& world_;
    Order order_;
    std::size_t chunk_;
    std::vector<physics::QueryHit> hits_;
    std::vector<std::uint64_t> order_of_;
};

/// Times the requested methods and reports the cost of one of `count` items.
void add_rows(Session& session,
              const std::string& scene,
              const std::string& parameter,
              std::vector<Method> methods,
              int count,
              const std::string& thing,
              const Plan& plan) {
    session.progress("bodies " + scene + " " + parameter);
    methods = wanted(session, std::move(methods));
    std::vector<Row> rows = compare("bodies", scene, parameter, methods, plan);
    for (Row& row : rows) {
        row.metric("ns_per_" + thing, 1e3 * row.time_us_p50 / count);
        if (thing == "ray") {
            row.metric("rays_per_s", 1e6 * count / row.time_us_p50);
        }
    }
    session.add(std::move(rows));
}

void run_spin(Session& session) {
    const int count = 1000;
    const Plan plan{10, session.quick ? 10 : 240, session.quick ? 1 : session.repeats};
    for (const bool on_ground : {false, true}) {
        const auto method = [&](const char* name, Inertia inertia) {
            return Method{name, "", [=] {
                              return std::make_unique<SpinTrial>(inertia, on_ground, count);
                          }};
        };
        add_rows(session,
                 "spin",
                 on_ground ? "on the ground" : "free",
                 {method("default", Inertia::kDiagonal),
                  method("full_tensor", Inertia::kFull),
                  method("round", Inertia::kRound)},
                 count,
                 "body",
                 plan);
    }
}

void run_fall(Session& session) {
    const int count = session.quick ? 1000 : 10'000;
    const Plan plan{0, session.quick ? 40 : 100, session.quick ? 1 : session.repeats};
    const auto method = [&](const char* name, BodyKind kind) {
        return Method{name, "", [=] {
                          return std::make_unique<FallTrial>(kind, count);
                      }};
    };
    add_rows(session,
             "fall",
             "n=" + std::to_string(count),
             {method("default", BodyKind::kDynamic), method("particle", BodyKind::kParticle)},
             count,
             "body",
             plan);
}

void cast_rays(Session& session, int count, int bodies) {
    const RayWorld world(bodies, count);
    const Plan plan{0, session.quick ? 2 : 5, session.quick ? 1 : session.repeats};
    const auto method = [&](const char* name, Order order, std::size_t chunk) {
        return Method{name, "", [&world, order, chunk] {
                          return std::make_unique<RayTrial>(world, order, chunk);
                      }};
    };
    const auto all = static_cast<std::size_t>(count);
    add_rows(session,
             "rays",
             std::to_string(count) + " in " + std::to_string(bodies) + " boxes",
             {method("default", Order::kBatch, all),
              method("one_by_one", Order::kGiven, all),
              method("sorted", Order::kSorted, all),
              method("sorted_1000", Order::kSorted, 1000)},
             count,
             "ray",
             plan);
}

void run_rays(Session& session) {
    if (session.quick) {
        cast_rays(session, 5000, 20'000);
        return;
    }
    for (const int bodies : {2'000, 20'000, 70'000, 300'000}) {
        for (const int count : {10'000, 100'000}) {
            cast_rays(session, count, bodies);
        }
    }
}

void run_bodies(Session& session) {
    session.note("bodies: one thread; a frame is a step of 1/60 s, or a batch of rays");
    if (session.wants_scene("spin")) {
        run_spin(session);
    }
    if (session.wants_scene("fall")) {
        run_fall(session);
    }
    if (session.wants_scene("rays")) {
        run_rays(session);
    }
}

const Registration kBodies(
    {"bodies",
     "what a body and a ray cost: tensors, particles, order of rays",
     {"spin", "fall", "rays"},
     {"default", "full_tensor", "round", "particle", "one_by_one", "sorted", "sorted_1000"},
     run_bodies});

}  // namespace

}  // namespace zoned::bench
