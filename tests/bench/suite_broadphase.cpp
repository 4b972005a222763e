// Suite `broadphase`: time to find the overlapping pairs of moving boxes, our structures and
// Bullet's.
#include "tests/bench/comparison.h"
#include "tests/bench/pair_finder.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::bench {

namespace {

/// Boxes of mixed size that fly about and turn back at the walls of their world.
struct Crowd {
    std::string scene;
    std::uint32_t count = 0;
    std::uint32_t one_in = 1;  ///< of so many boxes one moves
    bool flat = false;         ///< all on the ground, else anywhere in a cube

    [[nodiscard]] std::string parameter() const {
        return "n=" + std::to_string(count) +
               (one_in > 1 ? " 1 of " + std::to_string(one_in) + " moves" : " all move");
    }
};

std::vector<Crowd> crowds() {
    std::vector<Crowd> all;
    for (const bool flat : {false, true}) {
        for (const std::uint32_t count : {1000U, 10'000U}) {
            for (const std::uint32_t one_in : {1U, 20U}) {
                all.push_back({flat ? "ground" : "volume", count, one_in, flat});
            }
        }
    }
    return all;
}

constexpr int kFrames = 60;

/// The boxes of every frame, made beforehand so that only the structures are timed.
struct Movie {
    std::vector<std::uint32_t> moved;      ///< rows, ascending
    std::vector<std::vector<Aabb>> boxes;  ///< by frame, then by row
};

/// Most bodies are small and a few are large: sizes are spread evenly over their logarithm, from
/// 0.4 m to 8 m. The world is so large that a box overlaps about two others.
Movie film(const Crowd& crowd) {
    core::Rng rng(crowd.count);
    const auto count = static_cast<float>(crowd.count);
    const float side = crowd.flat ? 4.0F * std::sqrt(count) : 4.0F * std::cbrt(count);

    struct Box {
        Vec3 position, half, velocity;
    };

    std::vector<Box> all(crowd.count);
    Movie movie;
    for (std::uint32_t row = 0; row < crowd.count; ++row) {
        Box& box = all[row];
        const float half = 0.2F * std::pow(20.0F, rng.unit());
        for (int axis = 0; axis < 3; ++axis) {
            box.half[axis] = half * rng.range(0.7F, 1.3F);
            box.position[axis] = rng.range(0.0F, side);
            box.velocity[axis] = rng.range(-5.0F, 5.0F);
        }
        if (crowd.flat) {
            box.position.y() = box.half.y();
            box.velocity.y() = 0.0F;
        }
        if (row % crowd.one_in == 0) {
            movie.moved.push_back(row);
        }
    }
    for (int frame = 0; frame <= kFrames; ++frame) {
        std::vector<Aabb> boxes;
        for (const Box& box : all) {
            boxes.push_back({box.position - box.half, box.position + box.half});
        }
        movie.boxes.push_back(std::move(boxes));
        for (const std::uint32_t row : movie.moved) {
            Box& box = all[row];
            box.position += kStepTime * box.velocity;
            for (int axis = 0; axis < 3; ++axis) {
                if (box.position[axis] < 0.0F || box.position[axis] > side) {
                    box.velocity[axis] = -box.velocity[axis];
                }
            }
        }
    }
    return movie;
}

/// Overlapping pairs with a row that moved, by looking at all.
std::vector<BoxPair> exact_pairs(const Movie& movie, std::size_t frame) {
    const std::vector<Aabb>& boxes = movie.boxes[frame];
    std::vector<std::uint8_t> moves(boxes.size(), 0);
    for (const std::uint32_t row : movie.moved) {
        moves[row] = 1;
    }
    std::vector<BoxPair> pairs;
    for (std::uint32_t a = 0; a < boxes.size(); ++a) {
        for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
            if ((moves[a] != 0 || moves[b] != 0) && boxes[a].overlaps(boxes[b])) {
                pairs.emplace_back(a, b);
            }
        }
    }
    return pairs;
}

class PairTrial : public JudgedTrial {
  public:
    PairTrial(const PairMethod& method, const Movie& movie)
        : movie_(movie),
          finder_(method.build(movie.boxes.front())) {}

    void frame() override { finder_->step(movie_.moved, movie_.boxes[++frame_]); }

    void judge(Row& row) override {
        const std::vector<BoxPair> exact = exact_pairs(movie_, frame_);
        std::vector<BoxPair> found = finder_->pairs();
        std::sort(found.begin(), found.end());
        const bool doubles = std::adjacent_find(found.begin(), found.end()) != found.end();
        std::size_t missing = 0;
        for (const BoxPair& pair : exact) {
            missing += std::binary_search(found.begin(), found.end(), pair) ? 0 : 1;
        }
        row.error = static_cast<double>(missing);
        row.error_unit = "pairs missing";
        row.metric("pairs_exact", static_cast<double>(exact.size()));
        row.metric("pairs_found", static_cast<double>(found.size()));
        row.metric("doubles", doubles ? 1.0 : 0.0);
    }

  private:
    const Movie& movie_;
    std::unique_ptr<PairFinder> finder_;
    std::size_t frame_ = 0;
};

std::vector<PairMethod> all_methods() {
    std::vector<PairMethod> methods = spatial_methods();
    for (const PairMethod& method : bullet_pair_methods()) {
        methods.push_back(method);
    }
    return methods;
}

/// All pairs of many boxes would take too long.
constexpr std::uint32_t kMostForAllPairs = 2000;

void run_crowd(Session& session, const Crowd& crowd) {
    const Movie movie = film(crowd);
    std::vector<Method> methods;
    for (const PairMethod& method : all_methods()) {
        if (method.method != "all_pairs" || crowd.count <= kMostForAllPairs) {
            methods.push_back({method.method, method.peer, [method, &movie] {
                                   return std::make_unique<PairTrial>(method, movie);
                               }});
        }
    }
    methods = wanted(session, std::move(methods));
    if (!methods.empty()) {
        session.progress("broadphase " + crowd.scene + " " + crowd.parameter());
        const Plan plan{0, session.quick ? 6 : kFrames, session.quick ? 1 : session.repeats};
        session.add(compare("broadphase", crowd.scene, crowd.parameter(), methods, plan));
    }
}

void run_broadphase(Session& session) {
    for (const Crowd& crowd : crowds()) {
        const bool large = crowd.count > kMostForAllPairs;
        if (session.wants_scene(crowd.scene) && !(session.quick && large)) {
            run_crowd(session, crowd);
        }
    }
}

std::vector<std::string> broadphase_methods() {
    std::vector<std::string> names;
    for (const PairMethod& method : all_methods()) {
        names.push_back(full_name(method.method, method.peer));
    }
    return names;
}

const Registration kBroadphase({"broadphase",
                                "overlapping pairs of moving boxes of mixed size",
                                {"volume", "ground"},
                                broadphase_methods(),
                                run_broadphase});

}  // namespace

}  // namespace zoned::bench
