// Suite `queries`: rays per second through resting bodies, our engine beside Bullet.
#include "tests/bench/comparison.h"
#include "tests/bench/simulator.h"
#include "tests/bench/statistics.h"
#include "tests/scenario/penetration.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace zoned::bench {

namespace {

/// Rays of a frame, and different frames before rays come again.
constexpr std::size_t kRays = 1000;
constexpr std::size_t kBatches = 5;

/// Random rays; the same seed gives the same rays.
class RaySource {
  public:
    explicit RaySource(std::uint64_t seed) : rng_(seed) {}

    double between(double lower, double upper) {
        return lower + (upper - lower) * static_cast<double>(rng_.unit());
    }

    Vec3d point(const Vec3d& lower, const Vec3d& upper) {
        const double x = between(lower.x(), upper.x());
        const double y = between(lower.y(), upper.y());
        const double z = between(lower.z(), upper.z());
        return {x, y, z};
    }

    /// Uniform on the sphere.
    Vec3d direction() {
        const double y = between(-1.0, 1.0);
        const double turn = between(0.0, 2.0 * std::numbers::pi);
        const double r = std::sqrt(std::max(0.0, 1.0 - y * y));
        return {r * std::cos(turn), y, r * std::sin(turn)};
    }

  private:
    core::Rng rng_;
};

/// Rays start mostly in the empty space around a scene.
bool inside_a_solid(const Vec3d& point, const scenario::Description& d) {
    return scenario::ray_distance({point, Vec3d::UnitY(), 1e-9}, d.bodies) == 0.0;
}

/// From above into the pit: every ray ends on the pile.
scenario::Ray pile_far(RaySource& source) {
    const Vec3d from = source.point({-11.0, 15.0, -11.0}, {11.0, 35.0, 11.0});
    const Vec3d to = source.point({-11.0, 0.0, -11.0}, {11.0, 0.0, 11.0});
    return {from, (to - from).normalized(), 60.0};
}

/// Short looks around from within the pile.
scenario::Ray pile_near(RaySource& source) {
    const Vec3d from = source.point({-11.0, 0.5, -11.0}, {11.0, 6.0, 11.0});
    return {from, source.direction(), 3.0};
}

/// Lines of sight over a field, almost level.
scenario::Ray field_far(RaySource& source) {
    const Vec3d from = source.point({-90.0, 0.5, -90.0}, {90.0, 2.5, 90.0});
    const Vec3d flat = source.direction();
    return {from, Vec3d(flat.x(), 0.02 * flat.y(), flat.z()).normalized(), 100.0};
}

scenario::Ray field_near(RaySource& source) {
    const Vec3d from = source.point({-90.0, 0.2, -90.0}, {90.0, 2.0, 90.0});
    return {from, source.direction(), 5.0};
}

struct QueryScene {
    std::string name;
    std::string parameter;
    scenario::Ray (*ray)(RaySource&);
};

const std::vector<QueryScene>& query_scenes() {
    static const std::vector<QueryScene> scenes{{"pile", "far", pile_far},
                                                {"pile", "near", pile_near},
                                                {"field", "far", field_far},
                                                {"field", "near", field_near}};
    return scenes;
}

/// The pile of S3 after it came to rest in our engine.
scenario::Description settled_pile(bool quick) {
    scenario::Description d = scenario::pile(quick ? 8 : 16);
    const auto simulator = zoned_engines().front().build(d);
    for (int step = 0; step < (quick ? 120 : 240); ++step) {
        simulator->step();
    }
    for (std::size_t i = 0; i < d.bodies.size(); ++i) {
        const Motion m = simulator->motion(i);
        d.bodies[i].pose = m.pose;
        d.bodies[i].velocity = Vec3d::Zero();
        d.bodies[i].spin = Vec3d::Zero();
    }
    return d;
}

/// Boxes of mixed size, turned about the vertical, on the ground about 2 m apart.
scenario::Description field() {
    scenario::Description d = scenario::resting_field(100);
    RaySource source(5);
    for (scenario::Body& body : d.bodies) {
        if (body.mass > 0.0) {
            const Vec3d size = source.point({0.3, 0.3, 0.3}, {1.2, 2.5, 1.2});
            body.solid = scenario::Solid::box(size);
            body.pose.position.y() = 0.5 * size.y();
            const double turn = source.between(0.0, std::numbers::pi);
            body.pose.orientation = Eigen::AngleAxisd(turn, Vec3d::UnitY());
        }
    }
    return d;
}

/// Rays that start outside all bodies, and where they end by the exact judge.
struct RaySet {
    std::vector<scenario::Ray> rays;
    std::vector<double> exact;
};

RaySet make_rays(const QueryScene& scene, const scenario::Description& d, bool quick) {
    RaySet set;
    RaySource source(17);
    const std::size_t wanted = quick ? kRays : kRays * kBatches;
    while (set.rays.size() < wanted) {
        const scenario::Ray ray = scene.ray(source);
        if (!inside_a_solid(ray.origin, d)) {
            set.rays.push_back(ray);
            set.exact.push_back(scenario::ray_distance(ray, d.bodies));
        }
    }
    return set;
}

class QueryTrial : public JudgedTrial {
  public:
    QueryTrial(const Engine& engine, const scenario::Description& d, const RaySet& set)
        : simulator_(engine.build(d)),
          set_(set),
          bodies_(d.bodies.size()),
          found_(set.rays.size()) {
        simulator_->prepare_queries();
    }

