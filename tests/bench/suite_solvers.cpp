// Suite `solvers`: the residual of the methods against passes and time, and the effects of
// stabilisation, row order and warm starts.
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/residual.h"
#include "tests/bench/comparison.h"
#include "tests/bench/statistics.h"
#include "tests/bench/zoned_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace zoned::bench {

namespace {

using physics::PhysicsSettings;
using physics::RowSystem;

struct Snapshot {
    std::string name;
    scenario::Description description;
    int settle;  ///< steps before it is taken
};

std::vector<Snapshot> snapshots(bool quick) {
    return {{"pyramid", scenario::pyramid(), quick ? 5 : 30},
            {"column", scenario::column(20, 1.0), quick ? 5 : 30},
            {"column_x100", scenario::column(5, 100.0), quick ? 5 : 30},
            {"column_x100000", scenario::column(5, 1.0e5), quick ? 5 : 30},
            {"pile", scenario::pile(quick ? 5 : 8), quick ? 90 : 150}};
}

std::vector<NamedMethod> row_methods() {
    std::vector<NamedMethod> methods = contact_methods();
    methods.resize(5);  // the methods that solve rows come first
    return methods;
}

/// The rows of a step after `settle` steps by conjugate gradients; `warm`: with the impulses of the
/// step before as the first guess.
RowSystem take(const Snapshot& snapshot, bool warm) {
    PhysicsSettings settings;
    settings.method = physics::SolverVariant::kConjugateGradient;
    settings.methods.iterations = 60;
    settings.methods.keep_problem = true;
    ZonedScene zoned = build_scene(snapshot.description, settings);
    for (int i = 0; i < snapshot.settle; ++i) {
        zoned.scene.step(zoned.dt);
    }
    RowSystem problem = *zoned.scene.problem();
    if (!warm) {
        for (std::size_t i = 0; i < problem.size(); ++i) {
            problem.push(i, -problem.lambda[i]);
            problem.lambda[i] = 0.0;
        }
    }
    return problem;
}

physics::IterationLimits limits_of(int passes) {
    physics::IterationLimits limits;
    limits.iterations = passes;
    limits.omega = 1.3;
    return limits;
}

/// One solve of so many passes, from the snapshot.
class SolveTrial : public JudgedTrial {
  public:
    SolveTrial(const RowSystem& problem, const NamedMethod& method, int passes)
        : problem_(problem),
          system_(problem),
          method_(method.method),
          passes_(passes) {}

    void frame() override {
        system_.bodies = problem_.bodies;
        system_.lambda = problem_.lambda;
        report_ = physics::solve_rows(method_, system_, limits_of(passes_));
    }

    void judge(Row& row) override {
        row.error = physics::residual(system_);
        row.error_unit = std::string("m/s");
        const bool exact = method_ == physics::SolverVariant::kDirect;
        row.metric("passes", exact ? report_.iterations : passes_);
        row.metric("rows", static_cast<double>(system_.size()));
        row.metric("start_residual_mps", physics::residual(problem_));
        row.metric("islands_exact", report_.direct);
        row.metric("islands_too_large", report_.too_large);
        row.metric("islands_unsolved", report_.unsolved);
    }

