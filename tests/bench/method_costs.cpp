#include "tests/bench/method_costs.h"

#include "server/physics/integrator/free_flight.h"
#include "server/physics/method_selection/cost_table.h"
#include "server/physics/method_selection/flight_choice.h"
#include "server/physics/soft/builders/builders.h"
#include "server/physics/soft/soft_bodies.h"
#include "server/physics/soft/soft_body.h"
#include "tests/bench/comparison.h"

#include <stdexcept>

namespace zoned::bench {

namespace {

namespace selection = physics::method_selection;
namespace soft = physics::soft;
using physics::IntegratorKind;

void tell_costs(Row& row, double table_ns) {
    const double measured = *row.find_metric("ns_per_step");
    row.metric("table_ns", table_ns);
    row.metric("measured_over_table", measured / table_ns);
}

/// A frame is a tick of many bodies in the air.
class FlightTrial : public JudgedTrial {
  public:
    static constexpr std::size_t kBodies = 1024;

    explicit FlightTrial(IntegratorKind kind) : kind_(kind) {
        for (std::size_t i = 0; i < kBodies; ++i) {
            position_.emplace_back(0.1F * static_cast<float>(i), 1.0F, 2.0F);
            velocity_.emplace_back(3.0F, 0.02F * static_cast<float>(i), -1.0F);
        }
    }

    void frame() override {
        const physics::FreeFall<float, 3> fall(Vec3(0.0F, -9.81F, 0.0F), kDrag);
        for (std::size_t i = 0; i < kBodies; ++i) {
            physics::free_flight_in(1, kind_, fall, kStepTime, position_[i], velocity_[i]);
        }
    }

    void judge(Row& row) override {
        selection::Flight flight;
        flight.gravity = Vec3d(0.0, -9.81, 0.0);
        flight.linear_drag = static_cast<double>(kDrag);
        flight.fastest = 20.0;
        const double tick = static_cast<double>(kStepTime);
        row.error = selection::flight_error(kind_, 1, flight, {0.0, 2.0, tick});
        row.error_unit = "m";
    }

  private:
    static constexpr float kDrag = 0.5F;

    IntegratorKind kind_;
    std::vector<Vec3> position_;
    std::vector<Vec3> velocity_;
};

soft::SoftDef fit_def(const core::Result<soft::SoftDef>& built) {
    if (!built) {
        throw std::runtime_error("our engine refused a soft body: " + built.error());
    }
    return *built;
}

/// One for each column of the table.
std::vector<std::pair<std::string, soft::SoftDef>> soft_shapes() {
    soft::RopeDef rope;
    rope.nodes = 400;
    rope.mass = 20.0F;
    rope.to = Vec3(20, 0, 0);
    rope.stiffness = 2.0e3F;
    soft::ClothDef cloth;
    cloth.nx = cloth.nz = 24;
    cloth.stiffness = 100.0F;
    cloth.shear_stiffness = 50.0F;
    cloth.bend_stiffness = 10.0F;
    cloth.pins = {{0, 0}, {23, 0}};
    cloth.coarsen = 1;
    soft::JellyDef jelly;
    jelly.nodes = {6, 6, 6};
    jelly.mass = 20.0F;
    jelly.bulk_modulus = 2.0e3F;
    soft::BalloonDef balloon;
    balloon.mass = 2.0F;
    balloon.gas_pressure = 1.02e5F;
    return {{"rope", fit_def(soft::build_rope(rope))},
            {"cloth", fit_def(soft::build_cloth(cloth))},
            {"jelly", fit_def(soft::build_jelly(jelly))},
            {"balloon", fit_def(soft::build_balloon(balloon))}};
}

/// A frame is a step; the table's costs of all steps are summed up in the observed run.
class SubstepTrial : public JudgedTrial {
  public:
    explicit SubstepTrial(const soft::SoftDef& def)
        : bodies_(awake()),
          method_(def.solver.method),
          substeps_(soft::make_body(def).substeps(kStepTime)),
          counts_(selection::counts_of(def)) {
        const auto id = bodies_.add(def);
        if (!id) {
            throw std::runtime_error("our engine refused a soft body: " + id.error());
        }
    }

