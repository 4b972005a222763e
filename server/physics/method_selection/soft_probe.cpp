#include "server/physics/method_selection/soft_probe.h"

#include "server/physics/soft/spring_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics::method_selection {

namespace {

constexpr float kStretch = 1.2F;
constexpr int kMoments = 10;
constexpr double kReferenceHz = 3840.0;
/// XPBD makes velocities of rounded positions: with still shorter substeps these are mostly noise.
constexpr double kMostXpbd = 512.0;

Aabb box_of(const soft::SoftDef& def) {
    Aabb box;
    for (const soft::SoftNode& node : def.nodes) {
        box.lower = box.lower.cwiseMin(node.position);
        box.upper = box.upper.cwiseMax(node.position);
    }
    return box;
}

void stretch(soft::SoftDef& def, const Aabb& box) {
    const Vec3 centre = 0.5F * (box.lower + box.upper);
    int along = 0;
    (box.upper - box.lower).maxCoeff(&along);
    Vec3 scale = Vec3::Constant(1.0F / std::sqrt(kStretch));
    scale[along] = kStretch;
    for (soft::SoftNode& node : def.nodes) {
        node.position = centre + scale.cwiseProduct(node.position - centre);
    }
}

}  // namespace

SoftProbe::SoftProbe(const soft::SoftDef& def, const Vec3& gravity, float tick_s)
    : def_(def),
      gravity_(gravity),
      tick_s_(tick_s),
      ticks_(std::max(1, static_cast<int>(std::lround(1.0 / static_cast<double>(tick_s))))) {
    const Aabb box = box_of(def);
    size_ = static_cast<double>((box.upper - box.lower).maxCoeff());
    pinned_ = std::any_of(
        def.nodes.begin(), def.nodes.end(), [](const soft::SoftNode& n) { return n.pinned; });
    def_.vertices.clear();
    def_.drawn_faces.clear();
    def_.material.tear_strain = def_.material.tear_force = def_.material.yield_strain = 0.0F;
    def_.material.collides = def_.material.self_collision = false;
}

ProbeRun SoftProbe::run(const soft::SoftSolver& solver, int splits) const {
    const float step_s = tick_s_ / static_cast<float>(splits);
    soft::SoftSettings settings;
    settings.gravity = pinned_ ? gravity_ : Vec3(Vec3::Zero());
    settings.sleep_after_s = 0.0F;
    settings.step_s = step_s;
    soft::SoftBodies bodies(settings);
    soft::SoftDef def = def_;
    def.solver = solver;
    ProbeRun out;
    const auto id = bodies.add(def);
    if (!id) {
        out.broke = true;
        return out;
    }
    if (!pinned_) {
        // Volumes at rest are those of the definition: it is stretched afterwards.
        stretch(def, box_of(def));
        for (std::size_t i = 0; i < def.nodes.size(); ++i) {
            bodies.move_node(*id, i, def.nodes[i].position);
        }
    }
    const int gap = std::max(1, ticks_ / kMoments);
    for (int tick = 1; tick <= ticks_ && !out.broke; ++tick) {
        for (int s = 0; s < splits; ++s) {
            const soft::SoftStats stats = bodies.step(step_s, nullptr);
            out.newton_steps += stats.newton_steps;
            out.gradient_passes += stats.gradient_passes;
            out.broke = out.broke || stats.quarantined > 0;
        }
        for (std::size_t i = 0; tick % gap == 0 && i < def.nodes.size(); ++i) {
            out.places.push_back(bodies.position(*id, i));
        }
    }
    return out;
}

double SoftProbe::distance(const ProbeRun& a, const ProbeRun& b) const {
    if (a.broke || b.broke || a.places.size() != b.places.size()) {
        return std::numeric_limits<double>::infinity();
    }
    double most = 0.0;
    const std::size_t nodes = def_.nodes.size();
    for (std::size_t first = 0; first < a.places.size(); first += nodes) {
        double sum = 0.0;
        for (std::size_t i = first; i < first + nodes; ++i) {
            sum += (a.places[i] - b.places[i]).cast<double>().norm();
        }
        most = std::max(most, sum / static_cast<double>(nodes));
    }
    return most / size_;
}

ProbeRun SoftProbe::run_in(soft::SoftMethod method, int substeps) const {
    soft::SoftSolver solver;
    solver.method = method;
    const int splits = (substeps + soft::kMostSubsteps - 1) / soft::kMostSubsteps;
    solver.substeps = substeps / splits;
    return run(solver, splits);
}

ProbeReference SoftProbe::reference(double budget) const {
    using soft::SoftMethod;
    const double tick = static_cast<double>(tick_s_);
    const auto text = [](const char* method, int n) {
        return std::string(method) + " in " + std::to_string(n) + " substeps a tick";
    };
    // As many springs as take the same time: a tetrahedron 20, whatever a substep has to do 50.
    const double parts =
        static_cast<double>(def_.springs.size() + 20 * def_.tetrahedra.size() + 50);
    const auto affordable = [&](double n) {
        return 1.5 * n * ticks_ * parts <= kMostReference;
    };
    const double longest = soft::spring_limit(def_).step_s();
    // Halves of a step are whole numbers of substeps; a number above kMostSubsteps is a multiple of
    // it.
    const auto whole = [](double n) {
        const double most = soft::kMostSubsteps;
        return n <= most ? std::ceil(n) : most * std::ceil(n / most);
    };
    const double fine = 2.0 * std::ceil(0.5 * kReferenceHz * tick);
    double n = whole(std::max(2.0 * std::ceil(tick / longest), fine));
    const bool soft = affordable(n);
    const SoftMethod method = soft ? SoftMethod::kSemiImplicitEuler : SoftMethod::kXpbd;
    n = soft ? n : whole(fine);
    const double most = soft ? std::numeric_limits<double>::infinity() : kMostXpbd;
    ProbeRun coarse = run_in(method, static_cast<int>(whole(0.5 * n)));
    ProbeReference out;
    while (true) {
        out.run = run_in(method, static_cast<int>(n));
        out.change = distance(out.run, coarse);
        out.how = text(soft ? "semi-implicit Euler" : "XPBD", static_cast<int>(n));
        const double next = whole(2.0 * n);
        if (out.change < 0.1 * budget || next > most || !affordable(next)) {
            return out;
        }
        coarse = std::move(out.run);
        n = next;
    }
}

}  // namespace zoned::physics::method_selection