  private:
    const RowSystem& problem_;
    RowSystem system_;
    physics::SolverVariant method_;
    int passes_;
    physics::SolveReport report_;
};

std::vector<Row> curve(const Session& session,
                       const std::string& scene,
                       const RowSystem& problem,
                       const NamedMethod& method) {
    std::vector<Row> rows;
    std::vector<int> counts{1, 2, 5, 10, 20, 50, 100, 200, 500};
    if (session.quick) {
        counts = {1, 10, 50};
    }
    if (method.method == physics::SolverVariant::kDirect) {
        counts = {20};
    }
    const int frames = session.quick ? 1 : 5;
    for (const int passes : counts) {
        const std::vector<Method> one{{method.name, "", [&problem, method, passes] {
                                           return std::make_unique<SolveTrial>(
                                               problem, method, passes);
                                       }}};
        std::vector<Row> got = compare("solvers",
                                       scene,
                                       "passes=" + std::to_string(passes),
                                       one,
                                       {0, frames, session.quick ? 1 : session.repeats});
        rows.push_back(std::move(got.front()));
    }
    return rows;
}

void run_curves(Session& session) {
    for (const Snapshot& snapshot : snapshots(session.quick)) {
        if (!session.wants_scene(snapshot.name)) {
            continue;
        }
        for (const bool warm : {false, true}) {
            session.progress("solvers " + snapshot.name + (warm ? " warm" : " cold"));
            const RowSystem problem = take(snapshot, warm);
            for (const NamedMethod& method : row_methods()) {
                if (session.wants_method(method.name, "")) {
                    session.add(
                        curve(session, snapshot.name + (warm ? "_warm" : ""), problem, method));
                }
            }
        }
    }
}

/// A column that starts with overlaps of 2 cm, over two seconds.
Row beta_row(const NamedMethod& method, physics::Stabilisation mode, float beta) {
    PhysicsSettings settings;
    settings.method = method.method;
    settings.methods.iterations = 50;
    settings.methods.measure = true;
    settings.methods.stabilisation = mode;
    settings.methods.beta = beta;
    scenario::Description d = scenario::column(5, 1.0);
    for (std::size_t i = 0; i < d.bodies.size(); ++i) {
        if (d.bodies[i].mass > 0.0) {
            d.bodies[i].pose.position.y() -= 0.02 * static_cast<double>(i);
        }
    }
    ZonedScene zoned = build_scene(d, settings);
    double in = 0.0;
    double out = 0.0;
    double fastest = 0.0;
    constexpr int kSteps = 120;
    for (int i = 0; i < kSteps; ++i) {
        const physics::StepStats stats = zoned.scene.step(zoned.dt);
        in += stats.method.bias_in_j;
        out += stats.method.bias_out_j;
        for (const zoned::BodyId id : zoned.ids) {
            const auto speed = static_cast<double>(zoned.scene.state(id).velocity.norm());
            fastest = std::max(fastest, speed);
        }
    }
    const physics::BodyState top = zoned.scene.state(zoned.ids.back());
    Row row;
    row.suite = "solvers";
    row.scene = "beta";
    row.method = method.name;
    row.parameter = mode == physics::Stabilisation::kSplit ? "split" : "baumgarte";
    row.parameter += ",beta=" + std::to_string(beta).substr(0, 4);
    row.error = std::abs(static_cast<double>(top.position.y()) - 4.5);
    row.error_unit = std::string("m");
    row.metric("bias_in_j_per_step", in / kSteps);
    row.metric("bias_out_j_per_step", out / kSteps);
    row.metric("fastest_mps", fastest);
    row.metric("last_speed_mps", static_cast<double>(top.velocity.norm()));
    return row;
}

/// Baumgarte's bias on a single row, where theory has the region of stability: the factor by which
/// the error goes on per step.
Row single_row(float beta) {
    PhysicsSettings settings;
    settings.method = physics::SolverVariant::kGaussSeidel;
    settings.gravity.setZero();
    settings.sleep_after_s = 0.0F;
    settings.methods.beta = beta;
    settings.methods.measure = true;
    physics::Scene scene(settings);
    physics::BodyDef def;
    def.shape = physics::Shape::sphere(0.5F);
    def.position = Vec3(1.001F, 0.0F, 0.0F);
    physics::JointDef joint;
    joint.kind = physics::JointKind::kDistance;
    joint.b = *scene.add(def);
    joint.anchor_b = def.position;
    joint.length_m = 1.0F;
    static_cast<void>(scene.add_joint(joint));
    double in = 0.0;
    constexpr int kSteps = 6;
    for (int i = 0; i < kSteps; ++i) {
        in += scene.step(1.0F / 60.0F).method.bias_in_j;
    }
    const double left = std::abs(static_cast<double>(scene.state(joint.b).position.x()) - 1.0);
    Row row;
    row.suite = "solvers";
    row.scene = "beta_single";
    row.method = "gauss_seidel";
    row.parameter = "beta=" + std::to_string(beta).substr(0, 4);
    row.error = left;
    row.error_unit = std::string("m");
    row.metric("factor_per_step", std::pow(left / 0.001, 1.0 / kSteps));
    row.metric("theory_factor", std::abs(1.0 - static_cast<double>(beta)));
    row.metric("bias_in_j", in);
    row.metric("stable", left < 0.001 ? 1.0 : 0.0);
    return row;
}

void run_beta(Session& session) {
    std::vector<float> betas{0.02F, 0.05F, 0.1F, 0.2F, 0.4F, 0.6F, 0.8F, 1.0F, 1.5F, 1.9F, 2.1F};
    if (session.quick) {
        betas = {0.2F, 1.0F, 2.1F};
    }
    session.progress("solvers beta");
    const NamedMethod method{"gauss_seidel", physics::SolverVariant::kGaussSeidel, {}};
    if (!session.wants_method(method.name, "")) {
        return;
    }
    for (const float beta : betas) {
        session.add({single_row(beta)});
    }
    for (const auto mode : {physics::Stabilisation::kBaumgarte, physics::Stabilisation::kSplit}) {
        for (const float beta : betas) {
            session.add({beta_row(method, mode, beta)});
        }
    }
}

/// The residual of twenty passes, over orders of visits.
void run_order(Session& session) {
    session.progress("solvers order");
    RowSystem problem = take(snapshots(true).front(), false);
    const std::uint32_t orders = session.quick ? 5 : 32;
    for (const NamedMethod& method : row_methods()) {
        const bool asked = session.wants_method(method.name, "");
        if (!asked || method.method == physics::SolverVariant::kDirect) {
            continue;
        }
        std::vector<double> left;
        for (std::uint32_t seed = 0; seed < orders; ++seed) {
            RowSystem system = problem;
            system.finish(seed);
            physics::solve_rows(method.method, system, limits_of(20));
            left.push_back(physics::residual(system));
        }
        Row row;
        row.suite = "solvers";
        row.scene = "order";
        row.method = method.name;
        row.error = median(left);
        row.error_unit = std::string("m/s");
        row.metric("in_order_mps", left.front());
        row.metric("least_mps", *std::min_element(left.begin(), left.end()));
        row.metric("largest_mps", largest(left));
        row.metric("orders", orders);
        session.add({row});
    }
}

/// The residual of ten passes in each frame, with impulses carried over and without.
void run_frames(Session& session) {
    session.progress("solvers frames");
    const int frames = session.quick ? 10 : 120;
    for (const NamedMethod& method : row_methods()) {
        for (const bool warm : {true, false}) {
            if (!session.wants_method(method.name, "") ||
                method.method == physics::SolverVariant::kDirect) {
                continue;
            }
            PhysicsSettings settings;
            settings.method = method.method;
            settings.methods.iterations = 10;
            settings.methods.warm_start = warm;
            settings.methods.measure = true;
            const scenario::Description d = scenario::pyramid();
            ZonedScene zoned = build_scene(d, settings);
            std::vector<double> left;
            for (int i = 0; i < frames; ++i) {
                left.push_back(zoned.scene.step(zoned.dt).method.residual_mps);
            }
            double drift = 0.0;
            for (std::size_t i = 0; i < d.bodies.size(); ++i) {
                const Vec3d at = zoned.scene.state(zoned.ids[i]).position.cast<double>();
                drift = std::max(drift, (at - d.bodies[i].pose.position).norm());
            }
            Row row;
            row.suite = "solvers";
            row.scene = "frames";
            row.method = method.name;
            row.parameter = warm ? "warm" : "cold";
            row.error = median(left);
            row.error_unit = std::string("m/s");
            row.metric("first_residual_mps", left.front());
            row.metric("last_residual_mps", left.back());
            row.metric("drift_m_max", drift);
            session.add({row});
        }
    }
}

/// A column of five whose top is heavier, step by step.
class RatioTrial : public JudgedTrial {
  public:
    RatioTrial(const PhysicsSettings& settings, double top_mass)
        : zoned_(build_scene(scenario::column(5, top_mass), settings)) {}