    void frame() override {
        const std::size_t from = batch_ * kRays;
        simulator_->cast(std::span(set_.rays).subspan(from, kRays),
                         std::span(found_).subspan(from, kRays));
        batch_ = (batch_ + 1) % (found_.size() / kRays);
    }

    void judge(Row& row) override {
        std::vector<double> differences;
        int disagreeing = 0;
        int off = 0;
        int hits = 0;
        for (std::size_t i = 0; i < found_.size(); ++i) {
            hits += std::isfinite(set_.exact[i]) ? 1 : 0;
            if (std::isfinite(found_[i]) != std::isfinite(set_.exact[i])) {
                ++disagreeing;
            } else if (std::isfinite(found_[i])) {
                differences.push_back(std::abs(found_[i] - set_.exact[i]));
                off += differences.back() > 1e-3 ? 1 : 0;
            }
        }
        row.error = quantile(differences, 0.99);
        row.error_unit = std::string("m");  // g++ 12 warns of the plain literal without cause
        row.metric("error_m_p50", median(differences));
        row.metric("error_m_max", largest(differences));
        row.metric("rays_off_by_1mm", off);
        row.metric("rays_of_other_answer", disagreeing);
        row.metric("bodies", static_cast<double>(bodies_));
        row.metric("hit_share", static_cast<double>(hits) / static_cast<double>(found_.size()));
    }

  private:
    std::unique_ptr<Simulator> simulator_;
    const RaySet& set_;
    std::size_t bodies_;
    std::vector<double> found_;
    std::size_t batch_ = 0;
};

std::vector<Engine> query_engines() {
    std::vector<Engine> engines{zoned_engines().front()};
    for (const Engine& peer : bullet_query_engines()) {
        engines.push_back(peer);
    }
    return engines;
}

void run_scene(Session& session, const QueryScene& scene, const scenario::Description& d) {
    session.progress("queries " + scene.name + " " + scene.parameter);
    const RaySet set = make_rays(scene, d, session.quick);
    std::vector<Method> methods;
    for (const Engine& engine : query_engines()) {
        methods.push_back({engine.method, engine.peer, [engine, &d, &set] {
                               return std::make_unique<QueryTrial>(engine, d, set);
                           }});
    }
    methods = wanted(session, std::move(methods));
    const Plan plan{0, session.quick ? 5 : 60, session.quick ? 1 : session.repeats};
    std::vector<Row> rows = compare("queries", scene.name, scene.parameter, methods, plan);
    for (Row& row : rows) {
        row.metric("rays_per_s", 1e6 * static_cast<double>(kRays) / row.time_us_p50);
    }
    session.add(std::move(rows));
}

void run_scenes(Session& session, const std::string& name, const scenario::Description& d) {
    for (const QueryScene& scene : query_scenes()) {
        if (scene.name == name) {
            run_scene(session, scene, d);
        }
    }
}

void run_queries(Session& session) {
    session.note("queries: a frame is 1000 rays, each to its nearest hit");
    if (session.wants_scene("pile")) {
        run_scenes(session, "pile", settled_pile(session.quick));
    }
    if (session.wants_scene("field")) {
        run_scenes(session, "field", field());
    }
}

const Registration kQueries({"queries",
                             "rays through resting bodies: time against exactness",
                             {"pile", "field"},
                             {"default", "bullet/default", "bullet/gjk"},
                             run_queries});

}  // namespace

}  // namespace zoned::bench
