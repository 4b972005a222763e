#include "server/ai/serialization/serialize_agents.h"

#include "server/ai/agent/agent_fields.h"
#include "server/ai/steering/spline_following.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

using core::FieldReader;
using core::FieldWriter;

constexpr std::uint32_t kVersion = 7;
/// Larger than any zone, m.
constexpr float kFarthest_m = 1e6F;

/// The largest Agent::corner for the action.
std::uint8_t most_corner(ActionKind action) {
    switch (action) {
        case ActionKind::kPatrol:
            return 3;
        case ActionKind::kGuard:
            return 1;
        case ActionKind::kFollowTrack:
            return kTrackEnds;
        case ActionKind::kForage:
            return pathfinding::kDirections - 1U + kCarries + kScouts + kLost + kBegins;
        default:
            return 0xFF;  // unused, or any value is allowed
    }
}

/// Whether the difficulty is valid for `settings`: its level exists, and its position is within the
/// cap. Without levels its level is 0.
bool is_difficulty(const DifficultyState& difficulty, const DifficultyLevels& settings) {
    const learning::Staircase& cap = settings.staircase;
    return settings.levels.empty()
               ? difficulty.level == 0
               : difficulty.level < settings.levels.size() && difficulty.position >= cap.least &&
                     difficulty.position <= cap.most;
}

/// Whether the agent is at valid positions on existing lanes of the world.
bool is_on_tracks(const SplineWalk& walk, const splines::SplineNetwork* net) {
    const auto known = [net](splines::LaneId id, float s) {
        return net != nullptr && id < net->lanes() && s >= 0.0F &&
               static_cast<double>(s) <= net->lane(id).length() + 1.0;
    };
    return known(walk.lane, walk.s) && walk.changed >= 0.0F && walk.due <= kNever &&
           (walk.from == splines::kNoLane || known(walk.from, walk.from_s));
}

/// The first defect of the agent for `settings` on that level; null: none.
const char* wrong_with(const Agent& agent, const AiSettings& settings, std::uint16_t level) {
    if (agent.brain >= settings.compiled.size() ||
        brain_at_level(settings, level, agent.brain).states.empty()) {
        return "has a brain that there is not";
    }
    const CompiledBrain& brain = brain_at_level(settings, level, agent.brain);
    const std::uint16_t leaf = agent.state_machine.leaf;
    if (leaf >= brain.table.leaves()) {
        return "is in a state that there is not";
    }
    const CompiledBrain::LeafChoice& choice = brain.choices[leaf];
    const bool action = agent.current_action >= choice.first &&
                        agent.current_action < choice.first + brain.states[leaf].actions.size();
    if (agent.current_action != leaf && !action) {
        return "does what its state does not say";
    }
    if (agent.state_machine.pending != state_machine::kNone &&
        agent.state_machine.pending >= brain.table.transitions.size()) {
        return "holds a transition that there is not";
    }
    for (const auto& memory : agent.state_machine.memory) {
        if (memory != state_machine::kNone && memory >= brain.table.nodes.size()) {
            return "remembers a state that there is not";
        }
    }
    // An action that has only just been chosen sets `corner` itself.
    if (!agent.entered && agent.corner > most_corner(brain.states[agent.current_action].action)) {
        return "is at a corner that there is not";
    }
    if (!agent.entered && brain.states[agent.current_action].action == ActionKind::kFollowTrack &&
        !is_on_tracks(agent.track, settings.points_of_interest.tracks.get())) {
        return "is on a track that there is not";
    }
    if (agent.tier > Tier::kSuspended || (agent.tier == Tier::kSuspended && !agent.timed)) {
        return "is in no tier, or nowhere";
    }
    return nullptr;
}

void write_nests(const Nests::SavedNests& memory, FieldWriter& write) {
    write(memory.delivered);
    write(memory.turned);
    write(static_cast<std::uint32_t>(memory.nests.size()));
    for (const Nests::Scents& nest : memory.nests) {
        write(nest.brain);
        write(nest.current_action);
        write(nest.type);
        write(static_cast<std::uint32_t>(nest.cells.size()));
        for (const pathfinding::ScentCell& cell : nest.cells) {
            write(cell);
        }
    }
}

/// Whether `settings` have the nest, its cells ascend, and its pheromones are within 0 to 1.
bool is_nest(const Nests::Scents& nest, const AiSettings& settings) {
    if (nest.brain >= settings.compiled.size()) {
        return false;
    }
    const std::vector<BrainState>& states = settings.compiled[nest.brain].states;
    return nest.current_action < states.size() && states[nest.current_action].forage.has_value() &&
           std::is_sorted(nest.cells.begin(),
                          nest.cells.end(),
                          [](const auto& a, const auto& b) { return a.place <= b.place; }) &&
           std::all_of(nest.cells.begin(), nest.cells.end(), pathfinding::is_scent_cell);
}

/// Empty text: done.
std::string read_nests(FieldReader& read, const AiSettings& settings, Nests::SavedNests& memory) {
    std::uint32_t count = 0;
    read(memory.delivered);
    read(memory.turned);
    read(count);
    for (std::uint32_t n = 0; n < count && !read.cut_short(); ++n) {
        Nests::Scents nest;
        std::uint32_t cells = 0;
        read(nest.brain);
        read(nest.current_action);
        read(nest.type);
        read(cells);
        for (std::uint32_t c = 0; c < cells && !read.cut_short(); ++c) {
            read(nest.cells.emplace_back());
        }
        if (!read.cut_short() && !is_nest(nest, settings)) {
            return "nest " + std::to_string(n) + " is none, or has scents that are none";
        }
        memory.nests.push_back(std::move(nest));
    }
    return read.cut_short() || !read.finite() || !read.known() ? "nests are cut short" : "";
}

}  // namespace

