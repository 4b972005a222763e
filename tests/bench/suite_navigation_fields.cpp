#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/flow_fields/next_hops.h"
#include "tests/bench/comparison.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/suite_navigation.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::FlowField;
using ai::pathfinding::Hop;
using ai::pathfinding::NextHops;
using scenario::GridInstance;

constexpr std::size_t kNamedGoals = 16;
constexpr std::size_t kLookups = 4096;
constexpr double kMebibyte = 1024.0 * 1024.0;

/// Every so many-th instance of a scene, `count` of them at most.
std::vector<GridInstance> some_of(const GridScene& scene, std::size_t count) {
    std::vector<GridInstance> some;
    const std::size_t step = std::max<std::size_t>(1, scene.instances.size() / count);
    for (std::size_t i = 0; i < scene.instances.size() && some.size() < count; i += step) {
        some.push_back(scene.instances[i]);
    }
    return some;
}

/// Length of the path along the hops; below 0 where they do not end at a goal.
template <class HopAt>
double length_along(const GridScene& scene, Cell c, const HopAt& hop_at) {
    std::uint32_t straight = 0;
    std::uint32_t diagonal = 0;
    for (std::uint32_t i = 0; i <= scene.map.passable_cells(); ++i) {
        const Hop hop = hop_at(c);
        if (hop >= ai::pathfinding::kArrived) {
            return hop == ai::pathfinding::kArrived ? ai::pathfinding::length_of(straight, diagonal)
                                                    : -1.0;
        }
        const Cell to = ai::pathfinding::hopped(c, hop);
        ++(to.x != c.x && to.y != c.y ? diagonal : straight);
        c = to;
    }
    return -1.0;
}

/// Tables of hops to goals of the scenario; a frame looks up hops from cells all over the map.
class NextHopTrial final : public JudgedTrial {
  public:
    explicit NextHopTrial(const GridScene& scene)
        : scene_(scene),
          instances_(some_of(scene, kNamedGoals)),
          tables_(scene.map) {
        const std::int64_t before = thread_cpu_ns();
        FlowField field;
        for (const GridInstance& i : instances_) {
            field.build(scene.map, i.goal);
            tables_.add(scene.map, field);
        }
        prepared_s_ = static_cast<double>(thread_cpu_ns() - before) * 1e-9;
        core::Rng rng(1);
        for (std::size_t i = 0; i < kLookups; ++i) {
            const auto x = rng.below(static_cast<std::uint32_t>(scene.map.width()));
            const auto y = rng.below(static_cast<std::uint32_t>(scene.map.height()));
            asked_.push_back({rng.below(static_cast<std::uint32_t>(instances_.size())),
                              {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)}});
        }
    }

    void frame() override {
        for (const Asked& a : asked_) {
            sum_ += tables_.hop(a.goal, a.from);
        }
    }

    void judge(Row& row) override {
        std::size_t wrong = 0;
        for (std::size_t g = 0; g < instances_.size(); ++g) {
            const double length = length_along(
                scene_, instances_[g].start, [this, g](Cell c) { return tables_.hop(g, c); });
            wrong += std::abs(length - instances_[g].length) > kLengthTolerance ? 1U : 0U;
        }
        row.error = static_cast<double>(wrong);
        row.error_unit = "wrong";
        row.metric("goals", static_cast<double>(instances_.size()));
        row.metric("preprocess_s", prepared_s_);
        row.metric("index_mib", static_cast<double>(tables_.bytes()) / kMebibyte);
        row.metric("kib_per_goal", static_cast<double>(tables_.bytes_per_goal()) / 1024.0);
    }

  private:
    struct Asked {
        std::size_t goal;
        Cell from;
    };

    const GridScene& scene_;
    std::vector<GridInstance> instances_;
    NextHops tables_;
    std::vector<Asked> asked_;
    double prepared_s_ = 0.0;
    std::uint64_t sum_ = 0;
};

/// A field to another goal in each frame.
class FlowFieldTrial final : public JudgedTrial {
  public:
    explicit FlowFieldTrial(const GridScene& scene)
        : scene_(scene),
          instances_(some_of(scene, kNamedGoals)) {}

    void frame() override {
        field_.build(scene_.map, instances_[turn_++ % instances_.size()].goal);
    }

    void judge(Row& row) override {
        std::size_t wrong = 0;
        for (const GridInstance& i : instances_) {
            field_.build(scene_.map, i.goal);
            const double length = length_along(
                scene_, i.start, [this](Cell c) { return field_.hop(scene_.map.place(c)); });
            wrong += std::abs(length - i.length) > kLengthTolerance ? 1U : 0U;
        }
        row.error = static_cast<double>(wrong);
        row.error_unit = "wrong";
        row.metric("index_mib", static_cast<double>(field_.bytes()) / kMebibyte);
    }

  private:
    const GridScene& scene_;
    std::vector<GridInstance> instances_;
    FlowField field_;
    std::size_t turn_ = 0;
};

}  // namespace

void run_flow_fields(Session& session, const GridScene& scene) {
    const int frames = static_cast<int>(kNamedGoals);
    const int repeats = session.quick ? 1 : session.repeats;
    const auto hops = wanted(session, {{"next_hop", "", [&scene] {
                                            return std::make_unique<NextHopTrial>(scene);
                                        }}});
    const auto fields = wanted(session, {{"goal_field", "", [&scene] {
                                              return std::make_unique<FlowFieldTrial>(scene);
                                          }}});
    if (!hops.empty()) {
        std::vector<Row> rows =
            compare("navigation", scene.name, "", hops, {1, 4 * frames, repeats});
        for (Row& row : rows) {
            row.time_us_p50 /= static_cast<double>(kLookups);
            row.time_us_p99 /= static_cast<double>(kLookups);
            row.metric("lookup_ns", row.time_us_p50 * 1e3);
        }
        session.add(std::move(rows));
    }
    if (!fields.empty()) {
        session.add(compare("navigation", scene.name, "", fields, {1, frames, repeats}));
    }
}

}  // namespace zoned::bench