    void frame() override { stats_ = bodies_.step(kStepTime, nullptr); }

    void observe() override {
        ++frames_;
        table_ns_ += selection::soft_cost_ns(
            method_, counts_, substeps_, stats_.newton_steps, stats_.gradient_passes);
        newton_ += stats_.newton_steps;
        passes_ += stats_.gradient_passes;
    }

    void judge(Row& row) override {
        row.error_unit = "";
        row.metric("table_ns", table_ns_ / frames_);
        row.metric("substeps", substeps_);
        row.metric("newton_steps", newton_ / frames_);
        row.metric("gradient_passes", passes_ / frames_);
        row.metric("nodes", counts_.nodes);
        row.metric("springs", counts_.springs);
        row.metric("tetrahedra", counts_.tetrahedra);
        row.metric("faces", counts_.faces);
    }

  private:
    static soft::SoftSettings awake() {
        soft::SoftSettings settings;
        settings.sleep_after_s = 0.0F;
        settings.step_s = kStepTime;
        return settings;
    }

    soft::SoftBodies bodies_;
    soft::SoftMethod method_;
    int substeps_;
    selection::SweepCounts counts_;
    soft::SoftStats stats_;
    double frames_ = 0.0;
    double table_ns_ = 0.0;
    double newton_ = 0.0;
    double passes_ = 0.0;
};

}  // namespace

void run_flight_costs(Session& session) {
    session.progress("integrators free_flight");
    std::vector<Method> methods;
    for (const IntegratorKind kind : selection::kFlightMethods) {
        methods.push_back({physics::name_of(kind), "", [kind] {
                               return std::make_unique<FlightTrial>(kind);
                           }});
    }
    const Plan plan{4, session.quick ? 8 : 400, session.quick ? 1 : session.repeats};
    std::vector<Row> rows =
        compare("integrators", "free_flight", "dt=1/60", wanted(session, std::move(methods)), plan);
    for (Row& row : rows) {
        row.metric("ns_per_step", 1e3 * row.time_us_p50 / FlightTrial::kBodies);
        for (const IntegratorKind kind : selection::kFlightMethods) {
            if (row.method == physics::name_of(kind)) {
                tell_costs(row, selection::flight_cost_ns(kind, 1));
            }
        }
    }
    session.add(std::move(rows));
}

void run_substep_costs(Session& session) {
    session.progress("soft substeps");
    for (const auto& [name, shape] : soft_shapes()) {
        std::vector<Method> methods;
        const auto add = [&, &whole = shape](const char* method, soft::SoftSolver solver) {
            soft::SoftDef def = whole;
            def.solver = solver;
            methods.push_back({method, "", [def = std::move(def)] {
                                   return std::make_unique<SubstepTrial>(def);
                               }});
        };
        soft::SoftSolver solver;
        solver.substeps = 8;
        add("xpbd", solver);
        solver.substeps = 0;
        solver.method = soft::SoftMethod::kSemiImplicitEuler;
        add("semi_implicit_euler", solver);
        solver.method = soft::SoftMethod::kImplicitEuler;
        add("implicit_euler", solver);
        solver.gradient_iterations = 1;  // little but Newton's part of it
        add("implicit_one_pass", solver);
        const Plan plan{4, session.quick ? 8 : 120, session.quick ? 1 : session.repeats};
        std::vector<Row> rows =
            compare("soft", "substeps", name, wanted(session, std::move(methods)), plan);
        for (Row& row : rows) {
            row.metric("ns_per_step", 1e3 * row.time_us_p50);
            row.metric("measured_over_table", 1e3 * row.time_us_p50 / *row.find_metric("table_ns"));
        }
        session.add(std::move(rows));
    }
}

}  // namespace zoned::bench