void save_agents(const AgentStore& agents,
                 const AiUpdate& step,
                 const PointsOfInterest& points_of_interest,
                 std::vector<std::uint8_t>& out) {
    const SavedAiState saved = step.save();
    FieldWriter write(out);
    write(kVersion);
    visit_fields(saved.difficulty, write);
    write(saved.drift_m);
    write(static_cast<std::uint32_t>(agents.size()));
    for (std::size_t n = 0; n < agents.size(); ++n) {
        visit_fields(agents.at(agents.nth(n)), write);
    }
    write(static_cast<std::uint32_t>(saved.viewers.viewers.size()));
    for (const EntityId viewer : saved.viewers.viewers) {
        write(viewer.value);
    }
    write(static_cast<std::uint32_t>(saved.viewers.covered_from.size()));
    for (const Vec2& at : saved.viewers.covered_from) {
        write(at.x());
        write(at.y());
    }
    write(saved.viewers.coverage_m);
    write(static_cast<std::uint32_t>(points_of_interest.stocks().size()));
    for (const PointsOfInterest::Stock& stock : points_of_interest.stocks()) {
        write(stock.amount);
        write(stock.at);
    }
    write_nests(step.nests().save(), write);
}

std::string load_agents(std::span<const std::uint8_t> bytes,
                        AiSettings& settings,
                        AgentStore& agents,
                        AiUpdate& step,
                        PointsOfInterest& points_of_interest) {
    FieldReader read(bytes);
    std::uint32_t version = 0;
    std::uint32_t count = 0;
    SavedAiState memory;
    read(version);
    if (read.cut_short() || version != kVersion) {
        return "version " + std::to_string(version) + " of agents, not " + std::to_string(kVersion);
    }
    visit_fields(memory.difficulty, read);
    read(memory.drift_m);
    read(count);
    if (read.cut_short() || !read.finite() ||
        !is_difficulty(memory.difficulty, settings.difficulty)) {
        return "the difficulty is cut short, or none of the settings";
    }
    AgentStore fresh;
    EntityId before;
    for (std::uint32_t n = 0; n < count; ++n) {
        Agent agent;
        visit_fields(agent, read);
        const std::string name =
            "agent " + std::to_string(n) + " of entity " + std::to_string(agent.entity.value) + " ";
        if (read.cut_short()) {
            return name + "is cut short";
        }
        if (!(before < agent.entity)) {
            return name + "comes after a larger one";
        }
        const char* wrong = wrong_with(agent, settings, memory.difficulty.level);
        if (wrong != nullptr || !read.finite() || !read.known()) {
            return name + (wrong != nullptr ? wrong : "has a number that is none");
        }
        before = agent.entity;
        fresh.add(agent);
    }
    std::uint32_t viewers = 0;
    read(viewers);
    for (std::uint32_t v = 0; v < viewers && !read.cut_short(); ++v) {
        read(memory.viewers.viewers.emplace_back().value);
    }
    bool near = true;
    std::uint32_t places_of_viewers = 0;
    read(places_of_viewers);
    for (std::uint32_t v = 0; v < places_of_viewers && !read.cut_short(); ++v) {
        Vec2& at = memory.viewers.covered_from.emplace_back(Vec2::Zero());
        read(at.x());
        read(at.y());
        near = near && at.cwiseAbs().maxCoeff() <= kFarthest_m;
    }
    read(memory.viewers.coverage_m);
    near = near && memory.drift_m >= 0.0F && memory.drift_m <= kFarthest_m;
    near = near && memory.viewers.coverage_m > 0.0F && memory.viewers.coverage_m <= kFarthest_m;
    if (read.cut_short() || !read.finite() || !near ||
        !std::is_sorted(memory.viewers.viewers.begin(), memory.viewers.viewers.end())) {
        return "viewers are cut short, in no order, or nowhere";
    }
    std::uint32_t stocks = 0;
    read(stocks);
    if (read.cut_short() || stocks != points_of_interest.stocks().size()) {
        return std::to_string(stocks) + " goods in stock, not " +
               std::to_string(points_of_interest.stocks().size());
    }
    std::vector<PointsOfInterest::Stock> stock(points_of_interest.stocks().begin(),
                                               points_of_interest.stocks().end());
    for (PointsOfInterest::Stock& one : stock) {
        read(one.amount);
        read(one.at);
    }
    if (read.cut_short() || !read.finite()) {
        return "stock is cut short, or has a number that is none";
    }
    Nests::SavedNests nests;
    const std::string wrong_nests = read_nests(read, settings, nests);
    if (!wrong_nests.empty()) {
        return wrong_nests;
    }
    if (read.left() > 0) {
        return std::to_string(read.left()) + " bytes are left over";
    }
    agents = std::move(fresh);
    points_of_interest.set_stocks(stock);
    put_on_level(settings, memory.difficulty.level);
    step.load(memory, nests, agents, settings);
    return {};
}

}  // namespace zoned::ai
