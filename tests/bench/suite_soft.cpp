// Suite `soft`: a cloth of 64 x 64 nodes that falls from two corners, over four stiffnesses; error
// against the same springs solved in small steps.
#include "server/physics/soft/builders/builders.h"
#include "server/physics/soft/soft_bodies.h"
#include "tests/bench/bullet_cloth.h"
#include "tests/bench/comparison.h"
#include "tests/bench/method_costs.h"
#include "tests/scenario/cloth_scene.h"

#include <cstdio>
#include <future>
#include <stdexcept>

namespace zoned::bench {

namespace {

namespace soft = physics::soft;
using scenario::Cloth;

/// Where the nodes are at 1 s and, in the run of more drag, at rest.
struct ClothTruth {
    std::vector<Vec3d> at_one;
    std::vector<Vec3d> at_rest;
    double change = 0.0;  ///< of `at_one` against steps half as long again, m
};

Cloth settling(Cloth cloth) {
    cloth.drag = scenario::kClothSettleDrag;
    return cloth;
}

ClothTruth truth_of(const Cloth& cloth) {
    ClothTruth truth;
    auto finer = std::async(std::launch::async,
                            [&cloth] { return scenario::cloth_reference(cloth, 1.0, 0.8); });
    truth.at_rest = scenario::cloth_reference(settling(cloth), scenario::kClothRestTime, 0.8);
    truth.at_one = scenario::cloth_reference(cloth, 1.0, 1.2);
    truth.change = scenario::mean_distance(truth.at_one, finer.get());
    return truth;
}

/// How a cloth is simulated.
struct ClothWay {
    int coarsen = soft::ClothDef().coarsen;
    soft::SoftSolver solver;
};

soft::SoftDef cloth_def(const Cloth& cloth, const ClothWay& way) {
    soft::ClothDef def;
    def.size_x = def.size_z = static_cast<float>(cloth.size);
    def.nx = def.nz = cloth.nodes;
    def.density = static_cast<float>(cloth.density);
    def.stiffness = static_cast<float>(cloth.stiffness);
    def.shear_stiffness = static_cast<float>(0.5 * cloth.stiffness);
    def.bend_stiffness = static_cast<float>(0.1 * cloth.stiffness);
    def.damping_share = static_cast<float>(cloth.damping_share);
    def.pins = {{0, 0}, {cloth.nodes - 1, 0}};
    def.coarsen = way.coarsen;
    auto built = soft::build_cloth(def);
    if (!built) {
        throw std::runtime_error("our engine refused a cloth: " + built.error());
    }
    built->material.drag = static_cast<float>(cloth.drag);
    built->solver = way.solver;
    return *built;
}

soft::SoftSettings awake_cloth() {
    soft::SoftSettings settings;
    settings.sleep_after_s = 0.0F;
    return settings;
}

class OurCloth {
  public:
    OurCloth(const Cloth& cloth, const ClothWay& way) : bodies_(awake_cloth()) {
        id_ = *bodies_.add(cloth_def(cloth, way));
        drawn_.resize(bodies_.vertex_count(id_));
    }

    void step() {
        bodies_.step(kStepTime, nullptr);
        bodies_.vertices(id_, drawn_);
    }

    [[nodiscard]] std::vector<Vec3d> nodes() const {
        std::vector<Vec3d> out;
        for (const Vec3& x : drawn_) {
            out.push_back(x.cast<double>());
        }
        return out;
    }

    [[nodiscard]] std::string hash() const {
        core::StateHash hash;
        bodies_.hash(hash);
        char text[17];
        std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
        return text;
    }

    void tell(Row& row) const {
        row.state_hash = hash();
        row.metric("nodes_simulated", static_cast<double>(bodies_.node_count(id_)));
        row.metric("springs_simulated", static_cast<double>(bodies_.spring_count(id_)));
    }

  private:
    soft::SoftBodies bodies_;
    soft::SoftId id_;
    std::vector<Vec3> drawn_;
};

void tell_cloth(const OurCloth& cloth, Row& row) {
    cloth.tell(row);
}

void tell_cloth(const BulletCloth& cloth, Row& row) {
    row.metric("nodes_simulated", static_cast<double>(cloth.nodes().size()));
    row.metric("springs_simulated", cloth.links());
}

/// The timed run ends at 1 s; the run to rest is made afterwards.
template <class Simulated>
class ClothTrial : public JudgedTrial {
  public:
    using Make = std::function<std::unique_ptr<Simulated>(const Cloth&)>;

