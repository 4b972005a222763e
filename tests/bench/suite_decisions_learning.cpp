// Scenes `xor` and `cartpole`: ten seeds are trained, each judged on samples that it never saw. The
// time is that of an evaluation of the first seed's network, in columns.
#include "tests/bench/suite_decisions_learning.h"

#include "server/ai/learning/cart_pole.h"
#include "server/ai/learning/evolution.h"
#include "server/ai/learning/xor_task.h"
#include "tests/bench/comparison.h"
#include "tests/bench/cpu_clock.h"

#include <algorithm>
#include <array>

namespace zoned::bench {

namespace {

namespace learning = ai::learning;

constexpr std::size_t kLearnedAgents = 4096;
constexpr int kLearnSeeds = 10;

struct Lesson {
    const learning::Task* task = nullptr;
    learning::BreedingSettings settings;
    double target = 0.0;  ///< score at which training ends
    std::uint64_t most_generations = 0;
    double full = 0.0;  ///< best possible score: the shortfall from it is the error
    const char* unit = "";
};

/// The result of training ten seeds.
struct Learned {
    learning::NeuralNetwork first;
    double mean_missing = 0.0;
    double worst_missing = 0.0;
    double train_ms_mean = 0.0;
    double train_ms_max = 0.0;
    double generations_mean = 0.0;
    int solved = 0;
};

Learned train(const Lesson& lesson) {
    Learned learned;
    for (std::uint64_t seed = 1; seed <= kLearnSeeds; ++seed) {
        const std::int64_t begin = thread_cpu_ns();
        learning::Evolution evolution(*lesson.task, lesson.settings, seed);
        while (evolution.score() < lesson.target &&
               evolution.generation() < lesson.most_generations) {
            evolution.step(learning::run_here);
        }
        const double ms = static_cast<double>(thread_cpu_ns() - begin) * 1e-6;
        const double score = lesson.task->score(evolution.best(), 1000 + seed);
        learned.mean_missing += (lesson.full - score) / kLearnSeeds;
        learned.worst_missing = std::max(learned.worst_missing, lesson.full - score);
        learned.solved += score >= lesson.task->solved_at() ? 1 : 0;
        learned.train_ms_mean += ms / kLearnSeeds;
        learned.train_ms_max = std::max(learned.train_ms_max, ms);
        learned.generations_mean += static_cast<double>(evolution.generation()) / kLearnSeeds;
        if (seed == 1) {
            learned.first = evolution.best();
        }
    }
    return learned;
}

class LearnTrial final : public JudgedTrial {
  public:
    LearnTrial(const Learned& learned, const char* unit)
        : learned_(learned),
          unit_(unit),
          in_(learned.first.inputs * kLearnedAgents),
          values_(learned.first.values()),
          out_(kLearnedAgents) {
        core::Rng rng(83);
        for (float& value : in_) {
            value = rng.range(-1.0F, 1.0F);
        }
    }

    void frame() override {
        const std::size_t inputs = learned_.first.inputs;
        for (std::size_t i = 0; i < kLearnedAgents; ++i) {
            const auto in = std::span<const float>(in_).subspan(i * inputs, inputs);
            learning::evaluate(learned_.first, in, values_, std::span(&out_[i], 1));
        }
    }

    void judge(Row& row) override {
        row.error = learned_.mean_missing;
        row.error_unit = unit_;
        row.metric("seeds_solved_of_10", learned_.solved);
        row.metric("worst_seed_error", learned_.worst_missing);
        row.metric("train_cpu_ms_mean", learned_.train_ms_mean);
        row.metric("train_cpu_ms_max", learned_.train_ms_max);
        row.metric("generations_mean", learned_.generations_mean);
        row.metric("nodes", static_cast<double>(learned_.first.nodes.size()));
    }

  private:
    const Learned& learned_;
    const char* unit_;
    std::vector<float> in_;  // agent by agent
    std::vector<float> values_;
    std::vector<float> out_;
};

void run_lessons(Session& session,
                 const std::string& scene,
                 const std::vector<std::pair<const char*, Lesson>>& lessons) {
    std::vector<Learned> learned(lessons.size());
    std::vector<Method> methods;
    for (std::size_t k = 0; k < lessons.size(); ++k) {
        if (session.wants_method(lessons[k].first, "")) {
            learned[k] = train(lessons[k].second);
            methods.push_back(
                {lessons[k].first, "", [&learned, &lessons, k]() -> std::unique_ptr<JudgedTrial> {
                     return std::make_unique<LearnTrial>(learned[k], lessons[k].second.unit);
                 }});
        }
    }
    if (methods.empty()) {
        return;
    }
    std::vector<Row> rows =
        compare("decisions",
                scene,
                "",
                methods,
                {1, session.quick ? 2 : 60, session.quick ? 1 : session.repeats});
    for (Row& row : rows) {
        row.time_us_p50 /= static_cast<double>(kLearnedAgents);
        row.time_us_p99 /= static_cast<double>(kLearnedAgents);
    }
    session.add(std::move(rows));
}

}  // namespace

void run_xor(Session& session, const std::string& scene) {
    const learning::XorTask task;
    run_lessons(
        session, scene, {{"default", {&task, learning::NeatSettings{}, 4.0, 300, 4.0, "cases"}}});
}

void run_cartpole(Session& session, const std::string& scene) {
    const learning::CartPoleTask task;
    learning::FixedTopology fixed;
    fixed.shape = learning::dense(std::array<std::size_t, 3>{4, 6, 1});
    const double full = learning::kCartPoleSteps;
    run_lessons(session,
                scene,
                {{"default", {&task, fixed, 499.0, 100, full, "steps"}},
                 {"neat", {&task, learning::NeatSettings{}, 499.0, 100, full, "steps"}}});
}

}  // namespace zoned::bench
