#include "server/config/plan/pass_costs.h"

#include <algorithm>

namespace zoned::config {

namespace {

using zone::Pass;

// Fitted to shipped and generated worlds by `zoned-bench planner --scene costs` on one core of an
// AMD Zen 5 (x86-64-v3, g++ 12, -O2): least squares of the relative error, no price below zero.
// The same command prints what it finds beside these figures.
constexpr std::array<PassCost, zone::kPasses> kPassCosts{{
    {{"runs", "doors"}, {2500, 50}},
    {{"runs", "messages"}, {700, 100}},
    {{"runs", "players"}, {900, 30}},
    {{"runs", "decisions", "steered", "events", "agents", "crowded"},
     {1000, 150, 220, 1400, 2, 3000}},
    {{"runs", "characters"}, {600, 160}},
    {{"runs", "reducible props"}, {500, 50}},
    {{"runs", "node sweeps", "spring sweeps", "Newton springs", "gradient springs", "contacts"},
     {1200, 2.9, 1.9, 22, 3.2, 100}},
    {{"runs", "motors"}, {1000, 100}},
    {{"runs", "platforms"}, {100, 140}},
    {{"runs", "awake bodies", "pairs", "contact points", "contact sweeps", "joint sweeps"},
     {1100, 360, 25, 50, 20, 340}},
    {{"runs", "particles"}, {2500, 2}},
    {{"runs", "contacts"}, {500, 140}},
    {{"runs", "moving entities"}, {600, 32}},
    {{"runs", "ghosts"}, {500, 120}},
    {{"runs", "viewers", "changed entities", "examined pairs", "viewers made anew"},
     {1300, 25, 40, 180, 900}},
    {{"runs", "checked pairs"}, {500, 200}},
    {{"runs", "streams", "publications", "copied records", "coded records", "packets", "viewers"},
     {650, 170, 3000, 100, 1100, 200, 50}},
    {{"runs", "poses"}, {650, 24}},
    {{"runs", "records"}, {1000, 20000}},
    {{"runs", "changed entities"}, {550, 65}},
}};

double per(double sum, double of) {
    return of > 0.0 ? sum / of : 0.0;
}

PassUnits soft_units(const physics::soft::SoftStats& soft) {
    const double springs = per(soft.springs, soft.awake);
    return {1.0,
            static_cast<double>(soft.nodes) * soft.substeps,
            static_cast<double>(soft.springs) * soft.substeps,
            soft.newton_steps * springs,
            soft.gradient_passes * springs,
            static_cast<double>(soft.contacts)};
}

PassUnits physics_units(const zone::StepReport& r) {
    const physics::StepStats& p = r.physics;
    return {1.0,
            static_cast<double>(p.awake),
            static_cast<double>(p.pairs),
            static_cast<double>(p.contacts),
            static_cast<double>(p.contact_sweeps),
            static_cast<double>(p.joint_sweeps)};
}

PassUnits replication_units(const replication::ReplicationReport& r, double viewers) {
    return {1.0,
            static_cast<double>(r.streams),
            static_cast<double>(r.publications),
            static_cast<double>(r.records_sent - std::min(r.coded_records, r.records_sent)),
            static_cast<double>(r.coded_records),
            static_cast<double>(r.packets),
            viewers};
}

}  // namespace

const PassCost& cost_of(Pass pass) {
    return kPassCosts[static_cast<std::size_t>(pass)];
}

PassUnits units_of(Pass pass, const zone::StepReport& r) {
    const zone::PassReport& report = r.passes[static_cast<std::size_t>(pass)];
    if (!report.ran) {
        return {};
    }
    switch (pass) {
        case Pass::kAgents:
            return {1.0,
                    static_cast<double>(r.ai.decisions),
                    static_cast<double>(r.ai.steered),
                    static_cast<double>(r.ai.events),
                    static_cast<double>(r.ai.agents),
                    static_cast<double>(r.ai.avoidance.crowded)};
        case Pass::kRepresentation:
            return {1.0, static_cast<double>(r.census.reducible)};
        case Pass::kSoft:
            return soft_units(r.soft);
        case Pass::kMotors:
            return {1.0, static_cast<double>(r.census.motors)};
        case Pass::kPhysics:
            return physics_units(r);
        case Pass::kParticles:
            return {1.0, static_cast<double>(r.particles.particles)};
        case Pass::kHandoff:
            return {1.0, static_cast<double>(r.census.moving_characters + r.census.awake_bodies)};
        case Pass::kGhosts:
            return {1.0, static_cast<double>(r.census.ghosts)};
        case Pass::kInterest:
            return {1.0,
                    static_cast<double>(r.interest.viewers),
                    static_cast<double>(r.interest.changed),
                    static_cast<double>(r.interest.examined),
                    static_cast<double>(r.interest.refreshed)};
        case Pass::kReplication:
            return replication_units(r.replication, r.census.viewers);
        default:
            return {1.0, static_cast<double>(report.count)};
    }
}

double table_ns(Pass pass, const PassUnits& units) {
    const PassCost& cost = cost_of(pass);
    double ns = 0.0;
    for (std::size_t k = 0; k < kUnitKinds; ++k) {
        ns += cost.ns[k] * units[k];
    }
    return ns;
}

double expected_ns(double table_ns, double speed, double measured_ns, double ran) {
    return (kTableRuns * speed * table_ns + ran * measured_ns) / (kTableRuns + ran);
}

}  // namespace zoned::config