    ClothTrial(const Cloth& cloth, const ClothTruth& truth, Make make)
        : cloth_(cloth),
          truth_(truth),
          make_(std::move(make)),
          simulated_(make_(cloth)) {}

    void frame() override { simulated_->step(); }

    void judge(Row& row) override {
        row.error = scenario::mean_distance(simulated_->nodes(), truth_.at_one) / cloth_.size;
        row.error_unit = std::string("share");
        tell_cloth(*simulated_, row);
        const auto resting = make_(settling(cloth_));
        for (int i = 0; i < static_cast<int>(scenario::kClothRestTime / cloth_.dt); ++i) {
            resting->step();
        }
        row.metric("error_rest_share",
                   scenario::mean_distance(resting->nodes(), truth_.at_rest) / cloth_.size);
        row.metric("reference_change_share", truth_.change / cloth_.size);
    }

  private:
    Cloth cloth_;
    const ClothTruth& truth_;
    Make make_;
    std::unique_ptr<Simulated> simulated_;
};

std::vector<Method> cloth_methods(const Cloth& cloth, const ClothTruth& truth) {
    std::vector<Method> methods;
    const auto ours = [&](const char* name, ClothWay way) {
        methods.push_back({name, "", [&cloth, &truth, way] {
                               return std::make_unique<ClothTrial<OurCloth>>(
                                   cloth, truth, [way](const Cloth& c) {
                                       return std::make_unique<OurCloth>(c, way);
                                   });
                           }});
    };
    ours("default", ClothWay());
    ClothWay all;
    all.coarsen = 1;
    ours("xpbd", all);
    ClothWay implicit = all;
    implicit.solver.method = soft::SoftMethod::kImplicitEuler;
    ours("implicit_euler", implicit);
    const auto bullet = [&](const char* name, int passes) {
        methods.push_back({name, "bullet", [&cloth, &truth, passes] {
                               return std::make_unique<ClothTrial<BulletCloth>>(
                                   cloth, truth, [passes](const Cloth& c) {
                                       return std::make_unique<BulletCloth>(c, passes);
                                   });
                           }});
    };
    bullet("default", 1);
    bullet("passes_100", 100);
    return methods;
}

void run_cloths(Session& session) {
    session.note(
        "soft: one thread; a frame is a step of 1/60 s up to 1 s, the drawn vertices included. "
        "`default` simulates a lattice coarser by three and hangs the 64 x 64 nodes on it; `xpbd` "
        "and `implicit_euler` simulate all nodes. The error is the mean distance of all 64 x 64 "
        "nodes from the converged solution of the 64 x 64 springs, as a share of 2 m. Bullet has "
        "the same nodes, links, faces and drag, and a link's stiffness as the share of its error "
        "that the same spring takes back in one implicit step");
    const std::vector<double> all{1e3, 1e4, 1e5, 1e6};
    const std::vector<double> few{1e3};
    for (const double k : session.quick ? few : all) {
        Cloth cloth;
        cloth.stiffness = k;
        cloth.nodes = session.quick ? 22 : 64;
        char parameter[32];
        std::snprintf(parameter, sizeof(parameter), "k=%.0e", k);
        session.progress(std::string("soft cloth_64 ") + parameter);
        const ClothTruth truth = truth_of(cloth);
        const Plan plan{0, 60, session.quick ? 1 : session.repeats};
        session.add(compare(
            "soft", "cloth_64", parameter, wanted(session, cloth_methods(cloth, truth)), plan));
    }
}

void run_soft(Session& session) {
    if (session.wants_scene("cloth_64")) {
        run_cloths(session);
    }
    if (session.wants_scene("substeps")) {
        run_substep_costs(session);
    }
}

const Registration kSoft(
    {"soft",
     "cloth: error against time over stiffness; what a step of each method costs",
     {"cloth_64", "substeps"},
     {"default",
      "xpbd",
      "implicit_euler",
      "semi_implicit_euler",
      "implicit_one_pass",
      "bullet/default",
      "bullet/passes_100"},
     run_soft});

}  // namespace

}  // namespace zoned::bench
