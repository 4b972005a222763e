// Suite `physics`: rigid-body scenes, our engine beside its peers.
#include "tests/bench/comparison.h"
#include "tests/bench/physics_scene_list.h"
#include "tests/bench/simulator.h"
#include "shared/core/state_hash.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::bench {

namespace {

constexpr double kFrameSeconds = 1.0 / 60.0;

/// Bytes that the program has taken of the heap.
double heap_in_use() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

int steps_per_frame(const scenario::Description& description) {
    return std::max(static_cast<int>(std::lround(kFrameSeconds / description.dt)), 1);
}

/// The cases of a row, described once for all engines.
struct DescribedScene {
    const PhysicsScene& scene;
    std::vector<scenario::Description> cases;

    explicit DescribedScene(const PhysicsScene& s) : scene(s) {
        for (const PhysicsCase& one : s.cases) {
            cases.push_back(one.describe());
        }
    }

    [[nodiscard]] const scenario::Description& first() const { return cases.front(); }
};

/// One engine on one row.
class PhysicsTrial : public JudgedTrial {
  public:
    PhysicsTrial(const Engine& engine, const DescribedScene& described)
        : described_(described),
          steps_per_frame_(steps_per_frame(described.first())) {
        for (const scenario::Description& description : described.cases) {
            const double before = heap_in_use();
            simulators_.push_back(engine.build(description));
            simulators_.back()->set_heap_bytes(heap_in_use() - before);
            meters_.push_back(described.scene.meter(description));
        }
    }

    void frame() override {
        for (const auto& simulator : simulators_) {
            for (int i = 0; i < steps_per_frame_; ++i) {
                simulator->step();
            }
        }
    }

    void observe() override {
        for (std::size_t i = 0; i < meters_.size(); ++i) {
            meters_[i]->after_step(*simulators_[i]);
        }
    }

    void judge(Row& row) override {
        if (meters_.size() == 1) {
            meters_.front()->finish(*simulators_.front(), row);
            row.state_hash = simulators_.front()->state_hash();
            return;
        }
        std::vector<Row> cases(meters_.size(), row);
        std::size_t worst = 0;
        const auto badness = [&cases](std::size_t i) {
            return std::isnan(cases[i].error) ? INFINITY : std::abs(cases[i].error);
        };
        for (std::size_t i = 0; i < meters_.size(); ++i) {
            meters_[i]->finish(*simulators_[i], cases[i]);
            worst = badness(i) > badness(worst) ? i : worst;
        }
        row = cases[worst];
        for (auto& [name, value] : row.metrics) {
            for (const Row& other : cases) {
                const bool largest = name.ends_with("_max") || name.starts_with("energy_gain");
                value = largest ? std::max(value, *other.find_metric(name)) : value;
            }
        }
        row.metric("worst_case", static_cast<double>(worst));
        core::StateHash hash;
        for (std::size_t i = 0; i < meters_.size(); ++i) {
            row.metric("error_" + described_.scene.cases[i].label, cases[i].error);
            add(simulators_[i]->state_hash(), hash);
        }
        row.state_hash = row.peer.empty() ? hash_text(hash) : "";
    }

  private:
    static void add(const std::string& text, core::StateHash& hash) {
        for (const char c : text) {
            hash.add(static_cast<std::uint32_t>(c));
        }
    }

    const DescribedScene& described_;
    std::vector<std::unique_ptr<Simulator>> simulators_;  // by case
    std::vector<std::unique_ptr<Meter>> meters_;
    int steps_per_frame_;
};

std::vector<Engine> all_engines() {
    std::vector<Engine> engines = zoned_engines();
    for (const auto& more : {bullet_engines(), ode_engines()}) {
        engines.insert(engines.end(), more.begin(), more.end());
    }
    return engines;
}

Method method_of(const Engine& engine, const DescribedScene& described) {
    return {engine.method, engine.peer, [engine, &described] {
                return std::make_unique<PhysicsTrial>(engine, described);
            }};
}

/// Runs without being asked for, also where a scene is not for all methods.
bool is_standard(const Engine& engine, const DescribedScene& described) {
    const bool large = described.first().bodies.size() > kSmallScene;
    return (engine.method == "default" && engine.peer != "ode") ||
           (engine.method == "threads_2" && large && described.scene.threads);
}

/// The methods that run the scene in this session.
std::vector<Method> chosen(Session& session, const DescribedScene& described) {
    const PhysicsScene& scene = described.scene;
    std::vector<Method> methods;
    for (const Engine& engine : all_engines()) {
        const bool asked = !session.methods.empty() || scene.variants;
        if (!session.wants_method(engine.method, engine.peer) ||
            (!asked && !is_standard(engine, described))) {
            continue;
        }
        const std::string why = engine.refusal(scene.name, described.first());
        if (why.empty()) {
            methods.push_back(method_of(engine, described));
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
    Yardstick() : scene_(physics_scenes(true).front()), described_(scene_) {}

    /// Microseconds of a frame.
    double measure(const Session& session) {
        const std::vector<Method> bullet{method_of(bullet_engines().front(), described_)};
        const Plan plan{0, session.quick ? 30 : 200, session.quick ? 1 : session.repeats};
        return compare("", "", "", bullet, plan).front().time_us_p50;
    }

  private:
    PhysicsScene scene_;
    DescribedScene described_;
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
    const DescribedScene described(scene);
    const std::vector<Method> methods = chosen(session, described);
    if (methods.empty()) {
        return;
    }
    session.progress("physics " + scene.name + " " + scene.parameter);
    const int most = described.first().steps;
    const int steps = session.quick ? std::min(scene.quick_steps, most) : most;
    const Plan plan{scene.warm_up,
                    steps / steps_per_frame(described.first()) - scene.warm_up,
                    session.quick ? 1 : session.repeats};
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

std::vector<std::string> names_of_scenes() {
    std::vector<std::string> names;
    for (const PhysicsScene& scene : physics_scenes(true)) {
        if (std::find(names.begin(), names.end(), scene.name) == names.end()) {
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
                             names_of_scenes(),
                             physics_methods(),
                             run_physics});

}  // namespace

}  // namespace zoned::bench
