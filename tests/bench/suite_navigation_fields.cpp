#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "tests/bench/comparison.h"
#include "tests/bench/suite_navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::FlowField;
using ai::pathfinding::Hop;
using scenario::GridInstance;

constexpr std::size_t kNamedGoals = 16;
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
    const auto fields = wanted(session, {{"goal_field", "", [&scene] {
                                              return std::make_unique<FlowFieldTrial>(scene);
                                          }}});
    if (!fields.empty()) {
        session.add(compare("navigation", scene.name, "", fields, {1, frames, repeats}));
    }
}

}  // namespace zoned::bench