    void frame() override { stats_ = zoned_.scene.step(zoned_.dt); }

    void observe() override { unsolved_ += stats_.method.unsolved + stats_.method.too_large; }

    void judge(Row& row) override {
        const Vec3 top = zoned_.scene.state(zoned_.ids.back()).position;
        row.error = static_cast<double>((top - Vec3(0.0F, 4.5F, 0.0F)).norm());
        row.error_unit = std::string("m");
        row.metric("substeps", stats_.substeps);
        row.metric("islands_left_unsolved", unsolved_);
    }

  private:
    ZonedScene zoned_;
    physics::StepStats stats_;
    std::uint32_t unsolved_ = 0;
};

/// Where the exact solver pays: ratios of masses that the default has to spend substeps on.
void run_ratios(Session& session) {
    std::vector<double> ratios{1.0, 1.0e1, 1.0e2, 1.0e3, 1.0e4, 1.0e5, 1.0e6};
    if (session.quick) {
        ratios = {1.0e2, 1.0e5};
    }
    session.progress("solvers ratio");
    for (const double ratio : ratios) {
        std::vector<Method> methods;
        std::vector<NamedMethod> named = contact_methods();
        named.insert(named.begin(), {"default", physics::SolverVariant::kSoftStep, {}});
        for (const NamedMethod& method : named) {
            PhysicsSettings settings;
            settings.method = method.method;
            settings.methods.manifold = method.manifold;
            methods.push_back({method.name, "", [settings, ratio] {
                                   return std::make_unique<RatioTrial>(settings, ratio);
                               }});
        }
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "top=%g", ratio);
        session.add(compare("solvers",
                            "ratio",
                            text.data(),
                            wanted(session, std::move(methods)),
                            {0, session.quick ? 60 : 600, session.quick ? 1 : session.repeats}));
    }
}

void run_solvers(Session& session) {
    session.note(
        "solvers: error = residual of the rows (root mean square of the natural map) after so many"
        " passes; beta: error of the column's height; ratio: how far its top has moved after 10 s");
    run_curves(session);
    if (session.wants_scene("beta")) {
        run_beta(session);
    }
    if (session.wants_scene("ratio")) {
        run_ratios(session);
    }
    if (session.wants_scene("order")) {
        run_order(session);
    }
    if (session.wants_scene("frames")) {
        run_frames(session);
    }
}

std::vector<std::string> solvers_scenes() {
    std::vector<std::string> names;
    for (const Snapshot& snapshot : snapshots(true)) {
        names.push_back(snapshot.name);
    }
    names.insert(names.end(), {"beta", "ratio", "order", "frames"});
    return names;
}

std::vector<std::string> solvers_methods() {
    std::vector<std::string> names{"default"};
    for (const NamedMethod& method : contact_methods()) {
        names.push_back(method.name);
    }
    return names;
}

const Registration kSolvers({"solvers",
                             "solvers of contacts: residual against passes and time",
                             solvers_scenes(),
                             solvers_methods(),
                             run_solvers});

}  // namespace

}  // namespace zoned::bench
