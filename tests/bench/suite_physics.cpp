// Suite `physics`: rigid-body scenes, our engine beside its peers.
#include "tests/bench/comparison.h"
#include "tests/bench/physics_meters.h"
#include "tests/bench/simulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::bench {

namespace {

struct PhysicsScene {
    std::string name;
    std::string parameter;
    scenario::Description description;
    std::unique_ptr<Meter> (*meter)(const scenario::Description&);
    int quick_steps;  ///< length of a quick run
    int warm_up = 0;  ///< frames before timing starts
};

constexpr double kFrame = 1.0 / 60.0;

/// `quick`: a smaller field of resting bodies, which take long to fall asleep.
std::vector<PhysicsScene> physics_scenes(bool quick) {
    using namespace scenario;
    std::vector<PhysicsScene> s;
    s.push_back({"S1", "", pyramid(), drift_meter, 60});
    s.push_back({"S2", "", column(20, 1.0), drift_meter, 120});
    s.push_back({"S2x100", "", column(5, 100.0), column_meter, 120});
    s.push_back({"S2x1000", "", column(5, 1000.0), column_meter, 120});
    s.push_back({"S3", "", pile(16), pile_meter, 20});
    // Bullet lets bodies sleep after two seconds at the earliest, so timing starts after three.
    s.push_back({"S4", "", resting_field(quick ? 30 : 100), drift_meter, 200, 180});
    s.push_back({"S5", "dt=1/60", bounce(1.0, 60.0, kFrame), last_apex_meter, 600});
    s.push_back({"S5", "dt=1/240", bounce(1.0, 60.0, kFrame / 4), last_apex_meter, 2400});
    s.push_back({"S5b", "dt=1/60", bounce(0.8, 20.0, kFrame), apexes_meter, 1200});
    s.push_back({"S5b", "dt=1/240", bounce(0.8, 20.0, kFrame / 4), apexes_meter, 4800});
    s.push_back({"S6a", "", incline(0.5, 3.0), slide_meter, 180});
    s.push_back({"S6b", "", incline(0.6, 10.0), creep_meter, 120});
    s.push_back({"S7", "", spin(), spin_meter, 600});
    s.push_back({"S8", "", chain(), chain_meter, 120});
    s.push_back({"S9", "", bullets(), bullets_meter, 60});
    return s;
}

/// One engine on one scene.
class PhysicsTrial : public JudgedTrial {
  public:
    PhysicsTrial(const Engine& engine, const PhysicsScene& scene)
        : simulator_(engine.build(scene.description)),
          meter_(scene.meter(scene.description)),
          steps_per_frame_(static_cast<int>(std::lround(kFrame / scene.description.dt))) {}

    void frame() override {
        for (int i = 0; i < steps_per_frame_; ++i) {
            simulator_->step();
        }
    }

    void observe() override { meter_->after_step(*simulator_); }

    void judge(Row& row) override {
        meter_->finish(*simulator_, row);
        row.state_hash = simulator_->state_hash();
    }

  private:
    std::unique_ptr<Simulator> simulator_;
    std::unique_ptr<Meter> meter_;
    int steps_per_frame_;
};

std::vector<Engine> all_engines() {
    std::vector<Engine> engines = zoned_engines();
    for (const auto& more : {bullet_engines(), ode_engines()}) {
        engines.insert(engines.end(), more.begin(), more.end());
    }
    return engines;
}

Method method_of(const Engine& engine, const PhysicsScene& scene) {
    return {engine.method, engine.peer, [engine, &scene] {
                return std::make_unique<PhysicsTrial>(engine, scene);
            }};
}

/// The methods that run the scene in this session.
std::vector<Method> chosen(Session& session, const PhysicsScene& scene) {
    std::vector<Method> methods;
    for (const Engine& engine : all_engines()) {
        if (!session.wants_method(engine.method, engine.peer)) {
            continue;
        }
        const std::string why = engine.refusal(scene.name, scene.description);
        if (why.empty()) {
            methods.push_back(method_of(engine, scene));
        } else if (engine.method == "default" || engine.method == "exact") {
            session.note(scene.name + " " + full_name(engine.method, engine.peer) + ": skipped, " +
                         why);
        }
    }
    return methods;
}

/// Y: the time of Bullet's default on S1. It is measured beside each scene, so that a slowing
/// machine slows both.
class Yardstick {
  public:
    Yardstick() : scene_(physics_scenes(true).front()) {}

    /// Microseconds of a frame.
    double measure(const Session& session) {
        const std::vector<Method> bullet{method_of(bullet_engines().front(), scene_)};
        const Plan plan{0, session.quick ? 30 : 200, session.quick ? 1 : session.repeats};
        return compare("", "", "", bullet, plan).front().time_us_p50;
    }

  private:
    PhysicsScene scene_;
};

/// The speedup of two threads over one, and whether the results agree.
void note_speedup(std::vector<Row>& rows) {
    const auto row_of = [&](const char* method) {
        return std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
            return row.peer.empty() && row.method == method;
        });
    };
    const auto one = row_of("default");
    const auto two = row_of("threads_2");
    if (one != rows.end() && two != rows.end()) {
        const double* const alone = one->find_metric("wall_us_p50");
        const double* const together = two->find_metric("wall_us_p50");
        two->metric("wall_speedup",
                    alone != nullptr && together != nullptr ? *alone / *together : 0.0);
        two->metric("same_hash", one->state_hash == two->state_hash ? 1.0 : 0.0);
    }
}

void run_scene(Session& session, const PhysicsScene& scene, Yardstick& yardstick) {
    const std::vector<Method> methods = chosen(session, scene);
    if (methods.empty()) {
        return;
    }
    session.progress("physics " + scene.name + " " + scene.parameter);
    const int per_frame = static_cast<int>(std::lround(kFrame / scene.description.dt));
    const int steps = session.quick ? std::min(scene.quick_steps, scene.description.steps)
                                    : scene.description.steps;
    const Plan plan{
        scene.warm_up, steps / per_frame - scene.warm_up, session.quick ? 1 : session.repeats};
    const double before = yardstick.measure(session);
    std::vector<Row> rows = compare("physics", scene.name, scene.parameter, methods, plan);
    const double yardstick_us = 0.5 * (before + yardstick.measure(session));
    for (Row& row : rows) {
        row.metric("y_ratio", row.time_us_p50 / yardstick_us);
    }
    note_speedup(rows);
    session.add(std::move(rows));
}

void run_physics(Session& session) {
    session.note(
        "y_ratio = time of a frame / that of bullet/default on S1, taken beside each scene");
    session.note(
        "bullet: Debian's build, float, baseline x86-64; ode: Debian's, double, baseline,"
        " level ground as a plane");
    Yardstick yardstick;
    for (const PhysicsScene& scene : physics_scenes(session.quick)) {
        if (session.wants_scene(scene.name)) {
            run_scene(session, scene, yardstick);
        }
    }
}

std::vector<std::string> physics_scenes() {
    std::vector<std::string> names;
    for (const PhysicsScene& scene : physics_scenes(true)) {
        if (names.empty() || names.back() != scene.name) {
            names.push_back(scene.name);
        }
    }
    return names;
}

std::vector<std::string> physics_methods() {
    std::vector<std::string> names;
    for (const Engine& engine : all_engines()) {
        names.push_back(full_name(engine.method, engine.peer));
    }
    return names;
}

const Registration kPhysics({"physics",
                             "rigid bodies: time of a step against error",
                             physics_scenes(),
                             physics_methods(),
                             run_physics});

}  // namespace

}  // namespace zoned::bench
