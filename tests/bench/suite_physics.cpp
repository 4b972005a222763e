// Suite `physics`: rigid-body scenes, our engine beside its peers.
#include "tests/bench/physics_meters.h"
#include "tests/bench/simulator.h"
#include "tests/bench/suite.h"
#include "tests/bench/timing.h"

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

/// `quick`: a smaller field of sleepers, which takes long to fall asleep.
std::vector<PhysicsScene> physics_scenes(bool quick) {
    using namespace scenario;
    std::vector<PhysicsScene> s;
    s.push_back({"S1", "", pyramid(), drift_meter, 60});
    s.push_back({"S2", "", column(20, 1.0), drift_meter, 120});
    s.push_back({"S2x100", "", column(5, 100.0), column_meter, 120});
    s.push_back({"S2x1000", "", column(5, 1000.0), column_meter, 120});
    s.push_back({"S3", "", pile(16), pile_meter, 20});
    // Bullet lets bodies sleep after two seconds at the earliest: timing starts after three.
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
class PhysicsTrial : public Trial {
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

    void finish(Row& row) {
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

std::string full_name(const Engine& engine) {
    return engine.peer.empty() ? engine.method : engine.peer + "/" + engine.method;
}

/// The engines that run the scene in this session.
std::vector<Engine> chosen(Session& session, const PhysicsScene& scene) {
    std::vector<Engine> engines;
    for (const Engine& engine : all_engines()) {
        if (!session.wants_method(engine.method, engine.peer)) {
            continue;
        }
        const std::string why = engine.refusal(scene.name, scene.description);
        if (why.empty()) {
            engines.push_back(engine);
        } else if (engine.method == "default" || engine.method == "exact") {
            session.note(scene.name + " " + full_name(engine) + ": skipped, " + why);
        }
    }
    return engines;
}

Contender contender(const Engine& engine, const PhysicsScene& scene) {
    return {full_name(engine), [&engine, &scene]() {
                return std::make_unique<PhysicsTrial>(engine, scene);
            }};
}

/// Ratios of this scene's rows: to Bullet on the same scene, and to the yardstick Y.
void add_ratios(std::vector<Row>& rows, const std::vector<Timing>& timings, double yardstick_us) {
    const auto bullet = std::find_if(rows.begin(), rows.end(), [](const Row& row) {
        return row.peer == "bullet" && row.method == "default";
    });
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (bullet != rows.end() && bullet->time_us_p50 > 0.0) {
            const Timing& theirs = timings[static_cast<std::size_t>(bullet - rows.begin())];
            rows[i].metric("bullet_ratio", rows[i].time_us_p50 / bullet->time_us_p50);
            rows[i].metric("bullet_ratio_of_means", timings[i].mean_us / theirs.mean_us);
        }
        if (yardstick_us > 0.0) {
            rows[i].metric("y_ratio", rows[i].time_us_p50 / yardstick_us);
        }
    }
}

/// Y: the time of Bullet's default on S1, taken beside each scene, so that a machine that slows
/// down slows both.
class Yardstick {
  public:
    Yardstick() : scene_(physics_scenes(true).front()), engine_(bullet_engines().front()) {}

    /// Microseconds of a frame.
    double measure(const Session& session) {
        const Contender yardstick = contender(engine_, scene_);
        const Plan plan{0, session.quick ? 30 : 200, session.quick ? 1 : session.repeats};
        return time_interleaved({&yardstick, 1}, plan, [](std::size_t, Trial&) {}).front().p50_us;
    }

  private:
    PhysicsScene scene_;
    Engine engine_;
};

void run_scene(Session& session, const PhysicsScene& scene, Yardstick& yardstick) {
    const std::vector<Engine> engines = chosen(session, scene);
    if (engines.empty()) {
        return;
    }
    session.progress("physics " + scene.name + " " + scene.parameter);
    std::vector<Contender> contenders;
    std::vector<Row> rows(engines.size());
    for (std::size_t i = 0; i < engines.size(); ++i) {
        contenders.push_back(contender(engines[i], scene));
        rows[i].suite = "physics";
        rows[i].scene = scene.name;
        rows[i].parameter = scene.parameter;
        rows[i].method = engines[i].method;
        rows[i].peer = engines[i].peer;
    }
    const int per_frame = static_cast<int>(std::lround(kFrame / scene.description.dt));
    const int steps = session.quick ? std::min(scene.quick_steps, scene.description.steps)
                                    : scene.description.steps;
    const Plan plan{
        scene.warm_up, steps / per_frame - scene.warm_up, session.quick ? 1 : session.repeats};
    const double before = yardstick.measure(session);
    const std::vector<Timing> timings =
        time_interleaved(contenders, plan, [&rows](std::size_t i, Trial& run) {
            static_cast<PhysicsTrial&>(run).finish(rows[i]);
        });
    const double yardstick_us = 0.5 * (before + yardstick.measure(session));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].time_us_p50 = timings[i].p50_us;
        rows[i].time_us_p99 = timings[i].p99_us;
        rows[i].metric("time_us_mean", timings[i].mean_us);
        rows[i].metric("frames", plan.frames);
    }
    add_ratios(rows, timings, yardstick_us);
    std::move(rows.begin(), rows.end(), std::back_inserter(session.results.rows));
}

void run(Session& session) {
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

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const PhysicsScene& scene : physics_scenes(true)) {
        if (names.empty() || names.back() != scene.name) {
            names.push_back(scene.name);
        }
    }
    return names;
}

std::vector<std::string> method_names() {
    std::vector<std::string> names;
    for (const Engine& engine : all_engines()) {
        names.push_back(full_name(engine));
    }
    return names;
}

const Registration kPhysics(
    {"physics", "rigid bodies: time of a step against error", scene_names(), method_names(), run});

}  // namespace

}  // namespace zoned::bench
